"""One low-pass for measured force and every regressor, at full rate, before decimating.

Filtering both sides of a linear equation with the same filter leaves its parameters untouched, takes out the noise above the motion, and
lets the encoder's steps do no harm: filter one side only and a false delay appears.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import firwin, oaconvolve, welch

HEADROOM = 3.0  # cut-off over the highest frequency of the motion
FLOOR = 6.0  # times the encoder's noise: what stands out by less is noise
WIDER = 2.5  # the depth itself, from which speed and contact are taken, keeps this many times the band


@dataclass(frozen=True)
class Prefilter:
    """A centred (zero-phase) FIR low-pass with cut-off `edge` (Hz), for samples `dt` (s) apart, then one sample in `every`."""

    dt: float
    edge: float

    @property
    def every(self) -> int:
        """Decimation: three times the cut-off is left as the rate."""
        return max(1, int(1.0 / (3.0 * self.edge * self.dt)))

    @property
    def half(self) -> int:
        """Samples that each end loses."""
        return _half(self.edge, self.dt)

    def rows(self, y: np.ndarray) -> np.ndarray:
        """Low-pass the rows of y (..., N), drop the ends, decimate. Measured channels go through `smooth` first, as the depth does."""
        kernel = _kernel(self.edge, self.dt).reshape((1,) * (y.ndim - 1) + (-1,))
        return oaconvolve(y, kernel, mode="valid", axes=-1)[..., :: self.every]

    def smooth(self, y: np.ndarray) -> np.ndarray:
        """Rows (..., N) low-passed well above the band, their ends mirrored, their length kept."""
        edge = WIDER * self.edge
        if edge * self.dt >= 0.4:
            return y
        half = _half(edge, self.dt)
        padded = np.pad(y, [(0, 0)] * (y.ndim - 1) + [(half, half)], mode="reflect", reflect_type="odd")
        return oaconvolve(padded, _kernel(edge, self.dt).reshape((1,) * (y.ndim - 1) + (-1,)), mode="valid", axes=-1)


def prefilter_for(depths: Sequence[tuple[np.ndarray, float]]) -> Prefilter:
    """A common low-pass for sessions (depth (N,) m, dt s) of one sampling rate: `HEADROOM` times the fastest motion, at most 0.2 / dt."""
    dt = depths[0][1]
    shortest = min(x.size for x, _ in depths)
    slowest = 1.5 / (0.1 * shortest * dt)  # the kernel may take a tenth of a session at each end
    fastest = max(_highest_frequency(x, dt) for x, _ in depths)
    return Prefilter(dt, min(max(HEADROOM * fastest, slowest), 0.2 / dt))


def _highest_frequency(x: np.ndarray, dt: float) -> float:
    """Hz below which lies 99.9 % of the speed's power, once the floor of the encoder's noise is taken off."""
    f, power = welch(np.diff(x) / dt, 1.0 / dt, nperseg=min(max(16, x.size // 8), 1024), detrend="constant")
    response = np.maximum(2.0 * np.sin(np.pi * f * dt) / dt, 1e-9) ** 2  # of the difference: white noise in x comes out with this shape
    floor = np.median((power / response)[f > 0.3 / dt])
    clean = np.where(power > FLOOR * floor * response, power, 0.0)
    if clean.sum() <= 0.0:
        return 0.2 / dt
    return float(f[np.searchsorted(np.cumsum(clean), 0.999 * clean.sum())])


def _half(edge: float, dt: float) -> int:
    return int(np.ceil(1.5 / (edge * dt)))


def _kernel(edge: float, dt: float) -> np.ndarray:
    return firwin(2 * _half(edge, dt) + 1, edge, fs=1.0 / dt, window=("kaiser", 5.0))
