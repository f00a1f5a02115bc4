"""Crosstalk that comes late: a taxel repeats its neighbours as a first-order lag passes them on, which no change of gains can imitate.

    y'[i] = y[i] + share z[i],        tau dz/dt + z = y[i-1] + y[i+1]

Source: T. D'Alessio, Sensors and Actuators A 72 (1999) 71-76; the lag is that of a multiplexer which settles slowly.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.signal import lfilter

from skin_models.effect import Dynamic, Place
from skin_models.parameter import SHAPE, quantity
from skin_models.signals import Motion, Sample

TAUS = (0.03, 0.1, 0.4)  # s


@dataclass(frozen=True)
class Smeared(Dynamic):
    """State: the lagged sum of the neighbours, None at rest."""

    cause: ClassVar[str] = "crosstalk"
    form: ClassVar[str] = "smeared"
    places: ClassVar = {"taxel": Place.TAXEL}
    source: ClassVar[str] = "D'Alessio 1999"

    share: float = quantity("1", 0.0, lower=-1.0, upper=1.0, typical=0.05, doc="share of the neighbours' sum")
    tau: float = quantity("s", 0.05, lower=1e-3, upper=10.0, role=SHAPE, typical=0.05, scan=TAUS, doc="time constant of the smear")

    def initial(self, rng=None) -> None:
        """None: what is heard at the first sample has always been heard."""
        return None

    def step(self, state, y, s: Sample, dt: float):
        """y + share z, z[n] = e z[n-1] + (1 - e) neighbours, e = exp(-dt / tau)."""
        heard, e = neighbours(np.asarray(y, float)), float(np.exp(-dt / self.tau))
        z = heard if state is None else e * state + (1.0 - e) * heard
        return z, y + self.share * z

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same recursion as a filter."""
        heard, e = neighbours(y), float(np.exp(-s.dt / self.tau))
        z, _ = lfilter([1.0 - e], [1.0, -e], heard, zi=e * heard[..., :1])
        return y + self.share * z

    @classmethod
    def absent_shapes(cls) -> Iterator["Smeared"]:
        """The effect at size zero, at every time constant among which it is proposed."""
        for tau in TAUS:
            yield cls(where="taxel", share=0.0, tau=tau)


def neighbours(y: np.ndarray) -> np.ndarray:
    """The sum of every row's neighbours in the order of the rows, (T, N) or (T,)."""
    out = np.zeros_like(y)
    out[1:] += y[:-1]
    out[:-1] += y[1:]
    return out
