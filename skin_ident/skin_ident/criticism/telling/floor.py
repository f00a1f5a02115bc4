"""What noise alone leaves, and whether more than that is left.

The floor of a session is its residual less everything that any cause of the catalogue may explain in this session alone: no model that
sessions share can do better. What the extended model leaves of sessions that did not fit it is held against the floor of the same
sessions, for an encoder's steps or a noise that grows with load make one session's floor another's mountain.

Noise as large as the wrong itself would be taken for the floor where the search took it for noise. So the same directions, and delayed
copies of what is simulated, are also fitted to every other few seconds of the session and predict what is between, which no noise lets
them do; the floor is the lower of the two. And while the plunger is in the air there is nothing but noise: that of a channel under load may
be some times as large, but not many times.

How large noise is, a record shows the worse the longer the memory of that is: of the RMS of n samples whose correlations are rho at all
lags the relative standard error is sqrt(sum(rho^2) / 2 n) (M. S. Bartlett, J. R. Stat. Soc. Suppl. 8 (1946) 27-41).
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from skin_ident.criticism.baseline.residual import residual, simulated
from skin_ident.criticism.gates.gate import by_block
from skin_ident.criticism.gates.resolution import AT_FEW_DEPTHS, RESOLVED, unread_force
from skin_ident.criticism.gates.uncertain import beside_uncertainty
from skin_ident.criticism.noise.estimate import less
from skin_ident.criticism.noise.whitening import Stacked, Whitener, white
from skin_ident.criticism.search.named import Criticism
from skin_ident.criticism.search.survey import Survey
from skin_ident.criticism.sessions.session import Session, motion_under
from skin_ident.criticism.telemetry.faults import PREDICTS
from skin_ident.criticism.telemetry.symptom import Symptom
from skin_ident.criticism.telling.leftover import SHADOW
from skin_models.model import Model

ROUNDING = 1e-9  # N
DOUBTED = 1.25  # times the floor of the session that tells most, from which the floor of every session is looked at
WELL_ABOVE = 1.4  # times the floor of the very sessions: more than noise. Of 25 sound sets the most had 1.2, of what was fitted 1.1
UNSURE = 4.0  # standard errors of how loud noise is, by which floor and rest together may be off
LOUDER = 6.0  # times the noise of the air: so much does no load make of it
HARDLY = 0.02  # of the greatest depth: noise of the force that drives a test is as much
AIR_S = 3.0  # of the air, that tell its noise
TWICE = 2.0  # times what is left of what was fitted: more than sessions of one rig differ by
BLOCK_S = 4.0  # by which a session is fitted and predicted in turns
DELAYS_S = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6)  # by which simulated channels are shifted, to and fro


def noise_floor(last: Survey, sessions: list[Session]) -> dict[str, dict[str, Any]]:
    """By channel, what noise alone leaves in the common band, from the session that tells most, for time's sake.

    It bounds what any model can gain. `rms` N; `lag_one` is the correlation of neighbouring samples.
    """
    longest = max(sessions, key=lambda s: float(s.weight.sum()))
    rest = last.left_by_everything(longest)
    rows = {c: e[w > 0] for c, e, w in zip(longest.channels, rest, longest.weight, strict=True)}
    edge = float(longest.band.edge)
    return {c: {"rms": _rms(e), "unit": "N", "lag_one": _lag_one(e), "band_hz": edge} for c, e in rows.items()}


def predicted_between(last: Survey, session: Session) -> np.ndarray:
    """What is left (C, n) N where directions and delayed copies, fitted to every other block, predict the blocks between."""
    every, own = last.directions_of(session)
    every = np.concatenate([every, _delayed(last.model, session)])
    e = residual(last.model, session)
    odd = ((session.t - session.t[0]) / BLOCK_S).astype(int) % 2
    out = e.copy()
    for side in (0, 1):
        seen = replace(session, weight=session.weight * (odd == side))
        out[:, odd != side] = less([e], Stacked([every], [seen]), own, white([e]))[0][:, odd != side]
    return out


def _delayed(model: Model, session: Session) -> np.ndarray:
    """Every simulated channel, earlier and later by each of `DELAYS_S`, (K, C, n): dynamics that no catalogue holds."""
    y = simulated(model, session)
    rows = []
    for shift in (round(sign * d / session.motion.dt) for d in DELAYS_S for sign in (-1, 1)):
        moved = session.band.thin(y[:, np.clip(np.arange(y.shape[1]) - shift, 0, y.shape[1] - 1)])
        rows += [moved[c] * np.eye(len(y))[c][:, None] for c in range(len(y))]
    return np.array(rows)


def floor_of_all(c: Criticism, floor: dict[str, dict[str, Any]], left: dict[str, float]) -> dict[str, dict[str, Any]]:
    """The floor, from every session that was tested where `left` (N by channel) is doubtful beside that of the one that tells most."""
    if all(rms <= DOUBTED * max(floor[channel]["rms"], ROUNDING) for channel, rms in left.items()):
        return floor
    tested = list(c.held or c.train)
    fitted = _pooled([c.last.left_by_everything(s) for s in tested], tested)
    between = _pooled([predicted_between(c.last, s) for s in tested], tested)
    return {name: {**floor[name], "rms": float(rms)} for name, rms in zip(floor, np.minimum(fitted, between), strict=True)}


def left_beside(c: Criticism, floor: dict[str, dict[str, Any]], left: dict[str, float]) -> dict[str, float]:
    """What is `left` (N, held out, by channel); where that is clearly above the floor, beside what training leaves uncertain."""
    if not c.held or all(rms <= WELL_ABOVE * max(floor[channel]["rms"], ROUNDING) for channel, rms in left.items()):
        return left
    tested, noise = list(c.held), c.last.noise
    rests = beside_uncertainty([residual(c.extended.model, s) for s in tested], c.last.model, list(c.train), tested, noise)
    return {name: min(left[name], float(rms)) for name, rms in zip(tested[0].channels, _pooled(rests, tested), strict=True)}


def _pooled(rests: list[np.ndarray], sessions: list[Session]) -> np.ndarray:
    squares = sum((e**2 * s.weight).sum(axis=1) for e, s in zip(rests, sessions, strict=True))
    return np.sqrt(squares / np.maximum(sum(s.weight.sum(axis=1) for s in sessions), 1.0))


def beyond_noise(
    c: Criticism, floor: dict[str, dict[str, Any]], left: dict[str, float], symptoms: Iterable[Symptom], encoder_step: float
) -> dict[str, float]:
    """Channels of which more is `left` (N, held out) than noise can leave, and how many times the floor that is, or where that is less
    what is left of the sessions that were fitted; and those of which more is left of the sessions that were fitted.

    Not so where a fault of the record is in the channel that nothing predicts, where the excess is one accident, within the steps of
    converter or encoder, or beside the named causes so small that it may be their own imperfect form.
    """
    tested, train = list(c.held or c.train), list(c.train)
    limit = WELL_ABOVE * (1.0 + UNSURE * _doubt(c.last.noise, tested))
    most = _loudest(c) / limit
    fitted, least_fitted = _fitted(c, floor)
    least_held = np.minimum([floor[channel]["rms"] for channel in left], fitted * _louder(c) * TWICE / WELL_ABOVE)
    open_to_steps = np.array([_resolution(c, i, channel, encoder_step) for i, channel in enumerate(left)])
    unnamed = np.maximum(SHADOW * max((n.gain.squares for n in c.named), default=0.0), open_to_steps**2)

    def times(rms: np.ndarray, sessions: list[Session], least: np.ndarray) -> np.ndarray:
        """How many times (C,) what is left of sessions is the least that noise leaves of them; 0 where that is not well above it."""
        rms, least = rms * _but_for_the_worst(c, sessions), np.minimum(least, most)
        much = (rms > limit * np.maximum(least, ROUNDING)) & (rms**2 - least**2 > unnamed)
        return np.where(much, rms / np.maximum(least, ROUNDING), 0.0)

    above = np.maximum(times(np.array([*left.values()]), tested, least_held), times(fitted, train, least_fitted))
    random = {channel for s in symptoms if s.cause not in PREDICTS for channel in s.channels}
    return {channel: float(x) for channel, x in zip(left, above, strict=True) if x > 0.0 and channel not in random}


def _doubt(noise: Whitener, sessions: list[Session]) -> np.ndarray:
    """Relative standard error (C,) of the RMS of each channel's noise in sessions."""
    n = sum(np.count_nonzero(s.weight, axis=1) for s in sessions)
    return np.sqrt(noise.lasting() / (2.0 * np.maximum(n, 1)))


