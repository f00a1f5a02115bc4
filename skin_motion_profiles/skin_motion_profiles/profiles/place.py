"""Bring another point of the skin under the plunger, with the x-y stage. The plunger must be in the air."""

from dataclasses import dataclass
from typing import ClassVar

from skin_motion_profiles.entry import Action
from skin_motion_profiles.profile import depth


@dataclass(frozen=True)
class Place(Action):
    """The point of the skin's frame to be under the plunger. A motorised stage goes there; a person turns the screws of a manual one."""

    kind: ClassVar[str] = "place"
    example: ClassVar = {"x_mm": 3.0}

    x_mm: float = depth("along x of the skin's frame", 0.0)
    y_mm: float = depth("along y of the skin's frame", 0.0)
