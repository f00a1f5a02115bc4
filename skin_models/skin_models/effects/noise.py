"""Noise of a sensor: white, coloured, and growing with the load.

    y' = y + w g1 + z + p |y| g2,        z[n] = e z[n-1] + c sqrt(1 - e^2) g3,   e = exp(-dt / tau)

g1, g2, g3 are independent standard normal numbers; z is an Ornstein-Uhlenbeck process, sampled exactly and stationary from the first sample
on. White and coloured sizes are standard deviations at the recording's own rate. Without a random generator the signal is left alone.

Source: D. T. Gillespie, Exact numerical simulation of the Ornstein-Uhlenbeck process, Phys. Rev. E 54 (1996) 2084-2091.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.signal import lfilter

from skin_models.effect import Dynamic, Place
from skin_models.operators.draws import Stream, gaussian, new_key, whole
from skin_models.parameter import SHAPE, quantity
from skin_models.signals import Motion, Sample


@dataclass(frozen=True)
class Noise(Dynamic):
    """White, coloured and proportional noise."""

    cause: ClassVar[str] = "noise"
    places: ClassVar = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "Gillespie 1996"

    white: float = quantity("N", 0.0, lower=0.0, upper=1e3, typical=0.05, doc="standard deviation w of the white part")
    coloured: float = quantity("N", 0.0, lower=0.0, upper=1e3, typical=0.05, doc="standard deviation c of the coloured part")
    proportional: float = quantity("1", 0.0, lower=0.0, upper=1.0, typical=0.01, doc="standard deviation p relative to the load")
    tau: float = quantity(
        "s", 0.1, lower=1e-6, upper=1e4, role=SHAPE, typical=0.1, scan=(0.1,), doc="correlation time of the coloured part"
    )

    def initial(self, rng=None):
        """Three random streams and z, which is drawn with the first sample; None without a generator."""
        return None if rng is None else (tuple(Stream(new_key(rng)) for _ in range(3)), None)

    def step(self, state, y, s: Sample, dt: float):
        """y + w g1 + z + p |y| g2 with the next numbers of the streams."""
        if state is None:
            return None, y
        streams, z = state
        mine = np.asarray(self.mine(y))
        streams, g = zip(*(stream.next(mine.shape, gaussian) for stream in streams), strict=True)
        e = np.exp(-dt / self.tau)
        z = g[2] if z is None else e * z + np.sqrt(1.0 - e * e) * g[2]
        return (streams, z), self.put_back(y, self._noisy(mine, g[0], g[1], z))

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same numbers at once; z as a filter."""
        if rng is None:
            return y
        mine = self.mine(y)
        g = [whole(new_key(rng), mine.shape, gaussian) for _ in range(3)]
        e = np.exp(-s.dt / self.tau)
        scale = np.sqrt(1.0 - e * e)
        z, _ = lfilter([scale], [1.0, -e], g[2], zi=(1.0 - scale) * g[2][..., :1])
        return self.put_back(y, self._noisy(mine, g[0], g[1], z))

    def _noisy(self, y, white, proportional, coloured):
        return y + self.white * white + self.proportional * np.abs(y) * proportional + self.coloured * coloured
