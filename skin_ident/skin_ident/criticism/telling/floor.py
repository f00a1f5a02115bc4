"""The noise floor, and whether the residual is clearly above it.

The floor of a session is its residual after every cause of the catalogue has been fitted to this session alone: no model that sessions
share can do better. The residual of the extended model in held-out sessions is compared with the floor of the same sessions, since encoder
steps, or noise that grows with the load, make the floors of sessions differ.

If the search took an error for noise, the error would raise this floor. So the same directions, and delayed copies of the simulated
channels, are also fitted to every other block of a few seconds and predict the blocks between. An error can be predicted so, noise cannot.
The floor is the smaller of the two residuals. Further, the residual in the air is pure noise. Noise under load may be some times as large,
but not many times.

The standard error of a noise level grows with the memory of the noise: for the RMS of n samples with autocorrelation rho it is, relatively,
sqrt(sum(rho^2) / 2 n), summed over all lags (M. S. Bartlett, J. R. Stat. Soc. Suppl. 8 (1946) 27-41).
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from skin_ident.criticism.baseline.residual import pooled_rms, residual, simulated
from skin_ident.criticism.gates.gate import by_block
from skin_ident.criticism.gates.resolution import left_by_steps
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

ROUNDING = 1e-9  # N, RMS below which a residual is rounding error
DOUBTED = 1.25  # ratio to the floor of the session with most data, above which the floor of every session is computed
OTHER_RATE = 1.1  # ratio of sampling periods from which the noise in the common band may differ
WELL_ABOVE = 1.4  # ratio to the floor that is more than noise. In 25 sound sets the largest was 1.2, and 1.1 in fitted sessions
UNSURE = 4.0  # standard errors of the noise level, by which the ratio of residual and floor may be off
LOUDER = 6.0  # ratio of the noise under load to that in the air that is never exceeded
HARDLY = 0.02  # share of the greatest depth below which a test driven by force counts as in the air: noise of the force is as much
AIR_S = 3.0  # s in the air that are needed to know the noise there
TWICE = 2.0  # ratio of held-out to fitted residual that is more than sessions of one rig differ by
BLOCK_S = 4.0  # s, length of the blocks that are fitted and predicted in turn
DELAYS_S = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6)  # s, by which simulated channels are shifted in either direction


def noise_floor(last: Survey, sessions: list[Session]) -> dict[str, dict[str, Any]]:
    """The noise floor by channel in the common band: what any model must leave. To save time, only from the session with most data.

    `rms` N; `lag_one` is the correlation of neighbouring samples.
    """
    longest = max(sessions, key=lambda s: float(s.weight.sum()))
    rest = last.left_by_everything(longest)
    rows = {c: e[w > 0] for c, e, w in zip(longest.channels, rest, longest.weight, strict=True)}
    edge = float(longest.band.edge)
    return {c: {"rms": _rms(e), "unit": "N", "lag_one": _lag_one(e), "band_hz": edge} for c, e in rows.items()}


def predicted_between(last: Survey, session: Session) -> np.ndarray:
    """Residual (C, n) N after directions and delayed copies, fitted to every other block, have predicted the blocks between."""
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
    """Every simulated channel, advanced and delayed by each of `DELAYS_S`, (K, C, n): dynamics outside the catalogue."""
    y = simulated(model, session)
    rows = []
    for shift in (round(sign * d / session.motion.dt) for d in DELAYS_S for sign in (-1, 1)):
        moved = session.band.thin(y[:, np.clip(np.arange(y.shape[1]) - shift, 0, y.shape[1] - 1)])
        rows += [moved[c] * np.eye(len(y))[c][:, None] for c in range(len(y))]
    return np.array(rows)


def floor_of_all(c: Criticism, floor: dict[str, dict[str, Any]], left: dict[str, float]) -> dict[str, dict[str, Any]]:
    """The floor; recomputed from all tested sessions where the residual `left` (N by channel) is doubtful against that of the session with
    most data, or where sessions were sampled at other rates: of the same converter, the slower leaves more noise in the common band."""
    tested, periods = list(c.held or c.train), [s.period for s in (*c.train, *c.held)]
    of_one_rate = max(periods) < OTHER_RATE * min(periods)
    if of_one_rate and all(rms <= DOUBTED * max(floor[channel]["rms"], ROUNDING) for channel, rms in left.items()):
        return floor
    fitted = pooled_rms([c.last.left_by_everything(s) for s in tested], tested)
    between = pooled_rms([predicted_between(c.last, s) for s in tested], tested)
    return {name: {**floor[name], "rms": float(rms)} for name, rms in zip(floor, np.minimum(fitted, between), strict=True)}


def left_beside(c: Criticism, floor: dict[str, dict[str, Any]], left: dict[str, float]) -> dict[str, float]:
    """The held-out residual `left` (RMS, N, by channel). Where it is clearly above the floor, the part that training leaves uncertain is
    removed."""
    if not c.held or all(rms <= WELL_ABOVE * max(floor[channel]["rms"], ROUNDING) for channel, rms in left.items()):
        return left
    tested, noise = list(c.held), c.last.noise
    rests = beside_uncertainty([residual(c.extended.model, s) for s in tested], c.last.model, list(c.train), tested, noise)
    return {name: min(left[name], float(rms)) for name, rms in zip(tested[0].channels, pooled_rms(rests, tested), strict=True)}


def beyond_noise(
    c: Criticism, floor: dict[str, dict[str, Any]], left: dict[str, float], symptoms: Iterable[Symptom], encoder_step: float
) -> dict[str, float]:
    """The channels whose residual is more than noise, with its ratio to the least that noise leaves. Held-out sessions (`left`, N) are
    compared with the floor, or with what fitted sessions leave if that is less; fitted sessions with their own floor.

    A channel does not count if it has a fault of the record that no model predicts, if the excess is one accident, if it is within the
    steps of converter or encoder, or if it is so small beside the named causes that it may be their own imperfect form.
    """
    tested, train = list(c.held or c.train), list(c.train)
    limit = WELL_ABOVE * (1.0 + UNSURE * _doubt(c.last.noise, tested))
    most = _loudest(c) / limit
    fitted, least_fitted = _fitted(c, floor)
    least_held = np.minimum([floor[channel]["rms"] for channel in left], fitted * _louder(c) * TWICE / WELL_ABOVE)
    open_to_steps = np.array([left_by_steps(c.extended.model, channel, tested, encoder_step) for channel in left])
    unnamed = np.maximum(SHADOW * max((n.gain.squares for n in c.named), default=0.0), open_to_steps**2)

    def times(rms: np.ndarray, sessions: list[Session], least: np.ndarray) -> np.ndarray:
        """Ratio (C,) of the residual of `sessions` to the least that noise leaves of them; 0 where it is not well above that."""
        rms, least = rms * _but_for_the_worst(c, sessions), np.minimum(least, most)
        much = (rms > limit * np.maximum(least, ROUNDING)) & (rms**2 - least**2 > unnamed)
        return np.where(much, rms / np.maximum(least, ROUNDING), 0.0)

    above = np.maximum(times(np.array([*left.values()]), tested, least_held), times(fitted, train, least_fitted))
    random = {channel for s in symptoms if s.cause not in PREDICTS for channel in s.channels}
    return {channel: float(x) for channel, x in zip(left, above, strict=True) if x > 0.0 and channel not in random}


def _doubt(noise: Whitener, sessions: list[Session]) -> np.ndarray:
    """Relative standard error (C,) of the RMS of each channel's noise in the sessions."""
    n = sum(np.count_nonzero(s.weight, axis=1) for s in sessions)
    return np.sqrt(noise.lasting() / (2.0 * np.maximum(n, 1)))


