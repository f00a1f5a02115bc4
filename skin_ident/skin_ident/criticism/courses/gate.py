"""The gate for courses. In held-out sessions the course is fitted to every other block of a few seconds and must predict the blocks
between. Only so is a slow drift told from strongly coloured noise: knots and blocks are longer than the memory of the noise.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.residual import residual, simulated
from skin_ident.criticism.courses.carriers import DELAY, SLOPE, ZERO
from skin_ident.criticism.courses.course import added, fitted, shows_in_the_air
from skin_ident.criticism.courses.kinds import BEND, CONSTANT, STEPS, WAVE, Course
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.gates.gate import MATERIAL_RMSE, Gain, gain_of_residuals
from skin_ident.criticism.gates.uncertain import Open, beside_uncertainty, left_open
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

BLOCK_S = {CONSTANT: 4.0, STEPS: 4.0, BEND: 8.0}  # s, length of the blocks that are fitted and predicted in turn
BRIEF_S = 2.0  # s, the same for a delay that bends, whose knots are closer together
FEWEST_BLOCKS = 10  # blocks in a session, at least, for a constant slope: both halves of them must be loaded
# Least relative fall of the RMSE; noise of long memory looks like a bend or a wave.
CLEARLY = {CONSTANT: MATERIAL_RMSE, STEPS: MATERIAL_RMSE, BEND: 0.18, WAVE: 0.18}
PLAINLY = 0.15  # relative fall of the RMSE above which no gain in likelihood is required
FAINT = 0.2  # share of the RMS residual at full rate that a zero, or a constant slope, must exceed
LITTLE = 0.25  # of a zero in training, up to which held-out sessions have next to none of it, and their air contradicts nothing
NOTHING = 0.005  # relative gain in likelihood, either way, of sessions that a course does not concern
SURE = 0.25  # share of the fall of the error that its lower bound must exceed: seven courses are tried every time


def stands(run: Run, gain: Gain, model: Model, sessions: list[Session]) -> bool:
    """Whether a course of `sessions` beside `model` passes: its gain passes `believed`, the gain is in the channels of the course, and a
    zero, or a constant slope, is not faint, since those of good hardware wander."""
    faint = (run.course.carrier == ZERO or run.course.slopes) and _share(run, model, sessions) < FAINT
    return believed(gain, run.course) and run.course.shows(gain) and not faint


def _share(run: Run, model: Model, sessions: list[Session]) -> float:
    """RMS of a course over the RMS residual of the model without it, at full rate, in the channels of the course."""
    own = list(run.course.rows)
    size = sum(np.sum(run.values[s.name][own] ** 2) for s in sessions)
    left = sum(np.sum((s.bridged - simulated(model, s))[own] ** 2) for s in sessions)
    return float(np.sqrt(size / max(left, 1e-300)))


def believed(gain: Gain, course: Course) -> bool:
    """Whether the blocks between are predicted better, beyond doubt and by enough to matter.

    The plain error decides, since a step placed a little too early or late leaves a spike that whitening would amplify. If the plain error
    falls by little, the likelihood must gain too; and it must never lose a larger share than the plain error gains. A course of one session
    among several lowers the plain error in few blocks only: there the certainty may come from the likelihood instead.
    """
    fall = 1.0 - gain.after / max(gain.before, 1e-300)
    sure = gain.ci95[0] > SURE * (gain.before - gain.after) or (gain.ci95[0] > 0.0 and gain.lower > SURE * gain.relative > 0.0)
    sure = sure and fall > CLEARLY[course.shape]
    if course.shape == BEND and not course.wanders:  # a bend leaves no spikes, and wandering noise looks like one
        return sure and gain.lower > 0.0
    return sure and (gain.relative > 0.0 or (fall > PLAINLY and gain.relative > -fall))


def course_gain(
    course: Course, before: Model, after: Model, train: list[Session], held: list[Session], noise: Whitener, having: list[Session] = ()
) -> Gain:
    """Gain of the course in `held`, or in `train` where nothing is held out: fitted to every other block, it predicts the blocks between.
    The models are `before` without and `after` with it, each free as far as training leaves it uncertain. Where held-out sessions do not
    contradict, the gain in training counts if it is larger: for slopes and constant zeros that in all of it, for a clock that is late in
    few sessions that in those `having` it. Noise that wanders makes no clock late."""
    gain = _gain_in(course, before, after, train, held, noise)
    late = course.carrier == DELAY and 0 < len(having) < len(train)
    if not (held and (course.carrier == SLOPE or course.tares or late) and len(train) > 1 and _agrees(gain)):
        return gain
    return max(gain, _gain_in(course, before, after, having if late else train, [], noise), key=lambda g: g.relative)


def _agrees(gain: Gain) -> bool:
    """Whether held-out sessions do not contradict a slope or zero of the others; their own may be near the mean, or nothing at all, and
    then chance decides whether their likelihood gains."""
    return gain.relative > -NOTHING and gain.lower > -2.0 * NOTHING and gain.after < gain.before


def _gain_in(course: Course, before: Model, after: Model, train: list[Session], held: list[Session], noise: Whitener) -> Gain:
    """The gain in held-out sessions, or in the training sessions where `held` is empty."""
    free, sessions = left_open(after, train, held, noise), held or train
    plain = [residual(before, s) for s in sessions]
    predicted = [_predicted(course, after, s, noise, free and free.of(i)) for i, s in enumerate(sessions)]
    if not held:
        return gain_of_residuals(plain, predicted, train, noise, "every other block of each session")
    if free:
        plain, predicted = beside_uncertainty(plain, before, train, held, noise), free.beside(predicted, held, noise)
    return gain_of_residuals(plain, predicted, held, noise, ", ".join(s.name for s in held))


def helps(run: Run, before: Model, after: Model, train: list[Session], held: list[Session], noise: Whitener) -> bool:
    """Whether `after` with such a course fitted to the held-out sessions is nearer to them than `before` without one, in the plain error of
    the course's channels, and a zero in their air, too. If not, only one session had it, and that cannot be told from noise, or from a
    skin that differs."""
    if not held:
        return True
    own = fitted(run.course, after, held, noise, left_open(after, train, held, noise))
    shown = own.largest < LITTLE * run.largest or shows_in_the_air(own, {s.name: simulated(after, s) for s in held}, held)
    return shown and _left(run, after, added(held, own.values)) < _left(run, before, held)


def nearer(run: Run, model: Model, sessions: list[Session]) -> bool:
    """Whether `model` with the course is nearer to the sessions than without it, in the plain error of the course's channels."""
    return _left(run, model, added(sessions, run.values)) < _left(run, model, sessions)


