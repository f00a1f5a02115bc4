"""Courses fitted together, and the steps of them that are needed beside the others.

A course is fitted when it is found, beside what is known by then, and keeps the steps that it has. A zero of depth that is found before a
gain that jumps half-way has a step there, too, which feigns the gain. So, once all are known, the amplitudes of all courses are fitted
together, with the model's own unknowns free, and steps are taken out one after the other as long as the squared error rises by less than
what a step is charged for its moment and amplitude.

Source: G. Schwarz, Annals of Statistics 6 (1978) 461-464 (the charge for a number).
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.courses.carriers import DELAY
from skin_ident.criticism.courses.ground import Ground
from skin_ident.criticism.courses.kinds import CONSTANT, STEPS
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.courses.words import said_of
from skin_ident.criticism.noise.pursuit import Normal
from skin_ident.criticism.noise.whitening import stack
from skin_ident.criticism.sessions.session import Session

NONE = np.zeros(0)


def may_thin(run: Run) -> bool:
    """Whether a course is made of steps, or constant, and in proportion to its amplitudes, as a delay is not."""
    return run.course.shape in (CONSTANT, STEPS) and run.course.carrier != DELAY


def thinned(runs: list[Run], g: Ground) -> tuple[list[Run], float]:
    """The `runs`, all of which `may_thin`, in the sessions of `g`, which are without them: with the steps that are needed. And the charge
    for those that were taken out: 0 if none was."""
    normal = Normal.by_blocks([stack([_columns(runs, g, s)], [s], g.noise) for s in g.sessions], g.left, g.Q)
    names = [(i, s.name) for s in g.sessions for i, run in enumerate(runs) for _ in run.amplitudes.get(s.name, NONE)]
    charges = np.log(max(normal.count, 2)) * np.array([1.0 if runs[i].course.shape == CONSTANT else 2.0 for i, _ in names])
    kept = _needed(normal, charges)
    z = normal.least_squares(np.eye(len(names))[:, kept])

    def of(i: int, run: Run) -> Run:
        own = {s.name: z[[name == (i, s.name) for name in names]] for s in g.sessions if s.name in run.amplitudes}
        if run.course.shape == CONSTANT:
            return _with(run, g, {name: (run.moments[name], row) for name, row in own.items()})
        return _with(run, g, {name: (run.moments[name][row != 0.0], row[row != 0.0]) for name, row in own.items()})

    return [of(i, run) for i, run in enumerate(runs)], float(charges.sum() - charges[kept].sum())


def _columns(runs: list[Run], g: Ground, s: Session) -> np.ndarray:
    """What every step of every course changes in a session, (K, C, n) N."""
    own = [g.columns(r.course, s, r.moments[s.name], exactly=True) for r in runs if r.amplitudes.get(s.name, NONE).size]
    return np.concatenate(own) if own else np.zeros((0, *s.measured.shape))


def _needed(normal: Normal, charges: np.ndarray) -> np.ndarray:
    """The columns (L,) of the (M,) offered without any of which the error would rise by more than its charge."""
    one, kept = np.eye(charges.size), np.arange(charges.size)

    def explained(columns: np.ndarray) -> float:
        return normal.explained(normal.least_squares(one[:, columns])) if columns.size else 0.0

    while kept.size:
        without = [np.delete(kept, c) for c in range(kept.size)]
        saved = [explained(few) + charges[c] for few, c in zip(without, kept, strict=True)]
        best = int(np.argmax(saved))
        if saved[best] <= explained(kept):
            break
        kept = without[best]
    return kept


def _with(run: Run, g: Ground, steps: dict[str, tuple[np.ndarray, np.ndarray]]) -> Run:
    """The run with other `steps`, moments and amplitudes by session, in the sessions of `g`."""
    sessions = {s.name: s for s in g.sessions if s.name in steps}
    values = {name: g.value(run.course, s, *steps[name]) for name, s in sessions.items()}
    said = {name: said_of(run.course, s.motion.t[0], *steps[name]) for name, s in sessions.items()}
    moments, amplitudes = ({name: pair[which] for name, pair in steps.items()} for which in (0, 1))
    return run.joined(replace(run, values=values, said=said, moments=moments, amplitudes=amplitudes))