def _louder(c: Criticism) -> np.ndarray:
    """Ratio (C,), at least 1, of each channel's noise in held-out sessions to that in fitted ones, where noise grows with the load."""
    held, train = (
        np.sqrt(np.mean(np.concatenate([c.last.noise.growth.loudness(s) for s in each], axis=1) ** 2, axis=1))
        for each in (list(c.held or c.train), list(c.train))
    )
    return np.maximum(held / train, 1.0)


def _loudest(c: Criticism) -> np.ndarray:
    """Upper bound of each channel's noise (C,), N, from the residual in the air; inf where there is too little air. The converter's step is
    added: if it is coarser than the noise, the air shows no noise."""
    model, sessions = c.extended.model, [*c.train, *c.held]
    in_air = [replace(s, weight=s.weight * _in_the_air(model, s)) for s in sessions]
    seconds = sum(np.count_nonzero(s.weight, axis=1) * s.band.spacing for s in in_air)
    steps = np.max([s.steps for s in sessions], axis=0)
    rms = pooled_rms([residual(model, s) for s in sessions], in_air)
    return np.where(seconds > AIR_S, LOUDER * np.hypot(rms, steps), np.inf)


def _in_the_air(model: Model, s: Session) -> np.ndarray:
    """Mask (n,) of the samples at which the plunger does not touch the skin, or hardly presses it where force drives the test."""
    moved = motion_under(s, model.dispersion)
    touched = model.dispersion.contact(moved) > 0.0 if s.drive is None else moved.x > HARDLY * moved.x.max()
    return np.interp(s.t, moved.t, touched.astype(float)) == 0.0


def _fitted(c: Criticism, floor: dict[str, dict[str, Any]]) -> tuple[np.ndarray, np.ndarray]:
    """RMS residual (C,) N of the fitted sessions, and where that is doubtful, their floor, with every cause fitted to each of them
    alone."""
    sessions = list(c.train)
    fitted = pooled_rms([residual(c.extended.model, s) for s in sessions], sessions)
    if all(rms <= DOUBTED * max(low["rms"], ROUNDING) for rms, low in zip(fitted, floor.values(), strict=True)):
        return fitted, fitted
    return fitted, pooled_rms([c.last.left_by_everything(s) for s in sessions], sessions)


def _but_for_the_worst(c: Criticism, sessions: list[Session]) -> np.ndarray:
    """Ratio (C,) of the RMS residual without its worst two seconds to that with them: a spike is an accident and no error of the model."""
    squares = np.concatenate([by_block(residual(c.extended.model, s) ** 2 * s.weight, s) for s in sessions], axis=-1)
    share = squares.max(axis=-1) / np.maximum(squares.sum(axis=-1), 1e-300)
    return np.sqrt((1.0 - share) / (1.0 - 1.0 / max(squares.shape[-1], 2)))


def _rms(e: np.ndarray) -> float:
    rms = float(np.sqrt(np.mean(e**2))) if e.size else 0.0
    return rms if rms > ROUNDING else 0.0


def _lag_one(e: np.ndarray) -> float:
    return float(np.corrcoef(e[1:], e[:-1])[0, 1]) if e.size > 2 and np.ptp(e) > 0.0 else 0.0
