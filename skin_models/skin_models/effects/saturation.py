"""Saturation: a sensor clips.

    y' = min(max(y, -L), L)

The size of this effect is not a force but how low L is: it is the identity for L = inf, which is what `absent` gives.

Source: G. Tao and P. V. Kokotović, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, Wiley 1996, ch. 2.
"""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Memoryless, Place
from skin_models.parameter import quantity


@dataclass(frozen=True)
class Saturation(Memoryless):
    """Readings beyond a level stay at it."""

    cause: ClassVar[str] = "saturation"
    places: ClassVar = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "Tao and Kokotović 1996, ch. 2"

    level: float = quantity("N", math.inf, lower=1e-6, typical=8.0, doc="greatest reading L; infinite removes the effect")

    def absent(self) -> "Saturation":
        """No clipping: an infinite level."""
        return self.with_values(level=math.inf)

    def apply(self, y, s):
        return self.put_back(y, np.clip(self.mine(y), -self.level, self.level))
