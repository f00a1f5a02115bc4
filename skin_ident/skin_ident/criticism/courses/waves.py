"""Waves: a zero or slope that wanders slowly and smoothly throughout a session, for example with the temperature of the room.

An autoregressive noise model takes a wave for noise of long memory, and the description length hardly objects, since a filter predicts a
smooth signal from its last samples. The spectrum over whole sessions does tell the two apart. With the cosines of a session of length T, k
half periods to the session, noise of any memory has

    E z_k^2 <= a + b / k^2,    z_k = sum e(t) D(t) cos(pi k t / T),

since a random walk is the roughest process that wanders without end, and every other one grows more slowly towards k = 0. The line a + b /
k^2 is fitted to the cosines k = 8 … 50, as high as these allow; power of the lowest seven above that line is not noise. It is a wave of one
sensor if it is also there in held-out sessions, if it is a good part of the channel's error, if no other channel has the same, and if it
does not follow the motion.

Source: for cosines as the eigenfunctions of slow random processes, N. Ahmed, T. Natarajan, K. Rao, IEEE Transactions on Computers C-23
(1974) 90-93.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.baseline.residual import residual, simulated
from skin_ident.criticism.courses.carriers import SLOPE, ZERO
from skin_ident.criticism.courses.kinds import WAVE, Course
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.gates.gate import Gain, gain_of_residuals
from skin_ident.criticism.gates.uncertain import beside_uncertainty
from skin_ident.criticism.noise.whitening import Given, Whitener, fit_whitener
from skin_ident.criticism.said import Said
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.telemetry.symptom import sensor_of
from skin_models.model import Model
from skin_models.operators.lagging import lagged

LOW, HIGH = 7, 50  # half periods per session: the most of a wave, and of the cosines to which the line is fitted
SHORTEST_S = 2.8  # the shortest period of a wave, s
LASTS_S = 9.5  # s, that a session must last: waves were not tested on shorter ones
FEWEST = 3  # cosines for the line per cosine of a wave, at least
SLOPES = np.concatenate([[0.0], np.geomspace(1.0, 1e5, 41)])  # grid of b / a
DOUBT = 2.5  # nats by which a line may be less likely than the best one and still be allowed
# Power of a wave over the line, at least. Of 2640 sound records with eleven kinds of noise the largest ratio was 1.7, with a doubt of 4
# nats. For slopes, whose line the motion bends, one short record in hundreds had 4.5 with the doubt above.
EXCESS = {ZERO: 4.0, SLOPE: 6.0}
GOOD_PART = 0.2  # share of the channel's plain RMS error that a wave must remove
# Correlation with the wave of another channel from which both are the same, if that has this share of the required excess and part.
ALIKE, HALF = 0.7, 0.5
LOCKED = 0.75  # share of a wave's mean square that the motion must not explain
WHOLE = 0.7  # share of a session's samples that must be trusted


@dataclass(frozen=True)
class Wave:
    """A wave in one channel: its power over the noise line in training and in held-out sessions (`excess`), its `values` (C, N) N, and the
    share of the plain error that it removes (`parts`), both by session."""

    course: Course
    excess: tuple[float, float]
    values: dict[str, np.ndarray]
    parts: dict[str, float]

    @property
    def part(self) -> float:
        """The smallest share over all sessions."""
        return min(self.parts.values())


def find_wave(model: Model, train: list[Session], held: list[Session], noise: Whitener) -> tuple[Wave, Gain] | None:
    """The wave that removes most of a channel's error, with its gain in held-out sessions; None if there is none."""
    sessions = [*train, *held]
    if not held or any(np.mean(s.weight > 0.0) < WHOLE or np.ptp(s.motion.t) < LASTS_S for s in sessions):
        return None
    left = beside_uncertainty([residual(model, s) for s in held], model, train, held, noise)
    e = [*(residual(model, s) for s in train), *left]
    simulations = [simulated(model, s) for s in sessions]
    every = [w for w in (_wave(c, simulations, sessions, e, len(train)) for c in _courses(sessions[0])) if w]
    able = [w for w in every if min(w.excess) > EXCESS[w.course.carrier] and w.part > GOOD_PART]
    able = [w for w in able if not any(_same(w, other, sessions) for other in every) and not _locked(w, sessions)]
    if not able:
        return None
    best = max(able, key=lambda w: w.part)
    after = [x - s.band.thin(best.values[s.name]) for x, s in zip(e, sessions, strict=True)][len(train) :]
    colour = fit_whitener(after, held, given=Given(grows=noise.growth))
    return best, gain_of_residuals(e[len(train) :], after, held, colour, ", ".join(s.name for s in held))


