"""Drift: a sensor's zero or gain creeps with the time T since the first sample, or its reading with the time under load.

    zero, linear         y' = y + d T
    zero, logarithmic    y' = y + A log10(1 + T / tau)
    zero, warming up     y' = y + A (1 - exp(-T / tau))
    gain, linear         y' = y (1 + d T)
    gain, logarithmic    y' = y (1 + A log10(1 + T / tau))        what FlexiForce's "drift per logarithmic time" means under load
    creep                y' = y + c z,   tau z' + z = y           z(0) = y(0): goes on rising under a load, and comes back without

A reading that falls while the depth is held is relaxation of the skin; creep only rises. Several arms add up to any creep curve.

Sources: Tekscan FlexiForce A201 data sheet (drift < 5 % per logarithmic time scale); OIML R 60, Metrological regulation for load cells,
2017 (creep, and the return of the zero; warm-up time).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Dynamic, Place
from skin_models.operators.elapsed import Elapsed
from skin_models.operators.lagging import lagged, lagged_step
from skin_models.parameter import SHAPE, quantity
from skin_models.signals import Motion, Sample

SENSORS = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
ONSETS = (0.1, 1.0, 10.0, 100.0)  # s
WARM_AFTER = (3.0, 10.0, 30.0)  # s; what takes longer is linear or logarithmic in a recording
TIMES = 4.0  # length of the shortest recording that determines creep, in time constants


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
class WarmingUp(Elapsed):
    """A zero that goes to where it stays once the amplifier is warm."""

    cause: ClassVar[str] = "drift"
    form: ClassVar[str] = "warm_up"
    places: ClassVar = SENSORS
    source: ClassVar[str] = "OIML R 60"
    linear: ClassVar[bool] = True

    change: float = quantity("N", 0.0, lower=-100.0, upper=100.0, typical=0.2, doc="change A in all")
    tau: float = quantity("s", 10.0, lower=2.0, upper=1e3, role=SHAPE, typical=10.0, scan=WARM_AFTER, doc="time constant tau")

    def apply(self, y, elapsed):
        """y + A (1 - exp(-T / tau))."""
        return y - self.change * np.expm1(-elapsed / self.tau)


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


@dataclass(frozen=True)
class Creep(Dynamic):
    """A reading that rises under load. State: z and y of the sample before, N; None before the first."""

    cause: ClassVar[str] = "drift"
    form: ClassVar[str] = "creep"
    places: ClassVar = SENSORS
    source: ClassVar[str] = "OIML R 60, creep"
    linear: ClassVar[bool] = True

    creep: float = quantity("1", 0.0, lower=0.0, upper=1.0, typical=0.03, doc="final creep c, share of the load")
    tau: float = quantity("s", 10.0, lower=3.0, upper=1e4, role=SHAPE, typical=10.0, scan=(3.0, 10.0, 30.0, 100.0), doc="time constant tau")

    @classmethod
    def shapes(cls, s: Motion) -> Iterator[dict[str, float]]:
        """Time constants that the recording is `TIMES` times as long as: of slower creep it shows a beginning that any slow cause has."""
        return (shape for shape in super().shapes(s) if shape["tau"] <= (s.t[-1] - s.t[0]) / TIMES)

    def initial(self, rng=None) -> None:
        """None: the first sample is taken to have lasted for ever."""
        return None

    def step(self, state, y, s: Sample, dt: float):
        """y + c z, z after one more sample."""
        mine = self.mine(y)
        state, z = lagged_step(state, mine, self.tau, dt)
        return state, self.put_back(y, mine + self.creep * z)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same over the whole recording."""
        mine = self.mine(y)
        return self.put_back(y, mine + self.creep * lagged(mine, self.tau, s.dt))
