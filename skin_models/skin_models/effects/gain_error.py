"""Gain error: the slope of a calibration is off, from the start or from some moment on.

    constant       y' = (1 + g) y
    step           y' = (1 + g) y        from t0 after the first sample on

Source: thesis 3.3.1 (part-to-part variability of FlexiForce taxels as high as 40 %) and Table 3-1 (slopes from test to test).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Memoryless, Place
from skin_models.operators.elapsed import Elapsed
from skin_models.parameter import SHAPE, quantity
from skin_models.signals import Motion


@dataclass(frozen=True)
class GainError(Memoryless):
    """A wrong slope throughout."""

    cause: ClassVar[str] = "gain_error"
    places: ClassVar = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "thesis 3.3.1"
    linear: ClassVar[bool] = True

    gain: float = quantity("1", 0.0, lower=-0.95, upper=10.0, typical=0.15, doc="relative error g")

    def apply(self, y, s):
        """(1 + g) y."""
        return self.put_back(y, (1.0 + self.gain) * self.mine(y))


@dataclass(frozen=True)
class GainStep(Elapsed):
    """A slope that changes part-way."""

    cause: ClassVar[str] = "gain_error"
    form: ClassVar[str] = "step"
    places: ClassVar = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "thesis 3.3.1"
    linear: ClassVar[bool] = True

    gain: float = quantity("1", 0.0, lower=-0.95, upper=10.0, typical=0.15, doc="relative error g")
    after: float = quantity("s", 10.0, lower=0.0, role=SHAPE, typical=10.0, doc="time t0, counted from the first sample")

    def apply(self, y, elapsed):
        """y before t0, (1 + g) y from t0 on."""
        return y * (1.0 + self.gain * (elapsed >= self.after))

    @classmethod
    def shapes(cls, s: Motion) -> Iterator[dict[str, float]]:
        """Nineteen moments, evenly through the recording."""
        for share in np.linspace(0.0, 1.0, 21)[1:-1]:
            yield {"after": float(share * (s.t[-1] - s.t[0]))}
