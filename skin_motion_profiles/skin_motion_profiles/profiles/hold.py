"""Stay where the plunger is, in the skin or above it."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

from skin_motion_profiles.moves import hold
from skin_motion_profiles.profile import Profile, seconds
from skin_motion_profiles.trajectory import Piece


@dataclass(frozen=True)
class Hold(Profile):
    """A rest at the present depth."""

    kind: ClassVar[str] = "hold"
    example: ClassVar = {"duration_s": 2.0}

    duration_s: float = seconds("of the rest", ...)

    def pieces(self, start: float) -> Iterable[Piece]:
        """A rest at `start` (m)."""
        return hold(start, self.duration_s)
