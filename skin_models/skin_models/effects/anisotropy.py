"""Anisotropy: the spread is wider in one direction than across it, as over a woven or stretched skin.

    K'(p) = K(S p),        widths c exp(s / 2) along the angle and c exp(-s / 2) across it: the area stays, and so does the force

Source: the contact of anisotropic half spaces is elliptic: J. R. Willis, J. Mech. Phys. Solids 14 (1966) 163-176; here as a stretch.
"""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Place
from skin_models.parameter import SHAPE, quantity
from skin_models.spread.bending import Bending


@dataclass(frozen=True)
class Anisotropy(Bending):
    """A width that differs by direction."""

    cause: ClassVar[str] = "anisotropy"
    places: ClassVar = {"skin": Place.SPREAD}
    source: ClassVar[str] = "after Willis 1966"
    rank: ClassVar[int] = 1
    radial: ClassVar[bool] = False

    stretch: float = quantity("1", 0.0, lower=-2.3, upper=2.3, typical=0.4, doc="logarithm s of width along the angle over width across it")
    angle: float = quantity("rad", 0.0, lower=-math.pi, upper=math.pi, role=SHAPE, typical=0.0, doc="that direction, from x towards y")

    def seen(self, offset, x, width):
        c, s = math.cos(self.angle), math.sin(self.angle)
        along, across = c * offset[0] + s * offset[1], c * offset[1] - s * offset[0]
        along, across = along * math.exp(-0.5 * self.stretch), across * math.exp(0.5 * self.stretch)
        return np.array([c * along - s * across, s * along + c * across])

    def reach(self, r, x, width):
        return r * math.exp(0.5 * abs(self.stretch))
