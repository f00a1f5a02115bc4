"""Robust estimates of the standard deviation of noise, from the median of its magnitude, which a few spikes do not change."""

from math import comb

import numpy as np

ORDERS = (3, 5, 7)  # of differences, in which motion of a few hertz hardly shows
NORMAL = 1.4826  # standard deviation over median of |r|, normal distribution: 1 / Phi^-1(3 / 4)


def normal_scale(r: np.ndarray, axis: int | None = None) -> np.ndarray | float:
    """Standard deviation of residuals `r` around zero, as 1.4826 median |r| along `axis` (over all where it is None), in their unit.

    Source: F. R. Hampel, The influence curve and its role in robust estimation, J. Am. Stat. Assoc. 69 (1974).
    """
    scale = NORMAL * np.median(np.abs(r), axis=axis)
    return float(scale) if axis is None else scale


def rms(e: np.ndarray) -> float:
    """Root mean square of e, in its unit."""
    return float(np.sqrt(np.mean(np.asarray(e) ** 2)))


def white_scale(y: np.ndarray, order: int) -> float:
    """Standard deviation of the white noise in `y` (N,), in its unit, from differences of order m (`order`). They hold hardly anything of
    densely sampled motion, but sqrt(binomial(2 m, m)) times the noise (the root of the sum of squared binomials). 0 for N <= m."""
    return normal_scale(np.diff(y, order)) / np.sqrt(comb(2 * order, order)) if y.size > order else 0.0


def white_noise(y: np.ndarray) -> float:
    """Standard deviation of the white noise in `y` (N,), in its unit: the smallest of the estimates from differences of several orders."""
    return min((white_scale(y, m) for m in ORDERS if y.size > 2 * m), default=0.0)
