"""Nonlinearity of a sensor: its calibration curve bends between zero and its capacity R.

    y' = y + 4 d R u (1 - |u|),        u = y / R        the deviation is d R at half the capacity, and nothing at zero and at R

It is part of what a data sheet states, and too alike `nonlinear_stiffness` and `gain_error` to be proposed for a finding by itself.

Source: "nonlinearity" in the data sheets of the FlexiForce A201 and the MLP-25 (thesis 3.3.1 and 3.3.3), as the plainest curve through
both ends.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Memoryless, Place
from skin_models.parameter import SHAPE, quantity


@dataclass(frozen=True)
class Nonlinearity(Memoryless):
    """A bent calibration curve."""

    cause: ClassVar[str] = "nonlinearity"
    places: ClassVar = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "thesis 3.3.1 and 3.3.3"
    linear: ClassVar[bool] = True
    proposed: ClassVar[bool] = False

    deviation: float = quantity("1", 0.0, lower=-0.2, upper=0.2, typical=0.03, doc="deviation d at half capacity, relative to the capacity")
    capacity: float = quantity("N", 111.2, lower=1e-3, upper=1e5, role=SHAPE, typical=20.0, doc="capacity R")

    def apply(self, y, s):
        """y + 4 d y (1 - |y| / R)."""
        mine = self.mine(y)
        return self.put_back(y, mine + 4.0 * self.deviation * mine * (1.0 - np.abs(mine) / self.capacity))
