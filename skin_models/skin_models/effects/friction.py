"""Friction of the rig's guide or of the load cell's mounting: the measured force steps with the sign of the speed.

    y' = y + (F + mu |y|) tanh(v / v_s)

Coulomb's law, smoothed over the speed v_s: below it the force falls off instead of holding. F acts in the air too; what the load itself
presses into the guide rubs in proportion to it (mu).

Source: B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30 (1994) 1083-1138.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Memoryless, Place
from skin_models.parameter import SHAPE, quantity


@dataclass(frozen=True)
class Friction(Memoryless):
    """Smoothed Coulomb friction, seen by the load cell."""

    cause: ClassVar[str] = "friction"
    places: ClassVar = {"rig": Place.LOAD_CELL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "Armstrong-Hélouvry et al. 1994"
    linear: ClassVar[bool] = True

    force: float = quantity("N", 0.0, lower=0.0, upper=1e3, typical=0.5, doc="sliding friction F")
    coefficient: float = quantity("1", 0.0, lower=0.0, upper=2.0, typical=0.03, doc="friction mu per load")
    speed: float = quantity(
        "m/s",
        2e-4,
        lower=1e-7,
        upper=1.0,
        role=SHAPE,
        typical=2e-4,
        scan=(5e-5, 2e-4, 1e-3),
        doc="speed v_s over which the sign is smoothed",
    )

    def apply(self, y, s):
        """y + (F + mu |y|) tanh(v / v_s)."""
        return y + (self.force + self.coefficient * np.abs(y)) * np.tanh(s.v / self.speed)
