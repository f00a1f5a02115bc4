"""Outliers: single readings that are far off.

    y'[n] = y[n] + S g[n]        with probability 1 - exp(-rate dt) at every sample, else y[n];  g standard normal

Without a random generator it leaves the signal alone.

Source: P. J. Huber, Robust Statistics, Wiley 1981 (gross-error model).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Dynamic, Place
from skin_models.operators.draws import Stream, gaussian, new_key, uniform, whole
from skin_models.parameter import quantity
from skin_models.signals import Motion, Sample


@dataclass(frozen=True)
class Outliers(Dynamic):
    """Random spikes."""

    cause: ClassVar[str] = "outliers"
    places: ClassVar = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "Huber 1981"

    rate: float = quantity("1/s", 0.0, lower=0.0, upper=1e4, typical=0.3, doc="spikes per second")
    size: float = quantity("N", 0.0, lower=0.0, upper=1e4, typical=4.0, doc="standard deviation S of a spike")

    def initial(self, rng=None) -> tuple[Stream, Stream] | None:
        """Two random streams, for when and how large; None without a generator."""
        return None if rng is None else (Stream(new_key(rng)), Stream(new_key(rng)))

    def step(self, state, y, s: Sample, dt: float):
        """y + S g where the next chance is below 1 - exp(-rate dt)."""
        if state is None:
            return None, y
        mine = np.asarray(self.mine(y))
        when, chance = state[0].next(mine.shape, uniform)
        how, size = state[1].next(mine.shape, gaussian)
        return (when, how), self.put_back(y, mine + self._spikes(chance, size, dt))

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same numbers at once."""
        if rng is None:
            return y
        mine = self.mine(y)
        chance, size = whole(new_key(rng), mine.shape, uniform), whole(new_key(rng), mine.shape, gaussian)
        return self.put_back(y, mine + self._spikes(chance, size, s.dt))

    def _spikes(self, chance, size, dt: float):
        return self.size * size * (chance < -np.expm1(-self.rate * dt))
