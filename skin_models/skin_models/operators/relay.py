"""The relay: on from `high` upwards, off from `low` downwards, and in between as it last was (the hysteron of Preisach).

Source: I. D. Mayergoyz, Mathematical Models of Hysteresis, Springer 1991, ch. 1.
"""

import numpy as np


def relay(x: np.ndarray, low: float, high: float) -> np.ndarray:
    """The relay over a whole record of shape (N,), off at first: 0.0 or 1.0."""
    switching = (x >= high) | (x <= low)
    last = np.maximum.accumulate(np.where(switching, np.arange(x.size), -1))
    return np.where(last < 0, 0.0, x[last] >= high)


def relay_step(last, x, low: float, high: float):
    """One sample: the new state, given the last one (0.0 at first); of one relay or of an array of them."""
    return np.where(x >= high, 1.0, np.where(x <= low, 0.0, last))[()]
