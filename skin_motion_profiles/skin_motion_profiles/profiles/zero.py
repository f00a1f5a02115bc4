"""Find the surface with the driver's service and count depths from there (thesis section 3.2.2)."""

from dataclasses import dataclass
from typing import ClassVar

from skin_motion_profiles.entry import Action
from skin_motion_profiles.fields import number, whole


@dataclass(frozen=True)
class Zero(Action):
    """Depths of everything after it are counted from the surface that was found."""

    kind: ClassVar[str] = "zero"
    example: ClassVar = {}

    threshold_v: float = number("V, rise of the load cell's rolling mean; 0: the driver's own", 0.0, lower=0.0, upper=1.0)
    samples: int = whole("length of the rolling mean; 0: the driver's own", 0, upper=10000)
