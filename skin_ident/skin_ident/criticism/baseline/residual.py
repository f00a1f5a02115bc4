"""Measured minus simulated, session by session, in the common band."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.own_shares import has_own, own_shares
from skin_ident.criticism.sessions.session import Session, motion_under
from skin_models.effect import Effect, Place
from skin_models.model import Model, Response


def simulated(model: Model, session: Session) -> np.ndarray:
    """Simulated channels (C, N) at full rate, rows as in `session.channels`, with the session's own shares where it has some."""
    return _told(placed(model, session).simulate(motion_under(session, model.dispersion)), session)


def simulated_again(model: Model, changed: list[tuple[Model, Place | None]], session: Session) -> tuple[np.ndarray, Iterator[np.ndarray]]:
    """`simulated` of a model, and of variants that each differ from it at one place of the chain (None: anywhere). A variant is recomputed
    only from that place on."""
    run = placed(model, session).trace(motion_under(session, model.dispersion))
    others = (simulated(m, session) if p is None else _told(placed(m, session).again(run, p), session) for m, p in changed)
    return _told(run.response, session), others


def placed(model: Model, session: Session) -> Model:
    """The model as it holds in this session: with the session's own skin, without the effects it lacks, and with shares and effects as seen
    from its contact where sessions press at different places."""
    if session.skin:
        own = {name: factor * getattr(model.dispersion, name) for name, factor in session.skin.items()}
        model = replace(model, dispersion=replace(model.dispersion, **own))
    if session.lacks:
        model = model.lacking(*session.lacks)
    if session.spread is None:
        return model
    effects = tuple(at_place(e, session) for e in model.effects)
    shares = tuple(float(a * b) for a, b in zip(model.shares, session.spread, strict=True))
    return replace(model, shares=shares, effects=effects)


def at_place(effect: Effect, session: Session) -> Effect:
    """The effect as seen from the contact of this session."""
    moves = session.spread is not None and hasattr(effect, "seen_from")
    return effect.seen_from(session.contact) if moves else effect


def rows(response: Response, session: Session) -> np.ndarray:
    """The channels of a response that the session measured, (C, N); stuck ones at their constant reading."""
    out = np.empty((len(session.channels), response.taxels.shape[-1]))
    out[session.taxel_rows] = response.taxels
    if "force" in session.channels:
        out[session.channels.index("force")] = response.force
    for channel, level in session.stuck.items():
        out[session.channels.index(channel)] = level
    return out


def _told(response: Response, session: Session) -> np.ndarray:
    """The simulated channels of a session: with its own shares, with the inertia of a mass that hangs on the load cell, and with what it
    has `beyond` the model (a twin, courses) added."""
    y = rows(response, session)
    if session.hung:
        y[session.channels.index("force")] += session.hung * session.motion.a
    if has_own(session):
        y[session.taxel_rows] *= own_shares(y, session)[:, None]
    return y if session.beyond is None else session.beyond + y


def residual(model: Model, session: Session) -> np.ndarray:
    """Measured minus simulated (C, n) in the common band, N."""
    return session.measured - session.band.thin(simulated(model, session))


def stiffness(model: Model, channel: str) -> float:
    """Stiffness that a channel shows to a quick step of depth, N/m: k1 + k2 for the load cell, its share of k1 for a taxel."""
    return _of_channel(model, channel, model.dispersion.k1, model.dispersion.k2)


def damping(model: Model, channel: str) -> float:
    """Damping that a channel shows, N*s/m: b1 + b2 for the load cell, its share of b1 for a taxel."""
    return _of_channel(model, channel, model.dispersion.b1, model.dispersion.b2)


def _of_channel(model: Model, channel: str, sensed: float, dispersed: float) -> float:
    return sensed + dispersed if channel == "force" else sensed * model.shares[int(channel.rpartition("_")[2])]


def rmse(residuals: list[np.ndarray], sessions: list[Session]) -> dict[str, float]:
    """Root mean squared error by channel, N, of residuals [(C, n), …] over sessions (see `pooled_rms`)."""
    return dict(zip(sessions[0].channels, map(float, pooled_rms(residuals, sessions)), strict=True))


def pooled_rms(residuals: list[np.ndarray], sessions: list[Session]) -> np.ndarray:
    """Root mean square of every channel, (C,) N, of residuals [(C, n), …] over sessions; samples of weight 0 are left out."""
    squares = sum((r**2 * s.weight).sum(axis=1) for r, s in zip(residuals, sessions, strict=True))
    return np.sqrt(squares / np.maximum(sum(s.weight.sum(axis=1) for s in sessions), 1.0))
