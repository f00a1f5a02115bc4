"""Courses: what one session has of its own, such as a zero set anew before it, a gain that changed part-way, or lost counts of the encoder.

No parameter that all sessions share can describe these. If they are left out, the search names whatever cause resembles them most. So each
session may have a course of its own,

    y(t) = simulated(t) + D(t) sum_k z_k phi_k(t).

The carrier D is the change of the channels per unit of a zero (1 in one channel), a slope (the simulated channel itself), a delay (-dy/dt
in all channels of one clock), a zero of depth (dF/dx in all channels), or a zero or slope of the force that drives the test (dT/dF in all
taxels, times 1 or F). The shapes phi_k are a constant, steps at moments to be found, or hat functions between knots (a piecewise linear
"bend"). Courses compete with the causes of the catalogue by the same likelihood gain; each amplitude and each moment is charged.

Whether held-out sessions confirm a course is decided in `gate`.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import lsq_linear

from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.courses.carriers import DELAY, DEPTH, DRIVE, SLOPE, ZERO, carried
from skin_ident.criticism.courses.ground import MOMENTS, Ground, fitted_ground, held_ground, phi
from skin_ident.criticism.courses.kinds import BEND, CONSTANT, STEPS, Course, common_slope, courses
from skin_ident.criticism.courses.left_by_tare import MORE_BY_LARGER_ZEROS, drive_rests
from skin_ident.criticism.courses.run import LEAST_SCORE, Moments, Run
from skin_ident.criticism.courses.words import said_of
from skin_ident.criticism.gates.uncertain import Open
from skin_ident.criticism.noise.pursuit import Normal
from skin_ident.criticism.noise.steps import sharpest
from skin_ident.criticism.noise.whitening import Whitener, stack
from skin_ident.criticism.sessions.session import Session, with_zeros
from skin_models.model import Model

SHARPEST = 6  # and further candidates, where a single step would explain most
MOST_STEPS = 4  # steps per session, on average
SECANTS = 2  # times at most that a delay is refitted, linearised about the delay found before
SHORT = 0.1  # share of a period at the band's edge, below which a delay needs one refit only
LASTING_S, UNDONE = 1.0, 0.5  # s that a step must last, unless more than this share of it remains afterwards
KNOT_S = {ZERO: 20.0, DELAY: 5.0}  # s between the knots of a bend; a delay shows in all motion, a zero only above slow noise
FEW_IN_AIR = 20  # samples in the air, below which these tell nothing of a zero
ALIKE = 0.95  # share of the score of a slope in one channel that a slope common to all must reach to replace it

Solution = tuple[dict[str, np.ndarray], float, float]  # amplitudes by session, their gain less their charge, and that charge


def bends_of_each_session(model: Model, sessions: list[Session]) -> list[np.ndarray]:
    """Rows (K, C, n) for each session: the hat functions of every channel's zero, and the zero of what drives the test, of every session.
    Rows of one session are zero in the others."""
    every = [Course(ZERO, BEND, (c,), "") for c in range(len(sessions[0].channels))]

    def of(s: Session) -> np.ndarray:
        plain = simulated(model, s)
        zeros = [s.band.thin(carried(ZERO, c.rows, model, s, plain) * hat) for c in every for hat in phi(_knots(c, s), c, s)]
        return np.array([*zeros, s.band.thin(carried(DEPTH if s.drive is None else DRIVE, (), model, s, plain))])

    rows = [of(s) for s in sessions]
    return [
        np.concatenate([r if i == j else np.zeros((len(r), *s.measured.shape)) for j, r in enumerate(rows)]) for i, s in enumerate(sessions)
    ]


def worthwhile(model: Model, sessions: list[Session], noise: Whitener, encoder_step: float = 0.0) -> list[Run]:
    """Courses that explain part of what `model` leaves of `sessions`, the best first, with the model's own unknowns projected out. If the
    best one is of a size that good hardware has, it is returned alone, and its `worth` is false."""
    return _worthwhile(fitted_ground(model, sessions, noise), encoder_step)


def beside_the_rest(model: Model, train: list[Session], held: list[Session], noise: Whitener, encoder_step: float = 0.0) -> list[Run]:
    """Courses that explain part of the residual of `held` sessions, to which `model` was not fitted: what is wrong in them alone. The model
    may change there as far as `train` leaves it uncertain: a taxel that no training session loads may read anything."""
    return _worthwhile(held_ground(model, held, noise, Open.to(model, train, held, noise)), encoder_step)


def _worthwhile(ground: Ground, encoder_step: float) -> list[Run]:
    runs = [
        r for r in (_run(course, ground) for course in courses(ground.sessions[0])) if shows_in_the_air(r, ground.plain, ground.sessions)
    ]
    untold = max((r for r in runs if not r.worth(encoder_step)), key=lambda r: r.score, default=None)
    able = [r for r in _of_sensors(runs, ground) if r.worth(encoder_step) and (untold is None or r.score > untold.score)]
    if not able and untold and untold.score > LEAST_SCORE:
        return [untold]
    return sorted(able, key=lambda r: -r.score)


def shows_in_the_air(run: Run, plain: dict[str, np.ndarray], sessions: list[Session]) -> bool:
    """Whether a zero that is another in every session, or jumps, also lowers the error of the `plain` simulation (C, N), by name, in the
    air of `sessions`, if there is any. One that only appears under load is no zero, but may be a skin that differs. True for all other
    courses; and for a zero of a test that force drives, which may be that of the driving load cell and then presses on the skin.
    """
    own = run.course.carrier == ZERO and run.course.shape == CONSTANT and sessions[0].drive is None
    if not (run.course.jumps or own):
        return True
    (row,), before, after, samples = run.course.rows, 0.0, 0.0, 0
    for s in sessions:
        air = s.motion.x <= 0.0 if s.drive is None else drive_rests(s)
        e, zero = (s.bridged - plain[s.name])[row, air], run.values[s.name][row, air]
        before, after, samples = before + float(e @ e), after + float((e - zero) @ (e - zero)), samples + e.size
    return after < before or samples < FEW_IN_AIR


def _of_sensors(runs: list[Run], ground: Ground) -> list[Run]:
    """The runs without the slopes of one channel where a slope common to all channels explains nearly as much: that is no fault of one
    sensor."""
    sloped = max((r.score for r in runs if r.course.carrier == SLOPE), default=0.0)
    if sloped <= LEAST_SCORE or len(ground.sessions[0].channels) == 1:
        return runs
    common = _run(common_slope(ground.sessions[0]), ground).score
    return [r for r in runs if r.course.carrier != SLOPE or common < ALIKE * r.score]


def added(sessions: list[Session], values: dict[str, np.ndarray]) -> list[Session]:
    """The sessions with a course added to their simulation; `values` (C, N) N by name of the session."""
    return [replace(s, course=values[s.name] + (0.0 if s.course is None else s.course)) for s in with_zeros(sessions, values)]


def fitted(
    course: Course, model: Model, sessions: list[Session], noise: Whitener, free: Open | None = None, at: Moments | None = None
) -> Run:
    """The course fitted to the residual of `model`, with what is `free` to change of the model. Steps are searched for, or placed `at`
    given moments."""
    return _run(course, held_ground(model, sessions, noise, free), at)


def _run(course: Course, g: Ground, at: Moments | None = None) -> Run:
    """The course fitted. A delay is fitted repeatedly, each time linearised about the delay found before."""
    run = _linear_run(course, g, at)
    if course.carrier != DELAY or run.score <= 0.0:
        return run
    for _ in range(SECANTS):
        late = {s.name: _total(course, run, s) for s in g.sessions}
        run = max(run, _linear_run(course, replace(g, late=late), at), key=lambda r: r.score)
        if run.largest < SHORT / g.sessions[0].band.edge:
            break
    return run


def _total(course: Course, run: Run, s: Session) -> np.ndarray:
    """The sum of the terms z_k phi_k of a run in one session, (N,)."""
    return run.amplitudes[s.name] @ phi(run.moments[s.name], course, s)


def _linear_run(course: Course, g: Ground, at: Moments | None = None) -> Run:
    """The course fitted by linear least squares, as if its effect were proportional to its amplitudes."""
    moments, (z, score, charge) = _solved_steps(course, g, at) if course.shape == STEPS else _solved(course, g, at)
    values = {s.name: g.value(course, s, moments[s.name], z[s.name]) for s in g.sessions}
    said = {s.name: said_of(course, s.motion.t[0], moments[s.name], z[s.name]) for s in g.sessions}
    largest = max(float(np.abs(row).max(initial=0.0)) for row in z.values())
    return Run(course, score, charge, largest, values, said, g.sessions[0].longest_period, g.tare(course), moments, z)


def _solved(course: Course, g: Ground, at: Moments | None) -> tuple[Moments, Solution]:
    """Moments (given by `at`, or on an even grid) and the amplitudes there."""
    moments = at or {s.name: _moments(course, g, s) for s in g.sessions}
    return moments, _solve(course, g, moments, exactly=at is not None)


def _solved_steps(course: Course, g: Ground, at: Moments | None) -> tuple[Moments, Solution]:
    """The moments of the steps that are used, and their amplitudes. Unless they are given by `at`, moments are searched for on a coarse
    grid, then on a fine one around those found, and the fit is repeated without steps that do not last."""
    moments, (z, score, charge) = _solved(course, g, at)
    if at is None and score > 0.0:
        moments = {s.name: _around(moments[s.name], z[s.name], s, g.span(course, s)) for s in g.sessions}
        z, score, charge = _solve(course, g, moments, exactly=True)
        lasting = {name: _lasting(m, z[name]) for name, m in moments.items()}
        if any(lasting[name].size < np.count_nonzero(row) for name, row in z.items()):
            moments = lasting
            z, score, charge = _solve(course, g, moments, exactly=True)
    taken = {name: row != 0.0 for name, row in z.items()}
    return {name: m[taken[name]] for name, m in moments.items()}, ({name: row[taken[name]] for name, row in z.items()}, score, charge)


def _lasting(moments: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The moments of the steps that last, or the first moment where none does. A single step that is undone soon after is an accident or
    noise and is dropped; several of them are a loose contact and stay."""
    used, z = moments[z != 0.0], z[z != 0.0]
    undone = (np.diff(used) < LASTING_S) & (np.abs(z[1:] + z[:-1]) < UNDONE * np.maximum(np.abs(z[1:]), np.abs(z[:-1])))
    if np.count_nonzero(undone) != 1:
        return used if used.size else moments[:1]
    last = used[~(np.append(undone, False) | np.insert(undone, 0, False))]
    return last if last.size else moments[:1]


