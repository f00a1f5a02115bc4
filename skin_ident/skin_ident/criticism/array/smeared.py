"""Frequency-dependent crosstalk: a taxel repeats its nearest neighbours through a filter, which no change of gains can imitate.

    smeared        y'[i] = y[i] + share z[i]                       they come late, as through a multiplexer that settles slowly
    capacitive     y'[i] = y[i] + share (n[i] - z[i])              only changes come through
    with           tau dz/dt + z = n,   n[i] the sum of y over the nearest taxels of i

Source: T. D'Alessio, Sensors and Actuators A 72 (1999) 71-76.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from skin_ident.criticism.array.bending import OverTaxels, Pairs
from skin_models.effect import Dynamic, Place
from skin_models.operators.lagging import lagged, lagged_step
from skin_models.parameter import SHAPE, quantity
from skin_models.signals import Motion, Sample
from skin_models.spread.footprint import Places

TAUS = (0.03, 0.1, 0.4)  # s, time constants that are offered to the search


@dataclass(frozen=True)
class Smeared(OverTaxels, Dynamic):
    """Crosstalk through a first-order lag. State: that of the lag of the neighbours' sum, None at rest."""

    cause: ClassVar[str] = "crosstalk"
    form: ClassVar[str] = "smeared"
    places: ClassVar = {"taxel": Place.TAXEL}
    source: ClassVar[str] = "D'Alessio 1999"
    at_once: ClassVar[float] = 0.0  # weight of the neighbours' sum n, and of its lagged value z below
    late: ClassVar[float] = 1.0

    taxels: Pairs = ()
    share: float = quantity("1", 0.0, lower=-1.0, upper=1.0, typical=0.05, doc="share of the neighbours' sum")
    tau: float = quantity("s", 0.05, lower=1e-3, upper=10.0, role=SHAPE, typical=0.05, scan=TAUS, doc="time constant of the filter")

    def initial(self, rng=None) -> None:
        """None: the neighbours' first readings are taken to have been there for ever."""
        return None

    def step(self, state, y, s: Sample, dt: float):
        """y + share (at_once n + late z), z the lagged n."""
        heard = self._heard(np.asarray(y, float))
        state, z = lagged_step(state, heard, self.tau, dt)
        return state, y + self.share * (self.at_once * heard + self.late * z)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same as a filter."""
        heard = self._heard(y)
        return y + self.share * (self.at_once * heard + self.late * lagged(heard, self.tau, s.dt))

    def _heard(self, y: np.ndarray) -> np.ndarray:
        return _next_to(self.taxels) @ y


@dataclass(frozen=True)
class Capacitive(Smeared):
    """Crosstalk of changes only: the difference between the neighbours' sum and its lagged value comes through. Same state."""

    form: ClassVar[str] = "capacitive"
    at_once: ClassVar[float] = 1.0
    late: ClassVar[float] = -1.0


@lru_cache
def _next_to(taxels: Pairs) -> Any:
    """Matrix (T, T), 1 where a taxel is among the nearest neighbours of another."""
    return (Places(np.array(taxels, float)).neighbours > 0.0).astype(float)