def _louder(c: Criticism) -> np.ndarray:
    """How many times louder each channel's noise (C,) is in held-out sessions than in those that were fitted, where it grows with the load;
    1 where it is not."""
    held, train = (
        np.sqrt(np.mean(np.concatenate([c.last.noise.growth.loudness(s) for s in each], axis=1) ** 2, axis=1))
        for each in (list(c.held or c.train), list(c.train))
    )
    return np.maximum(held / train, 1.0)


def _loudest(c: Criticism) -> np.ndarray:
    """The most that noise may leave of each channel (C,) N, by what is left of it in the air; anything where there is too little of that. A
    converter coarser than the noise shows none of it there."""
    model, sessions = c.extended.model, [*c.train, *c.held]
    in_air = [replace(s, weight=s.weight * _in_the_air(model, s)) for s in sessions]
    seconds = sum(np.count_nonzero(s.weight, axis=1) * s.band.spacing for s in in_air)
    steps = np.max([s.steps for s in sessions], axis=0)
    rms = _pooled([residual(model, s) for s in sessions], in_air)
    return np.where(seconds > AIR_S, LOUDER * np.hypot(rms, steps), np.inf)


def _in_the_air(model: Model, s: Session) -> np.ndarray:
    """Mask (n,) of the samples in which the plunger does not touch the skin; where force drives the test, hardly presses it."""
    moved = motion_under(s, model.dispersion)
    touched = model.dispersion.contact(moved) > 0.0 if s.drive is None else moved.x > HARDLY * moved.x.max()
    return np.interp(s.t, moved.t, touched.astype(float)) == 0.0


