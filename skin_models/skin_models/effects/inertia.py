"""Inertia: a real mass moves between load cell and skin.

    y' = y + M a        in the air too; its weight is tared away

Source: Newton's second law.
"""

from dataclasses import dataclass
from typing import ClassVar

from skin_models.effect import Memoryless, Place
from skin_models.parameter import quantity


@dataclass(frozen=True)
class Inertia(Memoryless):
    """The mass of plunger and adapter below the load cell."""

    cause: ClassVar[str] = "inertia"
    places: ClassVar = {"rig": Place.LOAD_CELL}
    source: ClassVar[str] = "Newton's second law"
    linear: ClassVar[bool] = True

    mass: float = quantity("kg", 0.0, lower=0.0, upper=50.0, typical=0.3, doc="moving mass M")

    def apply(self, y, s):
        """y + M a."""
        return y + self.mass * s.a
