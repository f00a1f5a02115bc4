"""Paths of one axis: cubic Hermite through set points, as the servo interface of the thesis's rig interpolates (section 3.2.1).

A segment of constant acceleration is a Hermite segment exactly, so braking and retracting need no other kind of path.
"""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Trajectory:
    """Set points: times (s, growing), depths (m), speeds (m/s). Before the first and after the last the axis rests there."""

    t: tuple[float, ...]
    x: tuple[float, ...]
    v: tuple[float, ...]

    @property
    def end(self) -> float:
        """Time of the last set point, s."""
        return self.t[-1]

    def at(self, t: float) -> tuple[float, float]:
        """Depth (m) and speed (m/s) at time `t` (s)."""
        i = bisect_right(self.t, t)
        if i == 0:
            return self.x[0], 0.0
        if i == len(self.t):
            return self.x[-1], self.v[-1] if t == self.t[-1] else 0.0
        h = self.t[i] - self.t[i - 1]
        s = (t - self.t[i - 1]) / h
        x0, x1, v0, v1 = self.x[i - 1], self.x[i], h * self.v[i - 1], h * self.v[i]
        c2, c3 = 3.0 * (x1 - x0) - 2.0 * v0 - v1, 2.0 * (x0 - x1) + v0 + v1
        return x0 + s * (v0 + s * (c2 + s * c3)), (v0 + s * (2.0 * c2 + s * 3.0 * c3)) / h

    def until(self, t: float) -> "Trajectory":
        """The set points before `t`."""
        i = bisect_right(self.t, t)
        i -= int(i > 0 and self.t[i - 1] == t)
        return Trajectory(self.t[:i], self.x[:i], self.v[:i])

    def since(self, t: float) -> "Trajectory":
        """The set points from the last one at or before `t`: what is still needed at `t`."""
        i = max(bisect_right(self.t, t) - 1, 0)
        return Trajectory(self.t[i:], self.x[i:], self.v[i:])

    def then(self, other: "Trajectory") -> "Trajectory":
        """The set points of both, in order."""
        return Trajectory(self.t + other.t, self.x + other.x, self.v + other.v)

    def shifted(self, dt: float = 0.0, dx: float = 0.0) -> "Trajectory":
        """The same path later by `dt` and deeper by `dx`."""
        return Trajectory(tuple(t + dt for t in self.t), tuple(x + dx for x in self.x), self.v)


@dataclass(frozen=True)
class Extremes:
    """What a path reaches: depths (m), speed (m/s), mean acceleration of its steepest segment and peak acceleration (m/s^2)."""

    lowest: float
    deepest: float
    speed: float
    acceleration: float
    peak_acceleration: float


def extremes(path: Trajectory) -> Extremes:
    """The exact extremes of the cubics."""
    t, x, v = (np.array(p) for p in (path.t, path.x, path.v))
    h = np.diff(t)
    if h.size == 0:
        return Extremes(min(path.x), max(path.x), max(map(abs, path.v)), 0.0, 0.0)
    c2 = (3.0 * np.diff(x) / h - 2.0 * v[:-1] - v[1:]) / h
    c3 = (v[:-1] + v[1:] - 2.0 * np.diff(x) / h) / h**2
    turning = [_position(x, v, c2, c3, s) for s in _roots(3.0 * c3, 2.0 * c2, v[:-1], h)]
    fastest = -c2 / np.where(c3 == 0.0, np.inf, 3.0 * c3)
    inner = np.where((fastest > 0.0) & (fastest < h), v[:-1] + c2 * fastest, 0.0)
    depths = np.concatenate([x, *turning])
    return Extremes(
        lowest=float(depths.min()),
        deepest=float(depths.max()),
        speed=float(max(np.abs(v).max(), np.abs(inner).max())),
        acceleration=float(np.abs(np.diff(v) / h).max()),
        peak_acceleration=float(max(np.abs(2.0 * c2).max(), np.abs(2.0 * c2 + 6.0 * c3 * h).max())),
    )


def _roots(a: np.ndarray, b: np.ndarray, c: np.ndarray, h: np.ndarray) -> list[np.ndarray]:
    """Both roots of a s^2 + b s + c in every segment, moved into [0, h] where they lie outside or are not real."""
    root = np.sqrt(np.maximum(b * b - 4.0 * a * c, 0.0))
    q = -0.5 * (b + np.copysign(root, b))
    with np.errstate(divide="ignore", invalid="ignore"):
        candidates = (q / a, c / q)
    return [np.clip(np.nan_to_num(s, nan=0.0, posinf=0.0, neginf=0.0), 0.0, h) for s in candidates]


def _position(x: np.ndarray, v: np.ndarray, c2: np.ndarray, c3: np.ndarray, s: np.ndarray) -> np.ndarray:
    return x[:-1] + s * (v[:-1] + s * (c2 + s * c3))


def brake(t: float, x: float, v: float, acceleration: float) -> Trajectory:
    """From depth `x` and speed `v` at time `t` to rest with constant deceleration (m/s^2)."""
    if v == 0.0:
        return Trajectory((t,), (x,), (0.0,))
    return Trajectory((t, t + abs(v) / acceleration), (x, x + 0.5 * v * abs(v) / acceleration), (v, 0.0))


def quickest(t: float, x: float, v: float, target: float, speed: float, acceleration: float) -> Trajectory:
    """The quickest path from depth `x` and speed `v` at time `t` to rest at `target` under both limits.

    Bang-bang with a cruise: accelerate towards the target, cruise, brake. An overshoot that braking cannot avoid is part of it.
    """
    miss = target - x - 0.5 * v * abs(v) / acceleration
    a = math.copysign(acceleration, miss)
    peak = math.copysign(min(math.sqrt(max(a * (target - x) + 0.5 * v * v, 0.0)), max(speed, abs(v))), miss)
    x1, x2 = x + (peak * peak - v * v) / (2.0 * a), target - peak * peak / (2.0 * a)
    t1 = t + (peak - v) / a
    t2 = t1 + ((x2 - x1) / peak if peak else 0.0)
    return _without_repeats((t, t1, t2, t2 + abs(peak) / acceleration), (x, x1, x2, target), (v, peak, peak, 0.0))


def _without_repeats(t: Sequence[float], x: Sequence[float], v: Sequence[float]) -> Trajectory:
    points = [(t[0], x[0], v[0])]
    for point in zip(t[1:], x[1:], v[1:], strict=True):
        if point[0] - points[-1][0] > 1e-9:
            points.append(point)
        else:
            points[-1] = (points[-1][0], *point[1:])
    return Trajectory(*zip(*points, strict=True))
