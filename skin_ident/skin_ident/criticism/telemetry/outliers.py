"""Outliers: spikes that the noise's own distribution cannot produce, and samples frozen while the load goes on.

A Student t distribution is fitted to the residual's central part; a spike is a sample so far out that less than one in a hundred
recordings would hold it. Heavy-tailed noise therefore stays noise.
"""

import numpy as np
from scipy.ndimage import median_filter
from scipy.stats import t as student

from skin_ident.criticism.telemetry.symptom import Symptom, place_of, quantity

RARE = 1e-2  # expected number of such samples in a recording, below which a sample is a spike
FEWEST = 2  # spikes before they are called a finding
FROZEN_STEPS = 6.0  # a frozen run must miss a change of so many noise widths


def find_outliers(
    names: list[str], channels: tuple[str, ...], residuals: list[np.ndarray], raw: list[np.ndarray], jumps: list[np.ndarray], n_taxels: int
) -> list[Symptom]:
    """Spikes and frozen runs per channel. `residuals` and `raw` are (C, N) at full rate for each session; `jumps` (N,) marks samples
    where the force itself may jump."""
    found = []
    for c, channel in enumerate(channels):
        detail = [e[c] - median_filter(e[c], 9) for e in residuals]
        masks = [(spikes(d, ~j) | frozen(y[c], e[c], d)) & ~j for d, e, y, j in zip(detail, residuals, raw, jumps, strict=True)]
        count = int(sum(m.sum() for m in masks))
        if count >= FEWEST:
            total = sum(m.size for m in masks)
            bad = {(name, channel): m for name, m in zip(names, masks, strict=True) if m.any()}
            largest = max(float(np.max(np.abs(e[c][m]), initial=0.0)) for e, m in zip(residuals, masks, strict=True))
            why = f"{count} of {total} samples of {channel} lie where this noise cannot reach, up to {largest:.3g} N away"
            parameters = {"rate": quantity(count / total, "1"), "size": quantity(largest, "N")}
            found.append(Symptom("outliers", place_of(channel, n_taxels), (channel,), parameters, {"why": why, "count": count}, bad))
    return found


def spikes(detail: np.ndarray, among: np.ndarray) -> np.ndarray:
    """Mask of the samples that the noise, fitted to those `among` which it is alone, would hardly ever produce."""
    spread = np.percentile(np.abs(detail[among]), [50.0, 90.0, 97.5])
    if spread[0] <= 0.0:
        spread = np.maximum(spread, 1e-12 + np.std(detail) * np.array([0.6745, 1.645, 2.24]))
    freedom = _freedom(spread[2] / spread[0])
    scale = spread[0] / student.ppf(0.75, freedom)
    limit = scale * max(student.isf(0.5 * RARE / detail.size, freedom), 6.0)
    return np.abs(detail) > max(limit, 2.0 * spread[2])


def _freedom(ratio: float) -> float:
    """Degrees of freedom whose ratio of the 97.5 % to the 50 % quantile of |t| is `ratio`."""
    grid = np.array([1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0, 20.0, 100.0])
    ratios = student.ppf(0.9875, grid) / student.ppf(0.75, grid)
    return float(np.interp(-ratio, -ratios, grid))


def frozen(y: np.ndarray, e: np.ndarray, detail: np.ndarray) -> np.ndarray:
    """Mask of runs of one value while the residual (measured less simulated) runs away and comes back at once."""
    width = max(1.4826 * float(np.median(np.abs(detail))), _smallest_step(y))
    starts = np.flatnonzero(np.diff(y, prepend=np.nan) != 0.0)
    ends = np.append(starts[1:], y.size)
    mask = np.zeros(y.size, bool)
    for a, b in zip(starts, ends, strict=True):
        if b - a >= 5 and b < y.size and abs(y[b] - y[b - 1]) > FROZEN_STEPS * width and np.ptp(e[a:b]) > FROZEN_STEPS * width:
            mask[a:b] = True
    return mask


def _smallest_step(y: np.ndarray) -> float:
    gaps = np.diff(np.unique(y))
    return float(gaps.min()) if gaps.size else 0.0
