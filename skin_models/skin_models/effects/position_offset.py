"""Position offset: the zero of the encoder is not the surface of the skin.

    tip depth = x + offset        positive: the skin is met before the encoder reads zero

The thesis's stage is true to 5 um and comes to rest 1 to 5 um from where it should (sections 3.1 and 5.1): half of that is no offset to
speak of.

Source: geometry.
"""

from dataclasses import dataclass
from typing import ClassVar

from skin_models.effect import Memoryless, Place
from skin_models.parameter import quantity


@dataclass(frozen=True)
class PositionOffset(Memoryless):
    """The plunger is deeper than the encoder says."""

    cause: ClassVar[str] = "position_offset"
    places: ClassVar = {"rig": Place.DEPTH}
    source: ClassVar[str] = "geometry"
    linear: ClassVar[bool] = True

    offset: float = quantity("m", 0.0, lower=-0.02, upper=0.02, typical=0.15e-3, negligible=2.5e-6, doc="tip depth minus encoder depth")

    def apply(self, y, s):
        """x + offset."""
        return y + self.offset
