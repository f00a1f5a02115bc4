"""Stair-step pyramid with a hold on every step, which the thesis calibrates taxels with (section 3.2.2)."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain, pairwise
from typing import ClassVar

from skin_motion_profiles.fields import whole
from skin_motion_profiles.profile import Moving, check_presses, depth, seconds, speed
from skin_motion_profiles.trajectory import Piece


@dataclass(frozen=True)
class StairStep(Moving):
    """`steps` equal steps from `base_mm` down to `depth_mm` and the same steps back up."""

    kind: ClassVar[str] = "stair_step"
    example: ClassVar = {"depth_mm": 1.0, "steps": 4, "hold_s": 0.5}

    depth_mm: float = depth("depth of the last step", ...)
    base_mm: float = depth("depth before the first step", 0.0)
    steps: int = whole("steps down, and as many up", 5, lower=1, upper=10000)
    speed_mm_s: float = speed()
    hold_s: float = seconds("on every step", 1.0)

    def check(self) -> None:
        """Raise `ProfileError` where it goes up into the air."""
        check_presses(self.label, "depth_mm", (self.depth_mm,), self.base_mm)

    def pieces(self, start: float) -> Iterable[Piece]:
        """Line and hold for every step, down and back up; `start` does not matter."""
        stairs = [self.base_mm + (self.depth_mm - self.base_mm) * i / self.steps for i in range(self.steps + 1)]
        yield from self.rest(self.base_mm, self.hold_s)
        for a, b in pairwise(chain(stairs, reversed(stairs[:-1]))):
            yield from self.line(a, b, self.speed_mm_s)
            yield from self.rest(b, self.hold_s)
