"""Take the present mean of the unloaded sensors as their zero, with the driver's service. Only where a battery says so, never by itself."""

from dataclasses import dataclass
from typing import ClassVar

from skin_motion_profiles.entry import Action
from skin_motion_profiles.profile import seconds


@dataclass(frozen=True)
class Tare(Action):
    """To be done in free air: put `free_air` before it, the driver refuses a tare nearer to the surface than 0.1 mm."""

    kind: ClassVar[str] = "tare"
    example: ClassVar = {}

    duration_s: float = seconds("over which to average; 0: the driver's own", 0.0)
