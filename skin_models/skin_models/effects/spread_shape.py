"""Spread shape: the kernel is not a Gaussian.

    K'(r) = K(c (r / c)^(1 + e))        e > 0: a flat top and short tails; e < 0: a point and heavy tails

c is the distance at which K has fallen to 1 / e: nothing changes there, nor right under the contact. A Gaussian becomes
exp(-(r / c)^(2 + 2 e)).

Source: the generalised Gaussian; M. T. Subbotin, On the law of frequency of error, Mat. Sb. 31 (1923) 296-301. Flat tops are those of wide
plungers and taxels, heavy tails those of an elastic half space (K. L. Johnson, Contact Mechanics, 1985, ch. 3).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Place
from skin_models.parameter import quantity
from skin_models.spread.bending import Bending


@dataclass(frozen=True)
class SpreadShape(Bending):
    """A flat top, or heavy tails."""

    cause: ClassVar[str] = "spread_shape"
    places: ClassVar = {"skin": Place.SPREAD}
    source: ClassVar[str] = "Subbotin 1923"
    rank: ClassVar[int] = 3

    flatness: float = quantity("1", 0.0, lower=-0.75, upper=9.0, typical=0.5, doc="relative change e of the kernel's power")

    def seen(self, offset, x, width):
        """p (|p| / c)^e."""
        r = np.hypot(*offset) / width
        return offset * np.power(r, self.flatness, out=np.ones_like(r), where=r > 0.0)

    def reach(self, r, x, width):
        """c (r / c)^(1 / (1 + e))."""
        return width * float((r / width) ** (1.0 / (1.0 + self.flatness)))
