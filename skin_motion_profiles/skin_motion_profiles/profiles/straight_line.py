"""A straight line with a trapezoid of speed, to a depth or by a way (the thesis's straight-line move, section 3.2.2)."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.moves import hold, line
from skin_motion_profiles.profile import MM, Moving, depth, speed
from skin_motion_profiles.trajectory import Piece

_A_MOMENT = 0.01  # s


@dataclass(frozen=True)
class StraightLine(Moving):
    """From where the plunger is: absolute with `to_mm`, relative with `by_mm`."""

    kind: ClassVar[str] = "straight_line"
    example: ClassVar = {"to_mm": 1.0}

    to_mm: float | None = depth("depth to go to")
    by_mm: float | None = depth("way to go, positive into the skin")
    speed_mm_s: float = speed("mm/s, cruising speed")

    def check(self) -> None:
        """Raise `ProfileError` unless there is either a depth to go to or a way."""
        if (self.to_mm is None) == (self.by_mm is None):
            raise ProfileError(f"{self.label} needs either to_mm (absolute) or by_mm (relative), and not both")

    def pieces(self, start: float) -> Iterable[Piece]:
        """A line from `start` (m); a moment's rest where the plunger is there already."""
        there = start + self.by_mm * MM if self.to_mm is None else self.to_mm * MM
        # Being there already is no mistake: the goal then ends at once.
        return line(start, there, self.speed_mm_s * MM, self.acceleration_mm_s2 * MM) or hold(start, _A_MOMENT)
