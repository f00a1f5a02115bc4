"""The commanded motion of the axis: it follows paths, and is stopped within the limits. Depths in m, times in s of the driver's clock.

Splice rule: a command replaces everything from the time of its first set point on, and must continue there what the axis is doing.
If it begins later than the present path ends, the axis goes from rest there to its first set point, in one Hermite segment. If it
begins in the past it counts from now on. A path that ends with speed means that more is to come; if nothing comes the commander has
died, and the axis brakes within the limits and stays `STOPPED`.
"""

import math
from dataclasses import replace
from enum import Enum

import numpy as np

from skin_testbed_driver.safety import HOW_TO_RESET, CommandError, Limits, Stop, check_trajectory
from skin_testbed_driver.trajectory import Trajectory, brake, quickest

_ABSURD = 1e3  # m or m/s, beyond which a set point is no mistake of a user but of a program: such numbers overflow
_AT_REST = 1e-6  # m/s, an end speed below this is a rest
_SPLICE_DEPTH = 2e-5  # m, by how much a command may jump where it is spliced in
_SPLICE_STEPS = 0.02  # s, and its speed by this many seconds of the greatest acceleration
# In a very short segment the rounding of a depth, or a stage that rests a few micrometres beside its target, looks like a jerk.
_SPLICE_TIME = 0.01  # s from the last set point of the old path to the first of the new one
_CLEAR = 2e-3  # m, by how much an over-force retracts at least
_SHORTEST = 2e-4  # s between set points of one command
_REPEATED_SPEED = 1e-3  # m/s, by which two set points that near to each other may differ and be one


class Activity(Enum):
    """The states of a driver that is active; named as in DriverState."""

    READY = 1
    MOVING = 2
    STOPPED = 3


class Motion:
    """State of the axis as commanded. Not thread-safe: its owner locks."""

    def __init__(self, limits: Limits, depth: float) -> None:
        """At rest at `depth` (m)."""
        self.limits = limits
        self.stopped: Stop | None = None
        self._path = Trajectory((-math.inf,), (depth,), (0.0,))
        self._runs_out = math.inf  # time at which a path with speed left ends

    def at(self, t: float) -> tuple[float, float]:
        """Wanted depth (m) and speed (m/s) at time `t` (s)."""
        return self._path.at(t)

    def advance(self, t: float) -> tuple[float, float]:
        """As `at`, and notice there that the commands have run out."""
        if t > self._runs_out:
            _, v = self._path.at(self._runs_out)
            self._runs_out = math.inf
            self.stopped = Stop(f"the commands ran out at {1e3 * v:.3f} mm/s: whoever moved the plunger has gone silent")
        return self._path.at(t)

    def activity(self, t: float) -> Activity:
        """What the axis is doing at time `t`."""
        if self.stopped is not None:
            return Activity.STOPPED
        return Activity.MOVING if t < self._path.end else Activity.READY

    def at_rest(self, t: float) -> bool:
        """Whether nothing more is to come after `t`."""
        return t >= self._path.end

    def follow(self, command: Trajectory, now: float) -> None:
        """Take over a command by the splice rule. Raises `CommandError`, and changes nothing, if it cannot be followed."""
        if self.stopped is not None:
            raise CommandError(f"the driver is stopped ({self.stopped.reason}): {HOW_TO_RESET}")
        path = self._spliced(_usable(command), now)
        tail = brake(path.end, path.x[-1], path.v[-1], self.limits.max_acceleration)
        ends_moving = abs(path.v[-1]) > _AT_REST
        whole = path.then(Trajectory(tail.t[1:], tail.x[1:], tail.v[1:])) if ends_moving else path
        check_trajectory(whole, self.limits, self.at(now)[0])
        self._path, self._runs_out = whole, path.end if ends_moving else math.inf

    def _spliced(self, command: Trajectory, now: float) -> Trajectory:
        end = min(self._path.end, self._runs_out)
        if command.t[0] > max(end, now) + _SPLICE_TIME:
            here = self._knot(max(end, now))
            return (self._path.since(now).until(end).then(here) if end > now else here).then(command)
        if command.end < now:
            raise CommandError(f"the command ended {now - command.end:.3f} s ago: check the clock of whoever sends it")
        first = max(command.t[0], now)
        self._check_jump(first, command)
        if command.t[0] < now:
            return command.since(now)
        return self._led_to(first, now).then(command) if first > now else command

    def _led_to(self, t: float, now: float) -> Trajectory:
        """The present path, from `now` to shortly before `t`."""
        last = t - _SPLICE_TIME
        kept = self._path.since(now).until(last)
        if kept.t and kept.t[0] > -math.inf:
            return kept
        begin = self._path.t[0]
        if last >= begin:
            return self._knot(min(last, now))
        x, v = self._path.x[0], self._path.v[0]
        return Trajectory((last,), (x + v * (last - begin),), (v,))

    def _check_jump(self, t: float, command: Trajectory) -> None:
        (x0, v0), (x1, v1) = self._path.at(t), command.at(t)
        if abs(x1 - x0) > _SPLICE_DEPTH or abs(v1 - v0) > _SPLICE_STEPS * self.limits.max_acceleration:
            late = f" (it came {t - command.t[0]:.3f} s after its first point)" if t > command.t[0] else ""
            raise CommandError(
                f"the command jumps from {1e3 * x0:.3f} mm at {1e3 * v0:.3f} mm/s to {1e3 * x1:.3f} mm at {1e3 * v1:.3f} mm/s{late}"
            )

    def _knot(self, t: float) -> Trajectory:
        x, v = self._path.at(t)
        return Trajectory((t,), (x,), (v,))

    def go_to(self, depth: float, speed: float, now: float) -> None:
        """Go to rest at `depth` from whatever the axis is doing, at no more than `speed`."""
        x, v = self._path.at(now)
        speed = min(speed, self.limits.max_speed)
        self._path, self._runs_out = quickest(now, x, v, depth, speed, self.limits.max_acceleration), math.inf

    def rest(self, now: float) -> None:
        """Brake to rest within the limits."""
        x, v = self._path.at(now)
        self._path, self._runs_out = brake(now, x, v, self.limits.max_acceleration), math.inf

    def stop(self, stop: Stop, now: float) -> None:
        """Stop because of `stop`. While stopped, only two things change anything: a first over-force, and a position lost while at rest."""
        if self.stopped is not None and (self.stopped.retract or not stop.retract):
            if stop.lost and self.at_rest(now):  # no longer held where it was: it may come back elsewhere
                self.stopped = replace(self.stopped, lost=True)
            return
        self.stopped = stop
        if stop.retract:
            x, _ = self._path.at(now)
            # Only backwards: what was hit may lie above what is taken for the surface.
            back = min(self.limits.retracted_depth, max(x - _CLEAR, min(self.limits.min_depth, x)))
            self.go_to(back, self.limits.max_speed, now)
        else:
            self.rest(now)

    def reset(self, depth: float, now: float) -> None:
        """End a stop. The axis rests at the measured `depth`. Raises `CommandError` while it still moves."""
        if not self.at_rest(now):
            raise CommandError("the plunger still moves: call reset again when it rests")
        if math.isnan(depth):
            raise CommandError("the encoder gives no fresh reading: the depth is not known")
        self.stopped = None
        self.stand(depth, now)

    def stand(self, depth: float, now: float) -> None:
        """Rest at `depth` (m), where the axis is: it does not move for that. A stop remains one."""
        self._path, self._runs_out = Trajectory((now,), (depth,), (0.0,)), math.inf

    def shift(self, dx: float) -> None:
        """Move the zero of depth: all depths grow by `dx` (m)."""
        self._path = self._path.shifted(dx=dx)


