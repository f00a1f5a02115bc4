"""Off centre: the contact is not where it was said to be.

    share' = share * K(p - d) / K(p)        p: where a taxel is from the place declared,  K: the kernel of the spread

Source: thesis section 4.3.4 (the load profile over the distance from the taxel's centre).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Place
from skin_models.parameter import quantity
from skin_models.spread.bending import Bending


@dataclass(frozen=True)
class OffCentre(Bending):
    """A contact beside the place declared."""

    cause: ClassVar[str] = "off_centre"
    places: ClassVar = {"rig": Place.SPREAD}
    source: ClassVar[str] = "thesis 4.3.4"
    rank: ClassVar[int] = 0
    radial: ClassVar[bool] = False

    dx: float = quantity(
        "m", 0.0, lower=-0.1, upper=0.1, typical=1.5e-3, doc="where the contact really is along x, from the place declared"
    )
    dy: float = quantity("m", 0.0, lower=-0.1, upper=0.1, typical=0.5e-3, doc="and along y")

    def seen(self, offset, x, width):
        """p - d."""
        return offset - np.array(self.shift()).reshape(2, *([1] * (offset.ndim - 1)))

    def reach(self, r, x, width):
        """r + |d|."""
        return r + float(np.hypot(self.dx, self.dy))

    def shift(self):
        """d = (dx, dy)."""
        return self.dx, self.dy
