"""Quantization: steps coarser than declared.

    y' = q round(y / q)        q = 0 is the identity; halves go to the even step

On a sensor the step is a force, on the rig a depth (a stepping drive: the tip itself moves in steps).

Source: B. Widrow and I. Kollár, Quantization Noise, Cambridge 2008; thesis 3.3.1 (NI 9201: 12 bit over ±10 V).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Memoryless, Place
from skin_models.parameter import quantity


def _rounded(y, step):
    return np.round(y / step) * step if step > 0.0 else y


@dataclass(frozen=True)
class SensorQuantization(Memoryless):
    """Readings in steps of force."""

    cause: ClassVar[str] = "quantization"
    places: ClassVar = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "Widrow and Kollár 2008"

    step_force: float = quantity("N", 0.0, lower=0.0, upper=1e3, typical=0.5, doc="step q")

    def apply(self, y, s):
        return self.put_back(y, _rounded(self.mine(y), self.step_force))


@dataclass(frozen=True)
class DepthQuantization(Memoryless):
    """Depth in steps."""

    cause: ClassVar[str] = "quantization"
    places: ClassVar = {"rig": Place.DEPTH}
    source: ClassVar[str] = "Widrow and Kollár 2008"

    step_depth: float = quantity("m", 0.0, lower=0.0, upper=1e-2, typical=50e-6, doc="step q")

    def apply(self, y, s):
        return _rounded(y, self.step_depth)
