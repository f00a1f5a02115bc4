"""Trajectories: indentation depth as a pure function of time, put together from pieces.

A piece is a stretch of motion with a formula; a trajectory is a row of pieces whose depth and speed are continuous. Everything is SI:
depth m (positive into the skin, zero at its surface), speed m/s, acceleration m/s^2, time s.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import inf
from typing import Any, NamedTuple

import numpy as np

from skin_motion_profiles.errors import ProfileError

_GAP = 1e-9  # m and m/s, what rounding may leave between two pieces


class State(NamedTuple):
    """Depth x, speed v, acceleration a: numbers, or arrays of one shape."""

    x: Any
    v: Any
    a: Any


class Reach(NamedTuple):
    """How far a motion goes: least and greatest depth, greatest speed and acceleration (absolute values)."""

    low: float
    high: float
    speed: float
    acceleration: float

    def joined(self, other: "Reach") -> "Reach":
        """The reach of both motions together."""
        return Reach(min(self.low, other.low), max(self.high, other.high), *map(max, self[2:], other[2:]))


class Piece(ABC):
    """A stretch of motion from t = 0 to `duration`."""

    duration: float
    swiftest: float = inf  # s, period of the quickest oscillation in it

    @abstractmethod
    def at(self, t: np.ndarray) -> State:
        """The state at times `t` (N,) within [0, duration]."""

    @abstractmethod
    def reach(self) -> Reach:
        """How far the piece goes."""


@dataclass(frozen=True)
class Arc(Piece):
    """Constant acceleration: x = x0 + v0 t + a t^2 / 2. With v0 = a = 0 it holds still."""

    duration: float
    x0: float
    v0: float = 0.0
    a: float = 0.0

    def at(self, t: np.ndarray) -> State:
        """The formula and its derivatives at `t` (N,) s."""
        return State(self.x0 + (self.v0 + 0.5 * self.a * t) * t, self.v0 + self.a * t, np.full_like(t, self.a))

    def reach(self) -> Reach:
        """Exactly: a parabola turns once."""
        turn = -self.v0 / self.a if self.a else 0.0
        s = self.at(np.array([0.0, min(max(turn, 0.0), self.duration), self.duration]))
        return Reach(s.x.min(), s.x.max(), np.abs(s.v).max(), abs(self.a))


def sampled_reach(piece: Piece) -> Reach:
    """Reach of a piece without a closed form, from 128 samples per period of its quickest oscillation.

    A sample misses a peak of a sine by less than (pi / 128)^2 / 2 = 0.03 %.
    """
    n = max(int(np.ceil(128 * piece.duration / piece.swiftest)), 256) + 1
    s = piece.at(np.linspace(0.0, piece.duration, n))
    return Reach(s.x.min(), s.x.max(), np.abs(s.v).max(), np.abs(s.a).max())


@dataclass(frozen=True)
class Trajectory:
    """A row of pieces, continuous in depth and speed. Before it begins and after it ends it holds still."""

    pieces: tuple[Piece, ...]

    def __post_init__(self) -> None:
        if not self.pieces:
            raise ProfileError("a motion needs at least one piece")
        for a, b in pairwise(self.pieces):
            end, start = _ends(a)[1], _ends(b)[0]
            if abs(end.x - start.x) > _GAP or abs(end.v - start.v) > _GAP:
                raise ProfileError(f"the motion jumps from {end.x * 1e3:.4f} mm to {start.x * 1e3:.4f} mm between two of its pieces")

    @cached_property
    def _starts(self) -> np.ndarray:
        return np.concatenate([[0.0], np.cumsum([p.duration for p in self.pieces])])

    @property
    def duration(self) -> float:
        """Length in s."""
        return float(self._starts[-1])

    @cached_property
    def start(self) -> float:
        """Depth at the beginning, m."""
        return float(_ends(self.pieces[0])[0].x)

    @cached_property
    def end(self) -> float:
        """Depth at the end, m."""
        return float(_ends(self.pieces[-1])[1].x)

    def sample(self, t: Any) -> State:
        """State at times `t`, of any shape. Outside [0, duration] the plunger rests at `start` or `end`."""
        t = np.asarray(t, float)
        flat = np.atleast_1d(t).ravel()
        inside = np.clip(flat, 0.0, self.duration)
        owner = np.clip(np.searchsorted(self._starts, inside, side="right") - 1, 0, len(self.pieces) - 1)
        out = np.empty((3, flat.size))
        for i in np.unique(owner):
            mine = owner == i
            out[:, mine] = self.pieces[i].at(np.minimum(inside[mine] - self._starts[i], self.pieces[i].duration))
        out[1:, (flat < 0.0) | (flat > self.duration)] = 0.0
        return State(*(row.reshape(t.shape) for row in out))

    def knots(self, period: float) -> np.ndarray:
        """Times at which to hand the motion to a cubic interpolator: wherever two pieces meet, and in between about every `period` s.

        A piece of constant acceleration is a cubic, so it arrives exactly. An oscillation gets 24 knots per period: h^4 / 384 of its
        fourth derivative is 0.001 % of its amplitude. Whole nanoseconds, because that is what a message carries.
        """
        steps = [min(period, piece.swiftest / 24.0) for piece in self.pieces]
        counts = [max(int(np.ceil(piece.duration / step)), 1) for piece, step in zip(self.pieces, steps, strict=True)]
        grids = [a + (b - a) * np.arange(n) / n for (a, b), n in zip(pairwise(self._starts), counts, strict=True)]
        return np.unique(np.round([*np.concatenate(grids), self.duration], 9))

    def reach(self) -> Reach:
        """How far the whole motion goes."""
        total = self.pieces[0].reach()
        for piece in self.pieces[1:]:
            total = total.joined(piece.reach())
        return total

    def then(self, other: "Trajectory") -> "Trajectory":
        """This motion, and right after it another. Raises `ProfileError` where they do not meet."""
        return Trajectory((*self.pieces, *other.pieces))


def _ends(piece: Piece) -> tuple[State, State]:
    x, v, a = piece.at(np.array([0.0, piece.duration]))
    return State(x[0], v[0], a[0]), State(x[1], v[1], a[1])