def run_of(wave: Wave, model: Model, sessions: list[Session], score: float) -> Run:
    """The wave as a course (`Run`) of `sessions`."""
    said = {s.name: _said(wave.course, model, s, wave.values[s.name]) for s in sessions}
    values = {s.name: wave.values[s.name] for s in sessions}
    return Run(wave.course, score, 0.0, max(float(np.abs(v).max()) for v in values.values()), values, said, sessions[0].longest_period)


def _courses(session: Session) -> Iterator[Course]:
    for c, channel in enumerate(session.channels):
        if channel not in session.stuck:
            yield from (Course(carrier, WAVE, (c,), sensor_of(channel, session.n_taxels)) for carrier in (ZERO, SLOPE))


def _wave(course: Course, simulations: list[np.ndarray], sessions: list[Session], e: list[np.ndarray], training: int) -> Wave | None:
    """The wave of a channel, fitted to the residuals `e` (C, n) N of all sessions, of which the first `training` are for training; None
    where they are too short."""
    low = min(LOW, *(int(2.0 * np.ptp(s.motion.t) / SHORTEST_S) for s in sessions))
    high = min(HIGH, *(s.t.size // 5 for s in sessions))
    if high < (FEWEST + 1) * low or low < 2:
        return None
    each = [_of_session(course, s, plain, x, low, high) for s, plain, x in zip(sessions, simulations, e, strict=True)]
    z = np.array([amounts for amounts, _, _ in each])
    usual = _line(z**2, low)
    over = [np.mean(c[:low] ** 2 / usual) for c in z]
    values, parts = ({s.name: own[i] for s, own in zip(sessions, each, strict=True)} for i in (1, 2))
    return Wave(course, (float(np.mean(over[:training])), float(np.mean(over[training:]))), values, parts)


def _of_session(course: Course, s: Session, plain: np.ndarray, e: np.ndarray, low: int, high: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Amounts of the `high` cosines in a channel's residual (in units of white noise; those beyond the first `low` beside these), the wave
    made of the first `low` (C, N) N, and the share of the error that it removes."""
    row, good = course.rows[0], s.weight[course.rows[0]] > 0.0
    full = plain[row] if course.carrier == SLOPE else np.ones_like(plain[row])
    D, y = s.band.thin(full)[good], e[row][good]
    cosines, bent = _shapes(s.t[good], s, high)
    below = np.concatenate([cosines[: low + 1], bent]) * D
    amounts = np.linalg.lstsq(below.T, y, rcond=1e-6)[0]
    level, left = D * (D @ y) / max(D @ D, 1e-300), y - amounts @ below
    z = np.concatenate([_matched(y - level, cosines[1 : low + 1] * D), _matched(left, cosines[low + 1 :] * D)])
    values = np.zeros_like(s.raw)
    values[row] = amounts @ np.concatenate([part[: low + 1] for part in _shapes(s.motion.t, s, low)]) * full
    return z, values, 1.0 - float(np.sqrt(np.sum(left**2) / max(np.sum(y**2), 1e-300)))


def _shapes(t: np.ndarray, s: Session, most: int) -> tuple[np.ndarray, np.ndarray]:
    """Cosines with 0 to `most` half periods per session, and the line and parabola that account for slopes at the ends."""
    u = (t - s.motion.t[0]) / np.ptp(s.motion.t)
    return np.cos(np.pi * np.arange(most + 1)[:, None] * u), np.array([u - 0.5, (u - 0.5) ** 2])


def _matched(y: np.ndarray, rows: np.ndarray) -> np.ndarray:
    return rows @ y / np.sqrt(np.maximum(np.sum(rows**2, axis=1), 1e-300))


def _line(squares: np.ndarray, low: int) -> np.ndarray:
    """The highest line a + b / k^2 (low,) that is compatible with the squares (S, K) beyond the first `low`."""
    k = np.arange(1.0, squares.shape[1] + 1.0)
    shapes = 1.0 + SLOPES[:, None] / k**2
    sizes = np.mean(squares[:, None, low:] / shapes[:, low:], axis=(0, 2))
    lines = np.maximum(sizes[:, None], 1e-300) * shapes
    unlikely = 0.5 * len(squares) * np.sum(np.log(lines[:, low:]), axis=1)
    return lines[unlikely < unlikely.min() + DOUBT, :low].max(axis=0)


def _same(one: Wave, other: Wave, sessions: list[Session]) -> bool:
    """Whether another channel has the same wave, so that it does not belong to one sensor."""
    least = EXCESS[other.course.carrier]
    if one.course.rows == other.course.rows or min(other.excess) < HALF * least or other.part < HALF * GOOD_PART:
        return False
    a, b = (np.concatenate([w.values[s.name][w.course.rows[0]] for s in sessions]) for w in (one, other))
    return bool(np.abs(a @ b) > ALIKE * np.sqrt((a @ a) * (b @ b)))


def _locked(wave: Wave, sessions: list[Session]) -> bool:
    """Whether the wave follows depth or speed with the same coefficients in all sessions: then it belongs to skin or rig."""
    row = wave.course.rows[0]
    w = np.concatenate([wave.values[s.name][row] - wave.values[s.name][row].mean() for s in sessions])
    with_motion = np.concatenate([_slow(_moved(s), s) for s in sessions], axis=1)
    rest = w - np.linalg.lstsq(with_motion.T, w, rcond=1e-8)[0] @ with_motion
    return bool(rest @ rest < (1.0 - LOCKED) * (w @ w))


def _moved(s: Session) -> np.ndarray:
    """Depth, its square, speed, the greatest depth so far and the low-passed depth, (5, N), each scaled to order one."""
    x = np.maximum(s.motion.x, 0.0) / max(float(s.motion.x.max()), 1e-12)
    v = s.motion.v * (s.motion.x > 0.0) / max(float(np.abs(s.motion.v).max()), 1e-12)
    return np.array([x, x**2, v, np.maximum.accumulate(x), lagged(x, np.ptp(s.motion.t) / 5.0, s.motion.dt)])


def _slow(rows: np.ndarray, s: Session) -> np.ndarray:
    """Projection of rows (K, N) on the shapes of waves, less their mean."""
    shapes = np.concatenate(_shapes(s.motion.t, s, LOW))
    slow = np.linalg.lstsq(shapes.T, rows.T, rcond=1e-8)[0].T @ shapes
    return slow - slow.mean(axis=1, keepdims=True)


def _said(course: Course, model: Model, s: Session, values: np.ndarray) -> Said:
    """The range over which a session wanders, in words and numbers."""
    row, of_slope = values[course.rows[0]], course.carrier == SLOPE
    if of_slope:
        own = simulated(model, s)[course.rows[0]]
        loaded = np.abs(own) > 0.3 * np.abs(own).max()
        row = np.where(loaded, row / np.where(loaded, own, 1.0), 0.0)
    at = np.sort([np.argmin(row), np.argmax(row)])
    first, last = row[at]
    words = f"{1e2 * first:+.2g} to {1e2 * last:+.2g} %" if of_slope else f"{first:+.3g} to {last:+.3g} N"
    return Said.of(f"wanders from {words}", (first, last), "1" if of_slope else "N", s.motion.t[at], crept=True)