def _moments(course: Course, g: Ground, s: Session) -> np.ndarray:
    """Candidate moments of steps: an even grid, and the moments where the residual itself suggests one."""
    t = s.motion.t
    if course.shape != STEPS:
        return _knots(course, s)
    even = np.linspace(t[0], t[-1], MOMENTS + 2)[:-1]
    sharp = sharpest(s.band.thin(g.carrier(course, s)), g.of(s), s, g.noise, SHARPEST)
    return np.unique(np.clip(np.union1d(even, sharp), *g.span(course, s)))


def _knots(course: Course, s: Session) -> np.ndarray:
    """Knots of a bend, s; a single dummy knot for a constant."""
    t = s.motion.t
    return np.linspace(t[0], t[-1], max(2, round((t[-1] - t[0]) / KNOT_S[course.carrier]) + 1)) if course.shape == BEND else np.zeros(1)


def _around(moments: np.ndarray, z: np.ndarray, s: Session, span: tuple[float, float]) -> np.ndarray:
    """Finer grids about the moments that were used, within a span: one as wide as the coarse spacing, one from sample to sample."""
    dt, gap = s.motion.dt, (s.motion.t[-1] - s.motion.t[0]) / (MOMENTS + 1)
    around = np.union1d(np.linspace(-gap, gap, 17), dt * s.band.every * np.linspace(-1.0, 1.0, 9))
    used = moments[z != 0.0]
    return np.unique(np.clip(np.add.outer(used, around), *span)) if used.size else moments[:1]


