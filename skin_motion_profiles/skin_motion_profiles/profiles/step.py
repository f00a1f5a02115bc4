"""One step: down, hold, back (the thesis's single step input, section 3.2.2)."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

from skin_motion_profiles.profile import Moving, check_presses, depth, seconds, speed
from skin_motion_profiles.trajectory import Piece


@dataclass(frozen=True)
class Step(Moving):
    """From `base_mm` to `depth_mm`, wait, and back. As quick as speed and acceleration allow: a stage cannot jump."""

    kind: ClassVar[str] = "step"
    example: ClassVar = {"depth_mm": 1.0}

    depth_mm: float = depth("depth of the step", ...)
    base_mm: float = depth("depth before and after", 0.0)
    speed_mm_s: float = speed(default=10.0)
    hold_s: float = seconds("at the depth of the step", 2.0)
    rest_s: float = seconds("at the base before and after", 0.5)

    def check(self) -> None:
        """Raise `ProfileError` where it goes up into the air."""
        check_presses(self.label, "depth_mm", (self.depth_mm,), self.base_mm)

    def pieces(self, start: float) -> Iterable[Piece]:
        """Rest, down, hold, back, rest; `start` does not matter."""
        yield from self.rest(self.base_mm, self.rest_s)
        yield from self.line(self.base_mm, self.depth_mm, self.speed_mm_s)
        yield from self.rest(self.depth_mm, self.hold_s)
        yield from self.line(self.depth_mm, self.base_mm, self.speed_mm_s)
        yield from self.rest(self.base_mm, self.rest_s)
