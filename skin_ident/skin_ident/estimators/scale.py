"""The standard deviation of normal noise by the median of its size, which a few spikes do not move."""

import numpy as np

NORMAL = 1.4826  # standard deviation over median of |r|, normal distribution: 1 / Phi^-1(3 / 4)


def normal_scale(r: np.ndarray, axis: int | None = None) -> np.ndarray | float:
    """Standard deviation of residuals `r` around zero, as 1.4826 median |r| along `axis` (over all where it is None), in their unit.

    Source: F. R. Hampel, The influence curve and its role in robust estimation, J. Am. Stat. Assoc. 69 (1974).
    """
    scale = NORMAL * np.median(np.abs(r), axis=axis)
    return float(scale) if axis is None else scale
