"""Ramps to a list of depths that a person typed (the thesis's pseudo-random moves are typed into an array, section 3.2.2)."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import cycle, pairwise
from typing import ClassVar

from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.fields import numbers
from skin_motion_profiles.profile import Moving, seconds
from skin_motion_profiles.trajectory import Piece


@dataclass(frozen=True)
class RampList(Moving):
    """One ramp to each depth after the first, where it begins. Speeds and holds are used in turn when there are fewer of them."""

    kind: ClassVar[str] = "ramp_list"
    example: ClassVar = {"depths_mm": [0.0, 0.6, 0.2, 1.0, 0.5, 0.8, 0.0], "speeds_mm_s": 1.0}

    depths_mm: tuple[float, ...] = numbers("mm, depths in order; it begins at the first", ..., lower=-150.0, upper=150.0)
    speeds_mm_s: tuple[float, ...] = numbers("mm/s, speed of every ramp", (1.0,), lower=1e-3, upper=1e3)
    hold_s: float = seconds("after every ramp", 0.0)

    def check(self) -> None:
        """Raise `ProfileError` for fewer than two depths."""
        if len(self.depths_mm) < 2:
            raise ProfileError(f"{self.label}: depths_mm needs at least two depths")

    def pieces(self, start: float) -> Iterable[Piece]:
        """Ramp and hold for every depth after the first; `start` does not matter."""
        for (a, b), speed in zip(pairwise(self.depths_mm), cycle(self.speeds_mm_s), strict=False):
            yield from self.line(a, b, speed)
            yield from self.rest(b, self.hold_s)
