"""Measured minus simulated, session by session, in the common band.

Where sessions press at different places, each has a share of its own for every taxel, a factor of no interest to what goes on in time (the
array's own criticism asks how shares follow from places). So it is not an unknown of the model: whatever the model, the taxels of such a
session are scaled to fit it best, in the band and by plain least squares (G. Golub, V. Pereyra, The differentiation of pseudo-inverses and
nonlinear least squares problems whose variables separate, SIAM Journal on Numerical Analysis 10 (1973) 413-432). One taxel in one training
session is the reference, and stays as it is: by it the stiffness under the taxels is known.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.session import Session, motion_under
from skin_models.effect import Effect
from skin_models.model import Model, Response

SHARE = (0.0, 3.0)  # times what was there
SETTLING = 3  # steps of Gauss and Newton
PROBE = 0.01  # of the largest share, for the differences

def simulated(model: Model, session: Session) -> np.ndarray:
    """Simulated channels (C, N) at full rate, rows as in `session.channels`."""
    y = rows(placed(model, session).simulate(motion_under(session, model.dispersion)), session)
    if session.spread is not None and not session.pinned:
        y[-session.n_taxels :] *= own_shares(y, session)[:, None]
    return _beyond(session) + y


def own_shares(y: np.ndarray, session: Session) -> np.ndarray:
    """By what the simulated taxels among channels `y` (C, N) are multiplied to fit the session best, (T,), within `SHARE`."""
    taxels = slice(-session.n_taxels, None)
    Y = session.band.thin(y[taxels])
    beyond = 0.0 if session.beyond is None else session.band.thin(session.beyond[taxels])
    factor = _regression((session.measured[taxels] - beyond)[None], Y, session.weight[taxels])[0]
    return np.where(_kept(session), 1.0, np.clip(factor, *SHARE))


def beside_shares(changes: np.ndarray, y: np.ndarray, session: Session) -> np.ndarray:
    """Changes (K, C, n) of a simulation `y` (C, N), less what shares of the session's own can follow."""
    if session.spread is None or session.pinned:
        return changes
    taxels = slice(-session.n_taxels, None)
    Y = session.band.thin(y[taxels])
    factors = np.where(_kept(session), 0.0, _regression(changes[:, taxels], Y, session.weight[taxels]))
    out = changes.copy()
    out[:, taxels] -= factors[..., None] * Y
    return out


def _regression(rows: np.ndarray, Y: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Slopes (K, T) of `rows` (K, T, n) on `Y` (T, n) with weights (T, n); zero on what is not there."""
    power = np.sum(w * Y**2, axis=1)
    return np.einsum("ktn,tn->kt", rows, w * Y) / np.where(power > 0.0, power, np.inf)


def _kept(session: Session) -> np.ndarray:
    """Which taxels (T,) have the share that `spread` says: the reference, and those that answer nothing."""
    return np.array([i == session.reference or f"taxel_{i}" in session.stuck for i in range(session.n_taxels)])


def settled(model: Model, session: Session) -> Session:
    """The session with the shares that fit it best under `model`: a factor is not enough where taxels bend what they read."""
    if session.spread is None or session.pinned:
        return session
    s, kept, taxels = replace(session, pinned=True), _kept(session), slice(-session.n_taxels, None)
    for _ in range(SETTLING):
        probe = PROBE * s.spread.max()
        y, more = (s.band.thin(simulated(model, each)[taxels]) for each in (s, replace(s, spread=s.spread + probe)))
        change = _regression((s.measured[taxels] - y)[None], (more - y) / probe, s.weight[taxels])[0]
        s = replace(s, spread=np.maximum(s.spread + np.where(kept, 0.0, change), 0.0))
    return replace(s, pinned=False)


def share_rows(model: Model, sessions: list[Session]) -> list[np.ndarray]:
    """d(simulated)/d(share) of every taxel in every session that has shares of its own, (S T, C, n) by session."""
    if sessions[0].spread is None:
        return [np.zeros((0, *s.measured.shape)) for s in sessions]
    count = sessions[0].n_taxels
    every = [np.zeros((len(sessions) * count, *s.measured.shape)) for s in sessions]
    for i, (s, out) in enumerate(zip(sessions, every, strict=True)):
        plain = s.band.thin(simulated(model, replace(s, beyond=None)))
        for j, c in enumerate(range(len(s.channels) - count, len(s.channels))):
            if j != s.reference:
                out[i * count + j, c] = plain[c]
    return every


def placed(model: Model, session: Session) -> Model:
    """The model under the contact of this session: itself, unless sessions press at different places."""
    if session.spread is None:
        return model
    effects = tuple(at_place(e, session) for e in model.effects)
    shares = tuple(float(a * b) for a, b in zip(model.shares, session.spread, strict=True))
    return replace(model, shares=shares, effects=effects)


def at_place(effect: Effect, session: Session) -> Effect:
    """The effect as it is under the contact of this session."""
    moves = session.spread is not None and hasattr(effect, "seen_from")
    return effect.seen_from(session.contact) if moves else effect


def rows(response: Response, session: Session) -> np.ndarray:
    """The channels of a response that the session measured, (C, N); those that are stuck say what they always say."""
    force = [np.atleast_2d(response.force)] if "force" in session.channels else []
    out = np.vstack([*force, response.taxels])
    for channel, level in session.stuck.items():
        out[session.channels.index(channel)] = level
    return out


def _beyond(session: Session) -> np.ndarray | float:
    return 0.0 if session.beyond is None else session.beyond


def residual(model: Model, session: Session) -> np.ndarray:
    """Measured minus simulated (C, n) in the common band, N."""
    return session.measured - session.band.thin(simulated(model, session))


def stiffness(model: Model, channel: str) -> float:
    """What a quick step of depth makes of a channel, N/m: k1 + k2 of the load cell, its share of k1 of a taxel."""
    skin = model.dispersion
    return skin.k1 + skin.k2 if channel == "force" else skin.k1 * model.shares[int(channel.rpartition("_")[2])]


def rmse(residuals: list[np.ndarray], sessions: list[Session]) -> dict[str, float]:
    """Root mean squared error by channel over sessions, N; samples not believed are left out."""
    channels = sessions[0].channels
    square = sum((r**2 * s.weight).sum(axis=1) for r, s in zip(residuals, sessions, strict=True))
    count = sum(s.weight.sum(axis=1) for s in sessions)
    return {c: float(np.sqrt(q / max(n, 1.0))) for c, q, n in zip(channels, square, count, strict=True)}
