"""Waves: a zero, or a slope, that wanders slowly and smoothly as long as a session lasts, as with the temperature of a room.

To the noise model a wave is noise of long memory, and to a description of the record in the fewest words hardly more: a filter foretells
what is smooth from its last samples. What tells them apart is the spectrum over whole sessions. With the cosines of a session, k half
periods to its length, noise of whatever memory has

    E z_k^2 <= a + b / k^2,    z_k = sum e(t) D(t) cos(pi k t / T),

since a random walk is the roughest that wanders without end, and any other grows less towards k = 0. The line is drawn through the cosines
k = 8 … 50, as high as these let it be, and what the seven below have beyond it is no noise. It is a wave of a sensor if it is so in
held-out sessions, too, if it is a good part of what is left of its channel, if no other channel has the same, and if it does not go with
the motion.

Source: for cosines as the eigenfunctions of what wanders, N. Ahmed, T. Natarajan, K. Rao, IEEE Transactions on Computers C-23 (1974) 90-93.
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

LOW, HIGH = 7, 50  # half periods to a session, of waves and of what draws the line
SHORTEST_S = 2.8  # the shortest period of a wave, s
LASTS_S = 9.5  # for which a session must last, s: on shorter ones waves were not tried
FEWEST = 3  # cosines that draw the line, times those of waves
SLOPES = np.concatenate([[0.0], np.geomspace(1.0, 1e5, 41)])  # b / a
DOUBT = 2.5  # nats by which a line may be less likely than the best one
# Times the line. Of 2640 sound records of eleven kinds of noise the most had 1.7 where the doubt was 4 nats; of slopes, whose line the
# motion bends, one short record in hundreds had 4.5 with the doubt above.
EXCESS = {ZERO: 4.0, SLOPE: 6.0}
GOOD_PART = 0.2  # of the plain error of its channel, which a wave must take away
ALIKE, HALF = 0.7, 0.5  # correlation with another channel's wave, of so much of the excess or the part, from which they are the same
LOCKED = 0.75  # of a wave's mean square: so much may not go with the motion
WHOLE = 0.7  # of a session that must be believed


@dataclass(frozen=True)
class Wave:
    """What wanders in one channel: over the line of noise in training sessions and in those held out, what it is, (C, N) N, and the part of
    the plain error that it takes away, each by session."""

    course: Course
    excess: tuple[float, float]
    values: dict[str, np.ndarray]
    parts: dict[str, float]

    @property
    def part(self) -> float:
        """The least part of any session."""
        return min(self.parts.values())


def find_wave(model: Model, train: list[Session], held: list[Session], noise: Whitener) -> tuple[Wave, Gain] | None:
    """The wave that takes most of a channel's error away, if there is one, and what it gains in held-out sessions."""
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
    """The same as a course of `sessions`."""
    said = {s.name: _said(wave.course, model, s, wave.values[s.name]) for s in sessions}
    values = {s.name: wave.values[s.name] for s in sessions}
    return Run(wave.course, score, 0.0, max(float(np.abs(v).max()) for v in values.values()), values, said, sessions[0].period)


def _courses(session: Session) -> Iterator[Course]:
    for c, channel in enumerate(session.channels):
        if channel not in session.stuck:
            yield from (Course(carrier, WAVE, (c,), sensor_of(channel, session.n_taxels)) for carrier in (ZERO, SLOPE))


