"""Lag: a sensor follows its input as a first-order filter.

    tau z' + z = y,        y' = z,        z(0) = y(0)

The step is exact for an input that is linear between samples (first-order hold):

    z[n] = e z[n-1] + (g - e) y[n-1] + (1 - g) y[n],        e = exp(-dt / tau),  g = (1 - e) tau / dt.

tau = 0 is the identity.

Source: G. F. Franklin, J. D. Powell, M. L. Workman, Digital Control of Dynamic Systems, 3rd ed., Addison-Wesley 1998, section 6.3.2.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.signal import lfilter

from skin_models.effect import Dynamic, Place
from skin_models.operators.lagging import lag_factors
from skin_models.parameter import quantity
from skin_models.signals import Motion, Sample


@dataclass(frozen=True)
class Lag(Dynamic):
    """First-order sensor lag."""

    cause: ClassVar[str] = "lag"
    places: ClassVar = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "Franklin, Powell and Workman 1998, section 6.3.2"

    tau: float = quantity("s", 0.0, lower=0.0, upper=100.0, typical=0.05, doc="time constant")

    def initial(self, rng=None) -> None:
        """None: the first sample is taken as rest. From then on the state is z[n-1] and y[n-1], N."""
        return None

    def step(self, state, y, s: Sample, dt: float):
        """z[n] = e z[n-1] + (g - e) y[n-1] + (1 - g) y[n]."""
        mine = self.mine(y)
        z, last = (mine, mine) if state is None else state
        e, g = lag_factors(self.tau, dt)
        z = e * z + (g - e) * last + (1.0 - g) * mine
        return (z, mine), self.put_back(y, z)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same recursion as a filter, at rest at y[0]."""
        mine = self.mine(y)
        e, g = lag_factors(self.tau, s.dt)
        start = g * mine[..., :1]  # the filter's memory of an input that has always been y[0]
        z, _ = lfilter([1.0 - g, g - e], [1.0, -e], mine, zi=start)
        return self.put_back(y, z)
