"""Leaning: the contact moves aside as it goes deeper, because plunger or mount lean.

    share' = share * K(p - lean x) / K(p)        p: where a taxel is from the place declared,  x: depth,  K: the kernel of the spread

Source: thesis section 4.3.4 (the load profile over the distance from the taxel's centre).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Place
from skin_models.parameter import quantity
from skin_models.spread.bending import Bending


@dataclass(frozen=True)
class Leaning(Bending):
    """A contact that is beside the place declared by as much as it is deep, times the lean."""

    cause: ClassVar[str] = "off_centre"
    form: ClassVar[str] = "lean"
    places: ClassVar = {"rig": Place.SPREAD}
    source: ClassVar[str] = "thesis 4.3.4"
    rank: ClassVar[int] = 0
    radial: ClassVar[bool] = False
    deep: ClassVar[bool] = True

    lean_x: float = quantity("1", 0.0, lower=-10.0, upper=10.0, typical=0.3, doc="way along x per depth")
    lean_y: float = quantity("1", 0.0, lower=-10.0, upper=10.0, typical=0.1, doc="and along y")

    def seen(self, offset, x, width):
        """p - lean x."""
        moved = np.multiply.outer([self.lean_x, self.lean_y], x)
        if np.ndim(x) and offset.ndim == 2:
            offset = offset[..., None]
        return offset - moved.reshape(2, *([1] * (offset.ndim - np.ndim(x) - 1)), *np.shape(x))

    def reach(self, r, x, width):
        """r + |lean| x."""
        return r + float(np.hypot(self.lean_x, self.lean_y)) * float(np.max(x))