def _wave(course: Course, simulations: list[np.ndarray], sessions: list[Session], e: list[np.ndarray], training: int) -> Wave | None:
    """The wave of a channel, fitted to what is left `e` (C, n) N of sessions of which so many are for `training`; None where they are too
    short to have one."""
    low = min(LOW, *(int(2.0 * np.ptp(s.motion.t) / SHORTEST_S) for s in sessions))
    high = min(HIGH, *(s.t.size // 5 for s in sessions))
    if high < (FEWEST + 1) * low or low < 2:
        return None
    each = [_of_session(course, s, plain, x, low, high) for s, plain, x in zip(sessions, simulations, e, strict=True)]
    z = np.array([amounts for amounts, _, _ in each])
    over = [np.mean(c[:low] ** 2 / _line(z**2, low)) for c in z]
    values, parts = ({s.name: own[i] for s, own in zip(sessions, each, strict=True)} for i in (1, 2))
    return Wave(course, (float(np.mean(over[:training])), float(np.mean(over[training:]))), values, parts)


def _of_session(course: Course, s: Session, plain: np.ndarray, e: np.ndarray, low: int, high: int) -> tuple[np.ndarray, np.ndarray, float]:
    """How much of each of the `high` cosines is in what is left of a channel (in units of white noise, of those beyond the first `low`
    beside these), the wave of these (C, N) N, and the share of the error that it takes away."""
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
    """Cosines, from none to `most` half periods to the session, and the line and parabola that bend waves at its ends."""
    u = (t - s.motion.t[0]) / np.ptp(s.motion.t)
    return np.cos(np.pi * np.arange(most + 1)[:, None] * u), np.array([u - 0.5, (u - 0.5) ** 2])


def _matched(y: np.ndarray, rows: np.ndarray) -> np.ndarray:
    return rows @ y / np.sqrt(np.maximum(np.sum(rows**2, axis=1), 1e-300))


def _line(squares: np.ndarray, low: int) -> np.ndarray:
    """The highest a + b / k^2 (low,) that squares (S, K) beyond the first `low` let be."""
    k = np.arange(1.0, squares.shape[1] + 1.0)
    shapes = 1.0 + SLOPES[:, None] / k**2
    sizes = np.mean(squares[:, None, low:] / shapes[:, low:], axis=(0, 2))
    lines = np.maximum(sizes[:, None], 1e-300) * shapes
    unlikely = 0.5 * len(squares) * np.sum(np.log(lines[:, low:]), axis=1)
    return lines[unlikely < unlikely.min() + DOUBT, :low].max(axis=0)


def _same(one: Wave, other: Wave, sessions: list[Session]) -> bool:
    """Whether another channel has the same wave, so that it is not of one sensor."""
    least = EXCESS[other.course.carrier]
    if one.course.rows == other.course.rows or min(other.excess) < HALF * least or other.part < HALF * GOOD_PART:
        return False
    a, b = (np.concatenate([w.values[s.name][w.course.rows[0]] for s in sessions]) for w in (one, other))
    return bool(np.abs(a @ b) > ALIKE * np.sqrt((a @ a) * (b @ b)))


def _locked(wave: Wave, sessions: list[Session]) -> bool:
    """Whether the wave goes with depth or speed, with the same amounts in all sessions: that would be the skin's, or the rig's."""
    row = wave.course.rows[0]
    w = np.concatenate([wave.values[s.name][row] - wave.values[s.name][row].mean() for s in sessions])
    with_motion = np.concatenate([_slow(_moved(s), s) for s in sessions], axis=1)
    rest = w - np.linalg.lstsq(with_motion.T, w, rcond=1e-8)[0] @ with_motion
    return bool(rest @ rest < (1.0 - LOCKED) * (w @ w))


def _moved(s: Session) -> np.ndarray:
    """Depth, its square, speed, the deepest so far and what follows the depth late, (5, N), each of the order of one."""
    x = np.maximum(s.motion.x, 0.0) / max(float(s.motion.x.max()), 1e-12)
    v = s.motion.v * (s.motion.x > 0.0) / max(float(np.abs(s.motion.v).max()), 1e-12)
    return np.array([x, x**2, v, np.maximum.accumulate(x), lagged(x, np.ptp(s.motion.t) / 5.0, s.motion.dt)])


def _slow(rows: np.ndarray, s: Session) -> np.ndarray:
    """What waves have of rows (K, N)."""
    shapes = np.concatenate(_shapes(s.motion.t, s, LOW))
    slow = np.linalg.lstsq(shapes.T, rows.T, rcond=1e-8)[0].T @ shapes
    return slow - slow.mean(axis=1, keepdims=True)


def _said(course: Course, model: Model, s: Session, values: np.ndarray) -> Said:
    """From where to where a session wanders, in words and numbers."""
    row, of_slope = values[course.rows[0]], course.carrier == SLOPE
    if of_slope:
        own = simulated(model, s)[course.rows[0]]
        loaded = np.abs(own) > 0.3 * np.abs(own).max()
        row = np.where(loaded, row / np.where(loaded, own, 1.0), 0.0)
    at = np.sort([np.argmin(row), np.argmax(row)])
    first, last = row[at]
    words = f"{1e2 * first:+.2g} to {1e2 * last:+.2g} %" if of_slope else f"{first:+.3g} to {last:+.3g} N"
    return Said.of(f"wanders from {words}", (first, last), "1" if of_slope else "N", s.motion.t[at], crept=True)
