"""Saturation: a sensor clips.

    hard     y' = min(max(y, -L), L)
    leaky    y' = y - c max(y - L, 0)        beyond L it follows with the slope 1 - c
    soft     y' = y - c (r(y) - r(0)),  r(y) = w log(1 + exp((y - L) / w))        the same with a knee as wide as w, as amplifiers have

The hard form has no amplitude: its size is how low L is, and it is the identity for L = inf, which is what `absent` gives. A model cannot
be linearised in it: identification proposes the leaky form, and the hard one where samples pile up at one reading.

Source: H. K. Khalil, Nonlinear Systems, 3rd ed., Prentice Hall 2002, section 1.2.7 (common nonlinearities).
"""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Memoryless, Place
from skin_models.parameter import SHAPE, quantity

LEVELS = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 13.0, 17.0, 22.0)  # N


@dataclass(frozen=True)
class Saturation(Memoryless):
    """Readings beyond a level stay at it."""

    cause: ClassVar[str] = "saturation"
    places: ClassVar = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "Khalil 2002, section 1.2.7"
    proposed: ClassVar[bool] = False  # see above

    level: float = quantity("N", math.inf, lower=1e-6, typical=8.0, doc="greatest reading L; infinite removes the effect")

    def absent(self) -> "Saturation":
        """No clipping: an infinite level."""
        return self.with_values(level=math.inf)

    def apply(self, y, s):
        """min(max(y, -L), L)."""
        return self.put_back(y, np.clip(self.mine(y), -self.level, self.level))


@dataclass(frozen=True)
class LeakySaturation(Memoryless):
    """Readings beyond a level follow with less slope."""

    cause: ClassVar[str] = "saturation"
    form: ClassVar[str] = "leaky"
    places: ClassVar = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "Khalil 2002, section 1.2.7"

    lost: float = quantity("1", 0.0, lower=0.0, upper=1.0, typical=0.5, doc="share c of the slope that is lost")
    level: float = quantity("N", 8.0, lower=1e-6, role=SHAPE, typical=8.0, scan=LEVELS, doc="reading L from which it is lost")

    def apply(self, y, s):
        """y - c max(y - L, 0)."""
        mine = self.mine(y)
        return self.put_back(y, mine - self.lost * np.maximum(mine - self.level, 0.0))


@dataclass(frozen=True)
class SoftSaturation(LeakySaturation):
    """Readings follow with less and less slope about a level."""

    form: ClassVar[str] = "soft"
    refines: ClassVar = LeakySaturation
    proposed: ClassVar[bool] = False  # it is tried as a finer form

    knee: float = quantity("N", 0.5, lower=1e-3, upper=1e4, role=SHAPE, typical=0.5, doc="width w of the knee")

    def apply(self, y, s):
        """y - c (r(y) - r(0))."""
        mine = self.mine(y)
        ramp, at_zero = (self.knee * np.logaddexp(0.0, (force - self.level) / self.knee) for force in (mine, 0.0))
        return self.put_back(y, mine - self.lost * (ramp - at_zero))
