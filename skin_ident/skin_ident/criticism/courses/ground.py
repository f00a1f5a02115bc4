"""What courses are fitted to: simulated sessions and what is left of them, and what a course adds there."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.courses.carriers import DEPTH, DRIVE, SLOPE, after_jump, carried
from skin_ident.criticism.courses.kinds import BEND, CONSTANT, Course
from skin_ident.criticism.courses.left_by_tare import Tare, tare_of_drive, tares
from skin_ident.criticism.gates.uncertain import Open, own_rows
from skin_ident.criticism.noise.whitening import Whitener, stack
from skin_ident.criticism.projection import basis, projected_off
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

MOMENTS = 24  # moments of the even grid of a session on which steps are first searched for, after its start
SEEN = 0.01  # share of the energy of a step from the start on that the last possible step must still have


def phi(moments: np.ndarray, course: Course, s: Session) -> np.ndarray:
    """The shapes phi_k (K, N) of the equation in `course`."""
    t = s.motion.t
    if course.shape == CONSTANT:
        return np.ones((1, t.size))
    if course.shape == BEND:
        return np.array([np.interp(t, moments, hat) for hat in np.eye(moments.size)])
    return (t >= moments[:, None]).astype(float)


@dataclass(frozen=True)
class Ground:
    """What all courses are fitted to: the simulated sessions, `plain` (C, N) by name, and the whitened residual `left` (R,) after
    projection off `Q` (R, U), the span of what the model may change by itself (None: nothing). Rows of `Q` beyond those of the sessions are
    what other sessions know of the model. `alone`: only these sessions are asked for courses, and other sessions determine the slopes.
    Delays are linearised about `late`, (N,) s by name."""

    model: Model
    sessions: list[Session]
    noise: Whitener
    Q: np.ndarray | None
    plain: dict[str, np.ndarray]
    left: np.ndarray
    alone: bool = False
    late: dict[str, np.ndarray] = field(default_factory=dict)

    def of(self, session: Session) -> np.ndarray:
        """The part of `left` that belongs to one session, (C, n)."""
        sizes = [s.measured.size for s in self.sessions]
        i = next(i for i, s in enumerate(self.sessions) if s is session)
        return self.left[sum(sizes[:i]) : sum(sizes[: i + 1])].reshape(session.measured.shape)

    def tare(self, course: Course) -> Tare | None:
        """The zero error that a tare leaves, for a course that is a constant zero; None for all others."""
        if not course.tares:
            return None
        return tare_of_drive(self.sessions) if course.carrier == DRIVE else self._tared[course.rows[0]]

    @cached_property
    def _tared(self) -> list[Tare]:
        """The same for every channel, computed from the noise spectrum once for all zeros."""
        return tares(self.sessions, self.noise)

    @cached_property
    def _carriers(self) -> dict[tuple[str, tuple[int, ...], str], np.ndarray]:
        return {}

    def carrier(self, course: Course, s: Session) -> np.ndarray:
        """D of the equation in `course`, (C, N), newtons per unit of z; computed once for all shapes."""
        key = course.carrier, course.rows, s.name
        if key not in self._carriers:
            self._carriers[key] = carried(course.carrier, course.rows, self.model, s, self.plain[s.name], self.late.get(s.name, 0.0))
        return self._carriers[key]

    def beside(self, rows: np.ndarray) -> np.ndarray:
        """Whitened rows (R, …) projected off `Q`."""
        if self.Q is None:
            return rows
        rows = np.concatenate([rows, np.zeros((len(self.Q) - len(rows), *rows.shape[1:]))])
        return projected_off(rows, self.Q)

    def span(self, course: Course, s: Session) -> tuple[float, float]:
        """First and last moment (s) at which a course may step; after the last one too little is compared to see the step. A slope step at
        the very start of a lone session is the skin's stiffness, and where sessions press at several places it is the place's: there the
        span begins later."""
        t = s.motion.t
        own = course.carrier == SLOPE and self.Q is not None and not self.alone and (len(self.sessions) == 1 or s.spread is not None)
        first = float(t[0] + own * (t[-1] - t[0]) / (MOMENTS + 1))
        felt = np.sum((s.band.thin(self.carrier(course, s)) * s.weight) ** 2, axis=0)
        told = np.cumsum(felt[::-1])[::-1] > SEEN * np.sum(felt)
        return first, max([first, *s.t[told][-1:]])

    def value(self, course: Course, s: Session, moments: np.ndarray, z: np.ndarray) -> np.ndarray:
        """What the amplitudes z (K,) add to the channels, (C, N) N. A step of depth is a small one in proportion, with the apparent speed
        at the jump: right for the counts that encoders lose, and some percent off for a third of a millimetre, after which the plunger
        meets the skin elsewhere."""
        if course.carrier == DEPTH:
            jumps = (a * after_jump(self.model, s, self.plain[s.name], m) for a, m in zip(z, moments, strict=True))
            return sum(jumps, np.zeros_like(s.raw))
        return self.carrier(course, s) * (z @ phi(moments, course, s))

    def columns(self, course: Course, s: Session, moments: np.ndarray, exactly: bool) -> np.ndarray:
        """Change of the channels per unit of every z_k in the common band, (K, C, n) N; zero in all channels but the course's own. With
        `exactly`, steps of depth are those of `value`; else the speed at the jump is left out."""
        if exactly and course.carrier == DEPTH:
            return np.array([s.band.thin(after_jump(self.model, s, self.plain[s.name], m)) for m in moments])
        shapes, carrier = phi(moments, course, s), self.carrier(course, s)
        out = np.zeros((len(shapes), *s.measured.shape))
        for c in course.rows or range(len(carrier)):
            out[:, c] = s.band.thin(carrier[c] * shapes)
        return out


def ground_of(model: Model, sessions: list[Session], noise: Whitener, Q: np.ndarray | None = None, alone: bool = False) -> Ground:
    """The ground of sessions, of which `Q` (R', U) spans what `model` may change by itself."""
    plain = {s.name: simulated(model, s) for s in sessions}
    r = stack([s.measured - s.band.thin(plain[s.name]) for s in sessions], sessions, noise)
    ground = Ground(model, sessions, noise, Q, plain, r, alone)
    return replace(ground, left=ground.beside(r))


def fitted_ground(model: Model, train: list[Session], noise: Whitener) -> Ground:
    """The ground of the sessions to which `model` is fitted: it may change in all its unknowns."""
    return ground_of(model, train, noise, basis(stack(own_rows(model, train, train), train, noise)))


def held_ground(model: Model, held: list[Session], noise: Whitener, free: Open | None) -> Ground:
    """The ground of sessions to which `model` was not fitted: it may change as far as it was left `free`."""
    return ground_of(model, held, noise, basis(free.rows(held, noise)), alone=True) if free else ground_of(model, held, noise)
