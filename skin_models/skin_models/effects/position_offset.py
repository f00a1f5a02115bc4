"""Position offset: the zero of the encoder is not the surface of the skin.

    constant    tip depth = x + offset                              positive: the skin is met before the encoder reads zero
    warming     tip depth = x + growth (1 - exp(-T / tau))          T since the first sample: the column grows as it warms up

The thesis's stage is true to 5 um and comes to rest 1 to 5 um from where it should (sections 3.1 and 5.1): half of that is
negligible.

Source: geometry; for the column's growth, J. Bryan, International status of thermal error research, CIRP Annals 39 (1990) 645-656.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Memoryless, Place
from skin_models.operators.elapsed import Elapsed
from skin_models.parameter import SHAPE, quantity

OFFSETS = (15e-6, -60e-6, -0.2e-3, -0.6e-3, 0.2e-3)  # m; also large: a search from a small one does not find a surface met much later


@dataclass(frozen=True)
class PositionOffset(Memoryless):
    """The plunger is deeper than the encoder says."""

    cause: ClassVar[str] = "position_offset"
    places: ClassVar = {"rig": Place.DEPTH}
    source: ClassVar[str] = "geometry"
    linear: ClassVar[bool] = True

    offset: float = quantity(
        "m", 0.0, lower=-0.02, upper=0.02, typical=0.15e-3, negligible=2.5e-6, scan=OFFSETS, doc="tip depth minus encoder depth"
    )

    def apply(self, y, s):
        """x + offset."""
        return y + self.offset


@dataclass(frozen=True)
class Warming(Elapsed):
    """The tip comes nearer to the skin, or goes away from it, while the rig warms up."""

    cause: ClassVar[str] = "position_offset"
    form: ClassVar[str] = "warming"
    places: ClassVar = {"rig": Place.DEPTH}
    source: ClassVar[str] = "Bryan 1990"
    linear: ClassVar[bool] = True

    growth: float = quantity("m", 0.0, lower=-0.02, upper=0.02, typical=20e-6, negligible=1e-6, doc="final change of the tip's depth")
    tau: float = quantity("s", 60.0, lower=5.0, upper=1e3, role=SHAPE, typical=60.0, scan=(20.0, 60.0, 200.0), doc="time constant tau")

    def apply(self, y, elapsed):
        """x + growth (1 - exp(-T / tau))."""
        return y - self.growth * np.expm1(-elapsed / self.tau)
