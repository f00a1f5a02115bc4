"""Spread width: the kernel has the right shape with the wrong width.

    K'(p) = K(p / (1 + g))        the share right under the contact stays: it was measured there

Source: thesis section 4.3.4 (c differs between silicone, 5.25 mm, and Frubber, 4.17 mm).
"""

from dataclasses import dataclass
from typing import ClassVar

from skin_models.effect import Place
from skin_models.parameter import quantity
from skin_models.spread.bending import Bending


@dataclass(frozen=True)
class SpreadWidth(Bending):
    """A wider or narrower kernel."""

    cause: ClassVar[str] = "spread_width"
    places: ClassVar = {"skin": Place.SPREAD}
    source: ClassVar[str] = "thesis 4.3.4"
    rank: ClassVar[int] = 2

    wider: float = quantity("1", 0.0, lower=-0.9, upper=9.0, typical=0.25, doc="relative change g of the width")

    def seen(self, offset, x, width):
        """p / (1 + g)."""
        return offset / (1.0 + self.wider)

    def reach(self, r, x, width):
        """r (1 + g)."""
        return r * (1.0 + self.wider)
