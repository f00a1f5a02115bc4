"""The gate of courses: in held-out sessions the course is fitted to every other block of a few seconds, and must predict the blocks
between. A slow drift is told from strongly coloured noise in this way only: knots and blocks are longer than the memory of noise.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.residual import residual, simulated
from skin_ident.criticism.courses.carriers import DELAY, DEPTH, ZERO
from skin_ident.criticism.courses.course import added, fitted
from skin_ident.criticism.courses.kinds import BEND, CONSTANT, STEPS, WAVE, Course
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.gates.gate import MATERIAL_RMSE, Gain, gain_of_residuals
from skin_ident.criticism.gates.uncertain import Open, beside_uncertainty, left_open
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

BLOCK_S = {CONSTANT: 4.0, STEPS: 4.0, BEND: 8.0}  # alternately fitted and predicted
BRIEF_S = 2.0  # where a delay bends, whose knots are nearer
FEWEST_BLOCKS = 10  # of a session in which a slope is asked for: each half of them must be loaded
CLEARLY = {CONSTANT: MATERIAL_RMSE, STEPS: MATERIAL_RMSE, BEND: 0.18, WAVE: 0.18}  # least relative fall: noise of long memory bends
PLAINLY = 0.15  # fall that needs no gain in likelihood
FAINT = 0.2  # of what is left at full rate, which a course of a zero must exceed
SURE = 0.25  # of the fall of the error, which its interval must exclude: seven courses are tried every time


def stands(run: Run, gain: Gain, model: Model, sessions: list[Session]) -> bool:
    """Whether a course of `sessions` beside `model` is believed, where it shows, and more than faint if it is one of a zero, or a slope
    from the start on: those of good hardware wander."""
    faint = (run.course.carrier == ZERO or run.course.slopes) and _share(run, model, sessions) < FAINT
    return believed(gain, run.course) and run.course.shows(gain) and not faint


def _share(run: Run, model: Model, sessions: list[Session]) -> float:
    """A course over what the model leaves at full rate, in its channels (RMS)."""
    own = list(run.course.rows)
    size = sum(np.sum(run.values[s.name][own] ** 2) for s in sessions)
    left = sum(np.sum((s.raw - simulated(model, s))[own] ** 2) for s in sessions)
    return float(np.sqrt(size / max(left, 1e-300)))


def believed(gain: Gain, course: Course) -> bool:
    """Whether the blocks between are predicted better beyond doubt, and enough to matter. The plain error decides: a step that is found a
    little too early or too late leaves a spike, which whitening would make the most of. But where the plain error falls by little, the
    likelihood must gain, too, and it may never lose as large a share as the plain error gains. Of one session among others the plain error
    falls in few blocks: there the likelihood may be what is beyond doubt."""
    fall = 1.0 - gain.after / max(gain.before, 1e-300)
    sure = gain.ci95[0] > SURE * (gain.before - gain.after) or (gain.ci95[0] > 0.0 and gain.lower > SURE * gain.relative > 0.0)
    sure = sure and fall > CLEARLY[course.shape]
    if course.shape == BEND and not course.wanders:  # which leaves no spikes, and is what wandering noise looks like
        return sure and gain.lower > 0.0
    return sure and (gain.relative > 0.0 or (fall > PLAINLY and gain.relative > -fall))


def course_gain(course: Course, before: Model, after: Model, train: list[Session], held: list[Session], noise: Whitener) -> Gain:
    """What the course gains in `held`, or in `train` where nothing is held out, fitted to every other block and predicting the blocks
    between; the model is `before` or `after`, each free as far as training leaves it."""
    gain = _gain_in(course, before, after, train, held, noise)
    if not (held and (course.slopes or course.tares) and len(train) > 1 and _agrees(gain)):
        return gain
    return max(gain, _gain_in(course, before, after, train, [], noise), key=lambda g: g.relative)


def _agrees(gain: Gain) -> bool:
    """Whether held-out sessions do not speak against a slope or a zero that the others have: it may be near to the mean, or none, there."""
    return gain.lower > 0.0 and gain.after < gain.before


def _gain_in(course: Course, before: Model, after: Model, train: list[Session], held: list[Session], noise: Whitener) -> Gain:
    """The same in held-out sessions, or in those that were fitted where none is `held`."""
    free, sessions = left_open(after, train, held, noise), held or train
    plain = [residual(before, s) for s in sessions]
    predicted = [_predicted(course, after, s, noise, free and free.of(i)) for i, s in enumerate(sessions)]
    if not held:
        return gain_of_residuals(plain, predicted, train, noise, "every other block of each session")
    if free:
        plain, predicted = beside_uncertainty(plain, before, train, held, noise), free.beside(predicted, held, noise)
    return gain_of_residuals(plain, predicted, held, noise, ", ".join(s.name for s in held))


def helps(run: Run, before: Model, after: Model, train: list[Session], held: list[Session], noise: Whitener) -> bool:
    """Whether held-out sessions with such a course of their own are nearer to `after` than without one to `before`, in the plain error of
    the channels where it shows; else it is what one session had, and nobody can tell that from noise."""
    if not held:
        return True
    own = fitted(run.course, after, held, noise, left_open(after, train, held, noise))
    return _left(run, after, added(held, own.values)) < _left(run, before, held)


def nearer(run: Run, model: Model, sessions: list[Session]) -> bool:
    """Whether a model with a course of their own is nearer to sessions, in the plain error of the channels where it shows."""
    return _left(run, model, added(sessions, run.values)) < _left(run, model, sessions)


def _left(run: Run, model: Model, sessions: list[Session]) -> float:
    rows = list(run.course.rows)
    return sum(float(np.sum((residual(model, s) ** 2 * s.weight)[rows])) for s in sessions)


def _predicted(course: Course, model: Model, s: Session, noise: Whitener, free: Open | None) -> np.ndarray:
    """Residual (C, n) with each block's course fitted to its neighbours. When the depth or a zero jumped, or a buffer slipped, may be seen
    in all blocks: jumping a little too early or too late feigns a speed that was not there, or a spike, and of half a session more slips
    are told than of all of it, each of which is far off in the blocks between."""
    e = residual(model, s)
    known = fitted(course, model, [s], noise, free).moments if course.carrier in (DEPTH, DELAY) or course.jumps else None
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
