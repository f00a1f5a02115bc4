"""Interference: a periodic disturbance of a sensor, often aliased mains.

    y' = y + S sin(2 pi f T) + C cos(2 pi f T)        T: time since the first sample

Source: mains pick-up; H. W. Ott, Electromagnetic Compatibility Engineering, Wiley 2009.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Place
from skin_models.operators.elapsed import Elapsed
from skin_models.parameter import SHAPE, quantity


@dataclass(frozen=True)
class Interference(Elapsed):
    """One sinusoid; as sine and cosine, so that it is linear in its size."""

    cause: ClassVar[str] = "interference"
    places: ClassVar = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "Ott 2009"
    linear: ClassVar[bool] = True

    sine: float = quantity("N", 0.0, lower=-1e3, upper=1e3, typical=0.15, doc="amplitude S")
    cosine: float = quantity("N", 0.0, lower=-1e3, upper=1e3, typical=0.15, doc="amplitude C")
    frequency: float = quantity(
        "Hz",
        50.0,
        lower=1e-3,
        upper=1e5,
        role=SHAPE,
        typical=7.3,
        scan=(50.0, 60.0, 100.0, 120.0),
        doc="frequency f; refine it on the residual",
    )

    def apply(self, y, elapsed):
        """y + S sin(2 pi f T) + C cos(2 pi f T)."""
        angle = 2.0 * np.pi * self.frequency * elapsed
        return y + self.sine * np.sin(angle) + self.cosine * np.cos(angle)
