"""Loops within a loop: hysteresis remembers its turning points, relaxation does not.

Down to `depth_mm`; from there, for every return depth, up to it and down again; then back to the base. The same excursions follow from
the base, down to every return depth and up again.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

from skin_motion_profiles.fields import numbers
from skin_motion_profiles.profile import Moving, check_presses, depth, speed
from skin_motion_profiles.trajectory import Piece


@dataclass(frozen=True)
class MinorLoops(Moving):
    """Unloading loops from the greatest depth, loading loops from the base."""

    kind: ClassVar[str] = "minor_loops"
    example: ClassVar = {"depth_mm": 1.0, "returns_mm": [0.3, 0.6]}

    depth_mm: float = depth("greatest depth", ...)
    returns_mm: tuple[float, ...] = numbers("mm, depths at which the minor loops turn", ..., lower=-150.0, upper=150.0)
    base_mm: float = depth("least depth", 0.0)
    speed_mm_s: float = speed()

    def check(self) -> None:
        """Raise `ProfileError` where it goes up into the air."""
        check_presses(self.label, "depth_mm", (self.depth_mm,), self.base_mm)

    def pieces(self, start: float) -> Iterable[Piece]:
        """The minor loops at the greatest depth within the major loop, then those at the base; `start` does not matter."""
        yield from self._excursion(self.base_mm, self.depth_mm, self._tour(self.depth_mm))
        yield from self._tour(self.base_mm)

    def _excursion(self, a: float, b: float, there: Iterable[Piece]) -> Iterable[Piece]:
        yield from self.line(a, b, self.speed_mm_s)
        yield from there
        yield from self.line(b, a, self.speed_mm_s)

    def _tour(self, end: float) -> Iterable[Piece]:
        for turn in self.returns_mm:
            yield from self._excursion(end, turn, ())
