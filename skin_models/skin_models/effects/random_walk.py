"""Random walk: a sensor's zero wanders.

    b[n] = b[n-1] + W sqrt(dt) g[n],        y' = y + b,        b = 0 at the first sample

A form of `drift`. Without a random generator the signal is left alone.

Source: IEEE Std 952-1997, annex C (random walk as one term of the Allan variance).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Dynamic, Place
from skin_models.operators.draws import Stream, gaussian, new_key, whole
from skin_models.parameter import quantity
from skin_models.signals import Motion, Sample


@dataclass(frozen=True)
class RandomWalk(Dynamic):
    """A wandering zero."""

    cause: ClassVar[str] = "drift"
    form: ClassVar[str] = "random_walk"
    places: ClassVar = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "IEEE Std 952-1997, annex C"

    walk: float = quantity("N/s^0.5", 0.0, lower=0.0, upper=1e3, typical=0.05, doc="size W: standard deviation after 1 s")

    def initial(self, rng=None):
        """A random stream and b, which is 0 at the first sample; None without a generator."""
        return None if rng is None else (Stream(new_key(rng)), None)

    def step(self, state, y, s: Sample, dt: float):
        """b[n] = b[n-1] + W sqrt(dt) g[n]; y + b."""
        if state is None:
            return None, y
        stream, bias = state
        mine = np.asarray(self.mine(y))
        stream, g = stream.next(mine.shape, gaussian)
        bias = 0.0 * g if bias is None else bias + self.walk * np.sqrt(dt) * g
        return (stream, bias), self.put_back(y, mine + bias)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same numbers, summed up at once."""
        if rng is None:
            return y
        mine = self.mine(y)
        g = whole(new_key(rng), mine.shape, gaussian)
        g[..., 0] = 0.0
        return self.put_back(y, mine + self.walk * np.sqrt(s.dt) * np.cumsum(g, axis=-1))