def _left(run: Run, model: Model, sessions: list[Session]) -> float:
    rows = list(run.course.rows)
    return sum(float(np.sum((residual(model, s) ** 2 * s.weight)[rows])) for s in sessions)


def _predicted(course: Course, model: Model, s: Session, noise: Whitener, free: Open | None) -> np.ndarray:
    """Residual (C, n) after subtracting in each block the course that was fitted to the other blocks.

    All steps, and slips of a buffer, take their moments from all blocks. A jump placed a little too early or late would
    feign a speed or leave a spike; and half a session shows more slips than all of it, each of them far off in the blocks between.
    """
    e = residual(model, s)
    known = fitted(course, model, [s], noise, free).moments if course.shape == STEPS or course.wanders else None
    at = known if known and known[s.name].size else None
    block = BRIEF_S if course.wanders else BLOCK_S[course.shape]
    block = min(block, float(np.ptp(s.t)) / FEWEST_BLOCKS) if course.slopes else block
    odd = ((s.t - s.t[0]) / block).astype(int) % 2
    out = e.copy()
    for side in (0, 1):
        seen = replace(s, weight=s.weight * (odd == side))
        run = fitted(course, model, [seen], noise, free, at)
        out[:, odd != side] -= s.band.thin(run.values[s.name])[:, odd != side]
    return out
