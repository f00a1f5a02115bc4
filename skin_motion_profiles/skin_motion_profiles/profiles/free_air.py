"""Wait in the air: what the sensors say there is their offset, and its creep from one such wait to the next is their drift."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

from skin_motion_profiles.fields import number
from skin_motion_profiles.moves import hold
from skin_motion_profiles.profile import MM, Profile, seconds
from skin_motion_profiles.trajectory import Piece


@dataclass(frozen=True)
class FreeAir(Profile):
    """A rest above the surface."""

    kind: ClassVar[str] = "free_air"
    example: ClassVar = {"duration_s": 2.0}

    duration_s: float = seconds("of the wait", 2.0)
    clearance_mm: float = number("mm, height above the surface", 1.0, lower=0.01, upper=150.0)

    def pieces(self, start: float) -> Iterable[Piece]:
        """A rest above the surface; `start` does not matter."""
        return hold(-self.clearance_mm * MM, self.duration_s)