def _fitted(c: Criticism, floor: dict[str, dict[str, Any]]) -> tuple[np.ndarray, np.ndarray]:
    """What is left (C,) N of the sessions that were fitted, and where that is doubtful what is left where every cause may bend each of
    them by itself."""
    sessions = list(c.train)
    fitted = _pooled([residual(c.extended.model, s) for s in sessions], sessions)
    if all(rms <= DOUBTED * max(low["rms"], ROUNDING) for rms, low in zip(fitted, floor.values(), strict=True)):
        return fitted, fitted
    return fitted, _pooled([c.last.left_by_everything(s) for s in sessions], sessions)


def _but_for_the_worst(c: Criticism, sessions: list[Session]) -> np.ndarray:
    """What is left in each channel (C,) of sessions without the two seconds that leave most, over all that is left (RMS): a spike is an
    accident, and no sign that the model is wrong."""
    squares = np.concatenate([by_block(residual(c.extended.model, s) ** 2 * s.weight, s) for s in sessions], axis=-1)
    share = squares.max(axis=-1) / np.maximum(squares.sum(axis=-1), 1e-300)
    return np.sqrt((1.0 - share) / (1.0 - 1.0 / max(squares.shape[-1], 2)))


def _resolution(c: Criticism, i: int, channel: str, encoder_step: float) -> float:
    """What steps of converter and encoder may leave open in a channel, N."""
    unread = unread_force(c.extended.model, channel, list(c.held or c.train), encoder_step)
    return float(np.hypot(RESOLVED * c.train[0].steps[i], np.sqrt(AT_FEW_DEPTHS) * unread))


def _rms(e: np.ndarray) -> float:
    rms = float(np.sqrt(np.mean(e**2))) if e.size else 0.0
    return rms if rms > ROUNDING else 0.0


def _lag_one(e: np.ndarray) -> float:
    return float(np.corrcoef(e[1:], e[:-1])[0, 1]) if e.size > 2 and np.ptp(e) > 0.0 else 0.0
