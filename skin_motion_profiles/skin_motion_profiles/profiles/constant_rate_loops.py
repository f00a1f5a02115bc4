"""Triangles at several rates and amplitudes: what loops do with rate tells relaxation from hysteresis (thesis figures 4-1 and 4-2)."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from typing import ClassVar

from skin_motion_profiles.fields import numbers, whole
from skin_motion_profiles.profile import Moving, check_presses, depth, seconds
from skin_motion_profiles.trajectory import Piece


@dataclass(frozen=True)
class ConstantRateLoops(Moving):
    """For every depth, in the order given, and for every speed: `cycles` triangles from `base_mm` to the depth and back."""

    kind: ClassVar[str] = "constant_rate_loops"
    example: ClassVar = {"depths_mm": [0.5, 1.0], "speeds_mm_s": [1.0, 5.0], "cycles": 1}

    depths_mm: tuple[float, ...] = numbers("mm, turning points of the loops", ..., lower=-150.0, upper=150.0)
    speeds_mm_s: tuple[float, ...] = numbers("mm/s, speeds of the loops", ..., lower=1e-3, upper=1e3)
    base_mm: float = depth("the other turning point", 0.0)
    cycles: int = whole("loops of each depth and speed", 2, lower=1, upper=100000)
    rest_s: float = seconds("at the base between two speeds", 0.0)

    def check(self) -> None:
        """Raise `ProfileError` where it goes up into the air."""
        check_presses(self.label, "depths_mm", self.depths_mm, self.base_mm)

    def pieces(self, start: float) -> Iterable[Piece]:
        """Triangles, the speeds of one depth before the next depth; `start` does not matter."""
        for deep, pace in product(self.depths_mm, self.speeds_mm_s):
            for _ in range(self.cycles):
                yield from self.line(self.base_mm, deep, pace)
                yield from self.line(deep, self.base_mm, pace)
            yield from self.rest(self.base_mm, self.rest_s)