def _usable(command: Trajectory) -> Trajectory:
    """`command`, if its numbers make a path. Missing speeds (an empty tuple) become central differences, with rest at the end."""
    t, x = np.array(command.t), np.array(command.x)
    if t.size == 0 or t.size != x.size or (command.v and len(command.v) != t.size):
        raise CommandError("the command needs one position per point, and one velocity per point or none at all")
    if not (np.isfinite(t).all() and np.isfinite(x).all() and np.isfinite(command.v).all()):
        raise CommandError("the command has a point that is not a finite number")
    farthest, fastest = np.abs(x).max(), max(map(abs, command.v), default=0.0)
    if max(farthest, fastest) > _ABSURD:
        what = f"{farthest:.3g} m from the surface" if farthest > _ABSURD else f"passed at {fastest:.3g} m/s"
        raise CommandError(f"the command has a point {what}, and no stage does that")
    if (np.diff(t) <= 0.0).any():
        raise CommandError("the command's points are not in order of time_from_start")
    if command.v:
        return _thinned(command)
    v = np.gradient(x, t) if t.size > 2 else np.zeros(t.size)
    v[-1] = 0.0
    return _thinned(replace(command, v=tuple(v.tolist())))


def _thinned(command: Trajectory) -> Trajectory:
    """`command` without the points that say nothing new because the next one is a moment later and nearly the same."""
    if (np.diff(command.t) >= _SHORTEST).all():
        return command
    kept = [len(command.t) - 1]
    for i in range(kept[0] - 1, -1, -1):
        if not _is_repeated(command, i, kept[-1]):
            kept.append(i)
    kept.reverse()
    return Trajectory(*(tuple(column[i] for i in kept) for column in (command.t, command.x, command.v)))


def _is_repeated(command: Trajectory, i: int, j: int) -> bool:
    t, x, v = command.t[j] - command.t[i], command.x[j] - command.x[i], command.v[j] - command.v[i]
    return t < _SHORTEST and abs(x - command.v[i] * t) < _SPLICE_DEPTH and abs(v) < _REPEATED_SPEED