def _solve(course: Course, g: Ground, moments: Moments, exactly: bool = False) -> Solution:
    """Amplitudes by session, their gain less the charge for each free amplitude (twice for steps, whose moment is charged too), and that
    charge."""
    rows = [g.columns(course, s, moments[s.name], exactly) for s in g.sessions]
    normal = Normal.by_blocks([stack([own], [s], g.noise) for own, s in zip(rows, g.sessions, strict=True)], g.left, g.Q)
    if course.shape == STEPS:
        z = normal.pursue(MOST_STEPS * len(g.sessions))
        numbers = 2 * np.count_nonzero(z)
    else:
        free = _free(course, g, rows)
        z = normal.least_squares(free)
        tare = g.tare(course)
        z = _as_tared(normal, z, tare.leaves) if tare else z
        numbers = min(np.count_nonzero(z), np.linalg.matrix_rank(free) if free.size else 0)
    charge = np.log(max(normal.count, 2)) * numbers
    split = np.split(z, np.cumsum([len(own) for own in rows])[:-1])
    return dict(zip((s.name for s in g.sessions), split, strict=True)), normal.explained(z) - float(charge), float(charge)


def _free(course: Course, g: Ground, rows: list[np.ndarray]) -> np.ndarray:
    """Columns (K, L) that span the admissible amplitudes. Where the model is free, the mean over all amplitudes is removed from
    session-long slopes and from delays that bend: a common slope is the model's stiffness, and a common delay is taken up by its
    damping."""
    one = np.eye(sum(map(len, rows)))
    if not (course.slopes or course.wanders) or g.Q is None or g.alone:
        return one
    loaded = one[[bool(np.any(row)) for own in rows for row in own]]
    return (loaded - loaded.mean(axis=0)).T if len(loaded) else loaded.T


def _as_tared(normal: Normal, z: np.ndarray, most: float) -> np.ndarray:
    """The zeros bounded by what tares leave, if these explain as much as unbounded ones; else `z`."""
    within = lsq_linear(*normal.square(), (-most, most)).x if most > 0.0 else np.zeros(z.size)
    return within if normal.explained(z) - normal.explained(within) < MORE_BY_LARGER_ZEROS else z
