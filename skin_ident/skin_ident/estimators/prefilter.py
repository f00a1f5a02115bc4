"""One low-pass for measured force and every regressor, at full rate, before decimation.

Filtering both sides of a linear equation with the same filter does not change its parameters. It removes noise above the band of the motion
and makes the encoder's steps harmless. Filtering one side only would cause a false delay.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import firwin, oaconvolve, welch

HEADROOM = 3.0  # ratio of the cut-off to the highest frequency of the motion
FLOOR = 6.0  # times the encoder's noise floor: a weaker spectral line counts as noise
WIDER = 2.5  # cut-off for the depth, from which speed and contact are computed, relative to `edge`
STILL = 0.02  # of the RMS motion of the session that moves farthest: one that moves less is held, and its encoder trembles
FEWEST_ROWS = 20  # rows that must be left of a stretch
AROUND = 8.0  # cut-off of the wide band, in which the noise is estimated, relative to `edge`


@dataclass(frozen=True)
class Prefilter:
    """Two centred (zero-phase) FIR low-passes in a row, for samples `dt` (s) apart.

    The first, `AROUND` times wider than the band, is followed by decimation; the noise is estimated from its output, the rows. The second
    has the cut-off `edge` (Hz); the parameters are estimated from its output.
    """

    dt: float
    edge: float

    @property
    def wide(self) -> float:
        """Cut-off of the first low-pass, Hz."""
        return min(AROUND * self.edge, 0.4 / self.dt)

    @property
    def every(self) -> int:
        """Decimation factor. The remaining rate is little more than twice the first cut-off, so that white noise stays nearly white."""
        return max(1, int(1.0 / (2.2 * self.wide * self.dt)))

    @property
    def kernel(self) -> np.ndarray:
        """The second low-pass, for rows that `rows` returns."""
        return low_pass(self.edge, self.dt * self.every, 1.5)

    def rows(self, y: np.ndarray) -> np.ndarray:
        """y (..., N) through the first low-pass, without the ends, decimated."""
        if self.wide * self.dt >= 0.4:
            return y
        return valid(y, low_pass(self.wide, self.dt, 4.0))[..., :: self.every]

    @property
    def fewest(self) -> int:
        """The rows that a stretch must have, so that enough are left when the second low-pass has removed its ends."""
        return self.kernel.size + FEWEST_ROWS

    def samples(self, rows: slice) -> slice:
        """The samples from which these rows are computed."""
        reach = 0 if self.wide * self.dt >= 0.4 else low_pass(self.wide, self.dt, 4.0).size - 1
        return slice(rows.start * self.every, (rows.stop - 1) * self.every + 1 + reach)

    def spread(self, gains: np.ndarray, size: int) -> np.ndarray:
        """The transpose of `rows`: turns gains (n, P) per row into gains (size, P) per sample."""
        if self.wide * self.dt >= 0.4:
            return gains
        kernel = low_pass(self.wide, self.dt, 4.0)
        apart = np.zeros((size - kernel.size + 1, gains.shape[1]))
        apart[:: self.every] = gains
        return oaconvolve(apart, kernel[:, None], mode="full", axes=0)

    def smooth(self, x: np.ndarray) -> np.ndarray:
        """The depth (N,) through a low-pass with a cut-off above the band, its ends mirrored. Its gain in the band is so close to 1 that
        other signals need not pass the same filter."""
        edge = WIDER * self.edge
        if edge * self.dt >= 0.4:
            return x
        kernel = low_pass(edge, self.dt, min(1.5, edge * self.dt * (x.size // 2 - 1)))
        padded = np.pad(x, kernel.size - 1, mode="reflect", reflect_type="odd")
        once = oaconvolve(padded, kernel, mode="valid")
        half = kernel.size // 2
        # what the filter removed is filtered again and added: a gain of G becomes 1 - (1 - G)^2, which is 1 in the band
        return once[half:-half] + oaconvolve(padded[half:-half] - once, kernel, mode="valid")


def prefilters_for(signals: Sequence[tuple[np.ndarray, float]]) -> list[Prefilter]:
    """One low-pass for each signal (x (N,), dt s). All have one cut-off: `HEADROOM` times the fastest motion in any of them, at most 0.2 of
    the lowest sampling rate."""
    slowest = max(1.5 / (0.1 * x.size * dt) for x, dt in signals)  # the kernel may take a tenth of a session at each end
    far = STILL * max(np.std(x) for x, _ in signals)
    moving = [(x, dt) for x, dt in signals if np.std(x) > far]  # a depth that is held has no band
    fastest = max((_highest_frequency(x, dt) for x, dt in moving), default=np.inf)
    edge = min(max(HEADROOM * fastest, slowest), *(0.2 / dt for _, dt in signals))
    periods = {f"{dt:.3g}": dt for _, dt in reversed(signals)}  # rates that differ by rounding are one
    return [Prefilter(periods[f"{dt:.3g}"], edge) for _, dt in signals]


def _highest_frequency(x: np.ndarray, dt: float) -> float:
    """The frequency (Hz) below which 99.9 % of the speed's power lies, without spectral lines at the encoder's noise floor."""
    f, power = welch(np.diff(x) / dt, 1.0 / dt, nperseg=min(max(16, x.size // 8), 1024), detrend="constant")
    response = np.maximum(2.0 * np.sin(np.pi * f * dt) / dt, 1e-9) ** 2  # of the difference: the spectrum that white noise in x gets
    floor = np.median((power / response)[f > 0.3 / dt])
    clean = np.where(power > FLOOR * floor * response, power, 0.0)
    return float(f[np.searchsorted(np.cumsum(clean), 0.999 * clean.sum())])


def valid(y: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    """y (..., N) through the kernel, without the ends; empty where y is shorter than the kernel, for scipy would exchange the two."""
    if y.shape[-1] < kernel.size:
        return y[..., :0]
    return oaconvolve(y, kernel.reshape((1,) * (y.ndim - 1) + (-1,)), mode="valid", axes=-1)


def low_pass(edge: float, dt: float, length: float) -> np.ndarray:
    """A symmetric FIR kernel with cut-off `edge` (Hz) that reaches `length` / edge to either side."""
    return firwin(2 * int(np.ceil(length / (edge * dt))) + 1, edge, fs=1.0 / dt, window=("kaiser", 5.0))
