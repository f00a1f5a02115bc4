"""Motions that answer a measured force: a controller says anew, at every sample, how to go on from where the plunger will be.

A controller is a frozen entry without state of its own: all it remembers is the motion under way. Each answer is a whole motion that
ends at rest, so that a commander that falls silent leaves nothing moving.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import copysign, sqrt

from skin_motion_profiles.entry import Entry
from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.fields import number
from skin_motion_profiles.limits import Limits
from skin_motion_profiles.profile import MM, depth, speed
from skin_motion_profiles.trajectory import Arc, Piece, State

_CRUISE = 0.1  # s that a new speed is kept before braking, unless another answer comes first
_CREEP = 2e-6  # m/s; a micrometre in half a second is no motion
_NEAR = 1e-6  # m


@dataclass(frozen=True)
class Controlled(Entry, ABC):
    """What all force-controlled motions have in common: the room they may use, and how quick they may be."""

    deepest_mm: float = depth("the plunger never goes deeper", ...)
    highest_mm: float = depth("nor higher", -1.0)
    speed_mm_s: float = speed("mm/s, greatest speed", 1.0)
    search_mm_s: float = speed("mm/s, speed of the search for contact; what it overshoots is this times the delay of an answer", 0.2)
    contact_n: float = number("N, force that is contact: the time of the control begins there", 0.3, lower=0.0, upper=1e3)
    acceleration_mm_s2: float = number("mm/s^2, greatest acceleration", 100.0, lower=0.1, upper=1e5)

    def check(self) -> None:
        """Raise `ProfileError` where there is no room between `highest_mm` and `deepest_mm`, or the target contradicts itself."""
        if self.deepest_mm <= self.highest_mm:
            raise ProfileError(f"{self.label}: deepest_mm = {self.deepest_mm:g} must exceed highest_mm = {self.highest_mm:g}")
        self.check_target()

    def check_target(self) -> None:
        """Raise `ProfileError` where parameters of the target contradict each other."""

    @property
    @abstractmethod
    def duration(self) -> float:
        """Length in s."""

    @abstractmethod
    def target(self, t: float) -> tuple[float, float]:
        """The wanted force (N) and its rate (N/s) at time `t` (s)."""

    @abstractmethod
    def answer(self, t: float, state: State, force: float, age: float) -> tuple[Piece, ...]:
        """How to go on from `state`, which the plunger will have at `t` (s). `force` (N) was measured `age` s before. Empty: as planned."""

    def search(self, state: State) -> tuple[Piece, ...]:
        """How to go on from `state` while there is no contact; empty once the plunger rests at its greatest depth."""
        if state.v == 0.0 and state.x >= self.deepest_mm * MM - _NEAR:
            return ()
        return self.change_speed(state, min(self.search_mm_s, self.speed_mm_s) * MM)

    def change_speed(self, state: State, wanted: float) -> tuple[Piece, ...]:
        """From `state` to speed `wanted` (m/s) within the room and speed that this control has."""
        fastest = self.speed_mm_s * MM
        room = (self.highest_mm * MM, self.deepest_mm * MM)
        return change_speed(state, min(max(wanted, -fastest), fastest), room, self.acceleration_mm_s2 * MM)

    def slowest_sampling(self) -> float:
        """Longest time (s) from a force to its answer with which the control is sound."""
        return float("inf")

    def check_limits(self, limits: Limits, name: str) -> None:
        """Raise `ProfileError` naming the limit of the rig that this motion could leave."""
        for asked, allowed, what in (
            (self.deepest_mm, limits.max_depth, "deepest_mm"),
            (-self.highest_mm, -limits.min_depth, "highest_mm"),
            (self.speed_mm_s, limits.max_speed, "speed_mm_s"),
            (self.acceleration_mm_s2, limits.max_acceleration, "acceleration_mm_s2"),
        ):
            if asked * MM > allowed * (1.0 + 1e-9):
                raise ProfileError(f"{name}: {what} = {getattr(self, what):g} is beyond the limit of the rig, {abs(allowed) / MM:g}")


def change_speed(state: State, wanted: float, room: tuple[float, float], acceleration: float) -> tuple[Piece, ...]:
    """From `state` to speed `wanted` (m/s), which is kept for a moment, and then to rest. All SI.

    The speed is lowered where the motion would otherwise end outside the depths of `room` (m).
    """
    highest, deepest = _fastest(-state.v, state.x - room[0], acceleration), _fastest(state.v, room[1] - state.x, acceleration)
    u = min(max(wanted, -highest), deepest)
    u = u if abs(u) > _CREEP else 0.0
    change, rest = abs(u - state.v) / acceleration, abs(u) / acceleration
    x1 = state.x + 0.5 * (state.v + u) * change
    pieces = (
        Arc(change, state.x, state.v, copysign(acceleration, u - state.v)),
        Arc(_CRUISE, x1, u),
        Arc(rest, x1 + u * _CRUISE, u, -copysign(acceleration, u)),
    )
    return tuple(p for p in pieces if p.duration > 1e-6)


def _fastest(v: float, way: float, acceleration: float) -> float:
    """The greatest speed u >= 0 with which change from `v`, cruise c and brake together need no more than `way`.

    Where u >= v: (u^2 - v^2) / 2a + u c + u^2 / 2a = way; where u < v: v^2 / 2a + u c = way.
    """
    brake = 0.5 * v * v / acceleration
    u = 0.5 * acceleration * (sqrt(_CRUISE**2 + 4.0 * max(way + brake, 0.0) / acceleration) - _CRUISE)
    return u if u >= v else max(way - brake, 0.0) / _CRUISE
