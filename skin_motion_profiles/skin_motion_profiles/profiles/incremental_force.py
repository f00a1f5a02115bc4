"""Incremental force control, as developed for the thesis's testbed (section 3.2.2).

The sign of the difference between desired and measured force decides the direction of the next straight-line move, whose way is always
the same increment. Easy and robust whatever the skin is; slow, and it chatters by one increment about its target.
"""

from dataclasses import dataclass
from math import copysign
from typing import ClassVar

from skin_motion_profiles.control import Controlled
from skin_motion_profiles.fields import number
from skin_motion_profiles.moves import line
from skin_motion_profiles.profile import MM, seconds
from skin_motion_profiles.trajectory import Piece, State


@dataclass(frozen=True)
class IncrementalForce(Controlled):
    """Press with `force_n` for `duration_s`, by increments of depth."""

    kind: ClassVar[str] = "incremental_force"
    example: ClassVar = {"force_n": 5.0, "deepest_mm": 1.5, "duration_s": 10.0}

    force_n: float = number("N, desired force", lower=0.0, upper=1e4)
    increment_mm: float = number("mm, way of every move", 0.01, lower=1e-4, upper=1.0)
    tolerance_n: float = number("N, no move while the force is nearer than this; 0 as in the thesis", 0.0, lower=0.0, upper=1e3)
    duration_s: float = seconds("of the whole", 10.0)

    @property
    def duration(self) -> float:
        """Time for which the force is controlled, s."""
        return self.duration_s

    def target(self, t: float) -> tuple[float, float]:
        """The one force (N), at every time; its rate is 0."""
        return self.force_n, 0.0

    def answer(self, t: float, state: State, force: float, age: float) -> tuple[Piece, ...]:
        """One increment in the direction of the error, once the last one is over; none within the tolerance."""
        error = self.force_n - force
        if state.v != 0.0 or abs(error) <= self.tolerance_n:
            return ()
        there = min(max(state.x + copysign(self.increment_mm * MM, error), self.highest_mm * MM), self.deepest_mm * MM)
        return line(state.x, there, self.speed_mm_s * MM, self.acceleration_mm_s2 * MM)
