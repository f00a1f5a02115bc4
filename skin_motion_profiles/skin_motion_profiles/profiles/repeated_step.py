"""The same step again and again (the thesis's repeated step input, section 3.2.2; figures 4-4, 4-5 and 4-8)."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

from skin_motion_profiles.fields import whole
from skin_motion_profiles.profile import Moving, check_presses, depth, seconds, speed
from skin_motion_profiles.trajectory import Piece


@dataclass(frozen=True)
class RepeatedStep(Moving):
    """`repeats` times from `base_mm` to `depth_mm` and back, with a wait at either end."""

    kind: ClassVar[str] = "repeated_step"
    example: ClassVar = {"depth_mm": 1.0, "repeats": 3}

    depth_mm: float = depth("depth of every step", ...)
    base_mm: float = depth("depth in between", 0.0)
    repeats: int = whole("steps", 5, lower=1, upper=100000)
    speed_mm_s: float = speed(default=10.0)
    hold_s: float = seconds("at the depth of the step", 1.0)
    rest_s: float = seconds("at the base after every step", 1.0)

    def check(self) -> None:
        """Raise `ProfileError` where it goes up into the air."""
        check_presses(self.label, "depth_mm", (self.depth_mm,), self.base_mm)

    def pieces(self, start: float) -> Iterable[Piece]:
        """Down, hold, back and rest, again and again; `start` does not matter."""
        for _ in range(self.repeats):
            yield from self.line(self.base_mm, self.depth_mm, self.speed_mm_s)
            yield from self.rest(self.depth_mm, self.hold_s)
            yield from self.line(self.depth_mm, self.base_mm, self.speed_mm_s)
            yield from self.rest(self.base_mm, self.rest_s)
