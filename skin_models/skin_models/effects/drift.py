"""Drift: a sensor's zero or gain creeps with the time T since the first sample.

    zero, linear         y' = y + d T
    zero, logarithmic    y' = y + A log10(1 + T / tau)
    gain, linear         y' = y (1 + d T)
    gain, logarithmic    y' = y (1 + A log10(1 + T / tau))        what FlexiForce's "drift per logarithmic time" means under load

Source: Tekscan FlexiForce A201 data sheet (drift < 5 % per logarithmic time scale).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Place
from skin_models.operators.elapsed import Elapsed
from skin_models.parameter import SHAPE, quantity

SENSORS = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
ONSETS = (0.1, 1.0, 10.0, 100.0)  # s


@dataclass(frozen=True)
class LinearDrift(Elapsed):
    """A zero that creeps evenly."""

    cause: ClassVar[str] = "drift"
    places: ClassVar = SENSORS
    source: ClassVar[str] = "first-order drift of zero"
    linear: ClassVar[bool] = True

    rate: float = quantity("N/s", 0.0, lower=-10.0, upper=10.0, typical=0.01, doc="rate d")

    def apply(self, y, elapsed):
        """y + d T."""
        return y + self.rate * elapsed


@dataclass(frozen=True)
class LogDrift(Elapsed):
    """A zero that creeps with the logarithm of time."""

    cause: ClassVar[str] = "drift"
    form: ClassVar[str] = "log"
    places: ClassVar = SENSORS
    source: ClassVar[str] = "FlexiForce A201 data sheet"
    linear: ClassVar[bool] = True

    per_decade: float = quantity("N", 0.0, lower=-100.0, upper=100.0, typical=0.2, doc="change A per decade of time")
    tau: float = quantity(
        "s", 1.0, lower=1e-3, upper=1e5, role=SHAPE, typical=1.0, scan=ONSETS, doc="time tau at which the logarithm sets in"
    )

    def apply(self, y, elapsed):
        """y + A log10(1 + T / tau)."""
        return y + self.per_decade * np.log10(1.0 + elapsed / self.tau)


@dataclass(frozen=True)
class LinearGainDrift(Elapsed):
    """A gain that creeps evenly."""

    cause: ClassVar[str] = "drift"
    form: ClassVar[str] = "gain"
    places: ClassVar = SENSORS
    source: ClassVar[str] = "first-order drift of span"
    linear: ClassVar[bool] = True

    rate: float = quantity("1/s", 0.0, lower=-1.0, upper=1.0, typical=2e-3, doc="relative rate d")

    def apply(self, y, elapsed):
        """y (1 + d T)."""
        return y * (1.0 + self.rate * elapsed)


@dataclass(frozen=True)
class LogGainDrift(Elapsed):
    """A gain that creeps with the logarithm of time."""

    cause: ClassVar[str] = "drift"
    form: ClassVar[str] = "gain_log"
    places: ClassVar = SENSORS
    source: ClassVar[str] = "FlexiForce A201 data sheet"
    linear: ClassVar[bool] = True

    per_decade: float = quantity("1", 0.0, lower=-1.0, upper=1.0, typical=0.04, doc="relative change A per decade of time")
    tau: float = quantity(
        "s", 1.0, lower=1e-3, upper=1e5, role=SHAPE, typical=1.0, scan=ONSETS, doc="time tau at which the logarithm sets in"
    )

    def apply(self, y, elapsed):
        """y (1 + A log10(1 + T / tau))."""
        return y * (1.0 + self.per_decade * np.log10(1.0 + elapsed / self.tau))
