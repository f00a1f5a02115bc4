"""Residuals prepared for drawing: thinned out, binned over another quantity, smoothed, and as a spectrum."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import oaconvolve, welch

from skin_ident.criticism.telling.outcome import Trace

BINS = 24  # of depth or speed
FEWEST = 12  # samples that a bin needs to be shown


@dataclass(frozen=True)
class Binned:
    """Median residual against another quantity: centres (B,), medians (B,), N; and the middle 80 % of the samples, low and high (B,)."""

    centre: np.ndarray
    median: np.ndarray
    low: np.ndarray
    high: np.ndarray


def thinned(x: np.ndarray, y: np.ndarray, buckets: int) -> tuple[np.ndarray, np.ndarray]:
    """At most 2 x `buckets` points of y(x): the smallest and the largest of every bucket, in their order, so that spikes survive."""
    keep = np.isfinite(x) & np.isfinite(y)
    x, y = x[keep], y[keep]
    if y.size <= 2 * buckets:
        return x, y
    width = -(-y.size // buckets)
    filled = np.append(y, np.full(-y.size % width, y[-1])).reshape(-1, width)
    first = width * np.arange(len(filled))
    picked = np.unique(np.minimum([first + filled.argmin(axis=1), first + filled.argmax(axis=1)], y.size - 1))
    return x[picked], y[picked]


def binned(quantity: np.ndarray, residual: np.ndarray, low: float, high: float, bins: int = BINS) -> Binned:
    """Residual (N,) in equal bins of `quantity` (N,) between `low` and `high`; NaN in bins with too few samples."""
    edges = np.linspace(low, high, bins + 1)
    which = np.digitize(quantity, edges[1:-1])
    rows = []
    for i in range(bins):
        inside = residual[(which == i) & np.isfinite(residual) & (quantity >= low) & (quantity <= high)]
        spread = np.percentile(inside, [50.0, 10.0, 90.0]) if inside.size >= FEWEST else np.full(3, np.nan)
        rows.append((0.5 * (edges[i] + edges[i + 1]), *spread))
    return Binned(*np.array(rows).T)


def span_of(quantity: np.ndarray) -> tuple[float, float] | None:
    """The range that holds all samples (N,) but 0.2 % at either end; None where the quantity is constant or has too few samples."""
    known = quantity[np.isfinite(quantity)] if quantity is not None else np.zeros(0)
    if known.size < 2 * FEWEST:
        return None
    low, high = np.percentile(known, [0.2, 99.8])
    return (float(low), float(high)) if high - low > 1e-9 else None


def smooth(t: np.ndarray, y: np.ndarray, hz: float | None) -> np.ndarray:
    """`y` (N,), at times `t` (N,) s, smoothed by a Hann window that halves the amplitude at about `hz`. `y` itself where `hz` is None, or
    the window is too short or too long for it."""
    dt = (t[-1] - t[0]) / max(t.size - 1, 1)
    width = round(1.0 / (hz * dt)) if hz else 0
    if width < 3 or y.size < 3 * width:
        return y
    window = np.hanning(width + 2)[1:-1]
    half = width // 2
    padded = np.pad(np.nan_to_num(y), (half, width - 1 - half), mode="edge")
    return oaconvolve(padded, window / window.sum(), mode="valid")


def spectrum(t: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Amplitude density of y: frequency (Hz) and N per root hertz, by Welch's method with windows of at most 20 s; zero frequency left out.

    Above 64 frequencies the density is averaged in even steps of log frequency.
    """
    dt = (t[-1] - t[0]) / (t.size - 1)
    length = int(min(t.size, max(20.0 / dt, 64)))
    f, p = welch(np.nan_to_num(y), fs=1.0 / dt, nperseg=length, detrend="constant")
    return _smoothed(f[1:], p[1:])


def _smoothed(f: np.ndarray, p: np.ndarray, steps: int = 90) -> tuple[np.ndarray, np.ndarray]:
    keep = f > 0
    f, p = f[keep], p[keep]
    if f.size <= 64:
        return f, np.sqrt(p)
    which = np.digitize(np.log(f), np.linspace(np.log(f[0]), np.log(f[-1]), steps + 1)[1:-1])
    count = np.bincount(which, minlength=steps)
    used = count > 0
    centre = np.exp(np.bincount(which, np.log(f), steps)[used] / count[used])
    return centre, np.sqrt(np.bincount(which, p, steps)[used] / count[used])


def residuals(trace: Trace, row: int) -> tuple[np.ndarray, np.ndarray]:
    """Measured minus simulated, before and after, (N,) each, N."""
    return trace.measured[row] - trace.baseline[row], trace.measured[row] - trace.extended[row]
