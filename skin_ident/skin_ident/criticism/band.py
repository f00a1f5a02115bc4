"""One low-pass for everything: measured force, simulated force and every direction pass through the same filter, at full rate.

An encoder of a few micrometres makes its derivative noisy; filtering only one side of the comparison turns that into a false delay.
The filter is a linear-phase FIR, centred, so that it shifts nothing; the samples its edges touch are dropped.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.signal import firwin, oaconvolve, upfirdn

CUTOFF_HZ = 8.0  # above the thesis's motions and below what the encoder's steps disturb
WIDER = 2.5  # the depth itself, which effects look at, keeps this many times the band


@dataclass(frozen=True)
class Band:
    """The common low-pass for data sampled every `dt` seconds."""

    dt: float
    cutoff: float = CUTOFF_HZ

    @property
    def edge(self) -> float:
        """Cut-off in Hz, at most a fifth of the sampling rate."""
        return min(self.cutoff, 0.2 / self.dt)

    @property
    def every(self) -> int:
        """Keep one filtered sample in so many: three times the cut-off is left as the rate."""
        return max(1, int(1.0 / (self.dt * 3.0 * self.edge)))

    @cached_property
    def kernel(self) -> np.ndarray:
        """Taps of the low-pass; their number less one is a multiple of `every`, so that decimation starts on a whole window."""
        return _low_pass(self.edge, self.dt, self.every)

    def smooth_depth(self, x: np.ndarray) -> np.ndarray:
        """The depth as effects see it: low-passed far above the band, ends extended, same length."""
        edge = min(WIDER * self.edge, 0.4 / self.dt)
        kernel = _low_pass(edge, self.dt)
        half = kernel.size // 2
        return oaconvolve(np.pad(x, half, mode="reflect", reflect_type="odd"), kernel, mode="valid")

    def thin(self, y: np.ndarray) -> np.ndarray:
        """Low-pass the rows of `y` (..., N), drop the edges and decimate; only the samples that are kept are worked out."""
        edge = self.kernel.size - 1
        return upfirdn(self.kernel, y, down=self.every, axis=-1)[..., edge // self.every : (y.shape[-1] - 1) // self.every + 1]

    def times(self, t: np.ndarray) -> np.ndarray:
        """The instants of what `thin` returns."""
        half = self.kernel.size // 2
        return t[half : t.size - half : self.every]


def _low_pass(edge: float, dt: float, multiple: int = 1) -> np.ndarray:
    half = int(np.ceil(1.5 / (edge * dt * multiple))) * multiple
    return firwin(2 * half + 1, edge, fs=1.0 / dt, window=("kaiser", 5.0))
