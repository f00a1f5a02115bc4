"""Quantization: steps coarser than declared.

    taxel, load cell    y' = q round(y / q)                            halves go to the even step
    rig                 tip depth = x - q / (2 pi) sin(2 pi x / q)     a stepping drive

q = 0 is the identity. The drive's staircase is cut to its first harmonic: the tip rests on multiples of q and moves at up to twice the
speed between them. A staircase with corners would have no speed, hence no damping force, and grow without bound as the sample period
shrinks. (An encoder that merely reads in steps is no part of the chain, which starts from what it reads.)

Source: B. Widrow and I. Kollár, Quantization Noise, Cambridge 2008; thesis 3.1 (NI 9201: 12 bit over ±10 V).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Memoryless, Place
from skin_models.parameter import quantity


@dataclass(frozen=True)
class SensorQuantization(Memoryless):
    """Readings in steps of force."""

    cause: ClassVar[str] = "quantization"
    places: ClassVar = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "Widrow and Kollár 2008"

    step_force: float = quantity("N", 0.0, lower=0.0, upper=1e3, typical=0.5, doc="step q")

    def apply(self, y, s):
        """q round(y / q); y for q = 0."""
        if self.step_force == 0.0:
            return y
        return self.put_back(y, np.round(self.mine(y) / self.step_force) * self.step_force)


@dataclass(frozen=True)
class DepthQuantization(Memoryless):
    """Depth in soft steps."""

    cause: ClassVar[str] = "quantization"
    places: ClassVar = {"rig": Place.DEPTH}
    source: ClassVar[str] = "Widrow and Kollár 2008"

    step_depth: float = quantity("m", 0.0, lower=0.0, upper=1e-2, typical=50e-6, doc="step q")

    def apply(self, y, s):
        """x - q / (2 pi) sin(2 pi x / q); x for q = 0."""
        if self.step_depth == 0.0:
            return y
        turn = self.step_depth / (2.0 * np.pi)
        return y - turn * np.sin(y / turn)
