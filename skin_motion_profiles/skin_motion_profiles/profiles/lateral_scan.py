"""The same profile at points along a line of the skin: the spread of a taxel, or a walk over an array (thesis sections 4.3.3, 4.3.4)."""

from dataclasses import dataclass
from math import cos, radians, sin
from typing import ClassVar

from skin_motion_profiles.entry import Entry, Group
from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.fields import another, number, numbers
from skin_motion_profiles.profile import depth, seconds
from skin_motion_profiles.profiles.free_air import FreeAir
from skin_motion_profiles.profiles.place import Place
from skin_motion_profiles.profiles.step import Step


@dataclass(frozen=True)
class LateralScan(Group):
    """At every offset from (`x_mm`, `y_mm`), in direction `angle_deg`: up into the air, over to the point, then `profile`."""

    kind: ClassVar[str] = "lateral_scan"
    example: ClassVar = {"offsets_mm": [0.0, 3.0, 6.0], "depth_mm": 1.0}

    offsets_mm: tuple[float, ...] = numbers("mm, distances from the origin of the scan", ..., lower=-150.0, upper=150.0)
    x_mm: float = depth("origin of the scan along x of the skin's frame", 0.0)
    y_mm: float = depth("origin along y", 0.0)
    angle_deg: float = number("degrees, direction of the scan, from x towards y", 0.0, lower=-360.0, upper=360.0)
    clearance_mm: float = number("mm, height above the surface while moving sideways", 1.0, lower=0.01, upper=150.0)
    settle_s: float = seconds("in the air before every depression", 1.0)
    depth_mm: float | None = depth("depth of a step at every point, instead of a profile")
    profile: Entry | None = another("what to do at every point", None)  # noqa: RUF009  (it is a field)

    def check(self) -> None:
        """Raise `ProfileError` unless there is either a depth or a profile."""
        if (self.profile is None) == (self.depth_mm is None):
            raise ProfileError(f"{self.label} needs either depth_mm or a profile to do at every point, and not both")

    def entries(self) -> tuple[Entry, ...]:
        """At every point: up, across, a rest in the air, and the depression."""
        c, s = cos(radians(self.angle_deg)), sin(radians(self.angle_deg))
        air = FreeAir(duration_s=max(self.settle_s, 0.01), clearance_mm=self.clearance_mm)
        points = [Place(x_mm=self.x_mm + c * r, y_mm=self.y_mm + s * r) for r in self.offsets_mm]
        press = Step(depth_mm=self.depth_mm) if self.profile is None else self.profile
        return (*(e for point in points for e in (air, point, air, press)), air)
