"""Hold the skin at a constant strain and watch its force decay (stress relaxation, thesis section 4.1, figure 4-3)."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.fields import number, numbers
from skin_motion_profiles.profile import Moving, check_presses, depth, seconds, speed
from skin_motion_profiles.trajectory import Piece


@dataclass(frozen=True)
class ConstantStrainHold(Moving):
    """For every depth: go there, hold, return to `base_mm` and rest. Depths in mm, or as strains of a skin `thickness_mm` thick."""

    kind: ClassVar[str] = "constant_strain_hold"
    example: ClassVar = {"depths_mm": [0.5, 1.0], "hold_s": 3.0, "rest_s": 1.0}

    depths_mm: tuple[float, ...] | None = numbers("mm, depths at which to hold", None, lower=-150.0, upper=150.0)
    strains: tuple[float, ...] | None = numbers("depth as a fraction of the thickness", None, lower=0.0, upper=1.0)
    thickness_mm: float | None = number("mm, thickness of the skin", None, lower=0.01, upper=150.0)
    base_mm: float = depth("depth in between", 0.0)
    speed_mm_s: float = speed(default=10.0)
    hold_s: float = seconds("at every depth", 10.0)
    rest_s: float = seconds("at the base after every hold, for the skin to recover", 5.0)

    def check(self) -> None:
        """Raise `ProfileError` unless there are depths, all into the skin, or strains with a thickness."""
        if (self.depths_mm is None) == (self.strains is None):
            raise ProfileError(f"{self.label} needs either depths_mm or strains, and not both")
        if (self.strains is None) != (self.thickness_mm is None):
            raise ProfileError(f"{self.label}: strains and thickness_mm belong together")
        check_presses(self.label, "depths_mm", self.depths_mm or (), self.base_mm)

    def pieces(self, start: float) -> Iterable[Piece]:
        """Down, hold, back and rest for every depth, strain times thickness; `start` does not matter."""
        for deep in self.depths_mm or [strain * self.thickness_mm for strain in self.strains]:
            yield from self.line(self.base_mm, deep, self.speed_mm_s)
            yield from self.rest(deep, self.hold_s)
            yield from self.line(deep, self.base_mm, self.speed_mm_s)
            yield from self.rest(self.base_mm, self.rest_s)
