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

    def matrix(self):
        """S, symmetric, with eigenvalues exp(-s / 2) along the angle and exp(s / 2) across it."""
        c, s = math.cos(self.angle), math.sin(self.angle)
        turn = np.array([[c, s], [-s, c]])
        return turn.T @ np.diag([math.exp(-0.5 * self.stretch), math.exp(0.5 * self.stretch)]) @ turn

    def seen(self, offset, x, width):
        """S p."""
        return np.tensordot(self.matrix(), offset, axes=1)

    def reach(self, r, x, width):
        """The wider width: r exp(|s| / 2)."""
        return r * math.exp(0.5 * abs(self.stretch))
