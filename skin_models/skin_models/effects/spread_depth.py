"""Spread depth: the kernel grows wider as the contact goes deeper. Two forms:

    plain       w = 1 + g x
    settling    w = 1 + g h (1 - exp(-x / h))        most of it within a depth h, as a round tip grows into its footprint

    K'(p) = K(p / w) / w^2, w at least 0.1        what it gains in width it loses in height: the force stays

Source: the contact of a sphere widens with depth, as its square root (K. L. Johnson, Contact Mechanics, 1985, ch. 4); the thesis found no
such growth in silicone between 0.4 and 1 mm (Table 4-8).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Place
from skin_models.parameter import SHAPE, quantity
from skin_models.spread.bending import Bending


def settled(x, settling: float):
    """h (1 - exp(-x / h)), m, of depths x >= 0, m, and h = `settling`, m."""
    return -settling * np.expm1(-x / settling)


@dataclass(frozen=True)
class SpreadDepth(Bending):
    """A width that changes with depth."""

    cause: ClassVar[str] = "spread_depth"
    places: ClassVar = {"skin": Place.SPREAD}
    source: ClassVar[str] = "after Johnson 1985, ch. 4"
    rank: ClassVar[int] = 2
    deep: ClassVar[bool] = True

    growth: float = quantity("1/m", 0.0, lower=-1e3, upper=1e4, typical=100.0, doc="relative growth g of the width per metre of depth")

    def seen(self, offset, x, width):
        """p / w."""
        factor = self.scale(x)
        return offset / factor if np.ndim(x) == 0 or offset.ndim == 3 else offset[..., None] / factor

    def reach(self, r, x, width):
        """r w."""
        return r * float(self.scale(x))

    def scale(self, x):
        """w = 1 + g x, at least 0.1."""
        return np.maximum(1.0 + self.growth * x, 0.1)


@dataclass(frozen=True)
class SettlingSpreadDepth(SpreadDepth):
    """A width that changes with depth, and less the deeper it is."""

    form: ClassVar[str] = "settling"
    refines: ClassVar[type] = SpreadDepth

    settling: float = quantity("m", 0.3e-3, lower=1e-6, upper=0.05, role=SHAPE, typical=0.3e-3, doc="depth h within which most of it comes")

    def scale(self, x):
        """w = 1 + g h (1 - exp(-x / h)), at least 0.1."""
        return np.maximum(1.0 + self.growth * settled(x, self.settling), 0.1)
