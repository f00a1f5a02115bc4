"""The relay: on from `high` upwards, off from `low` downwards, and in between as it last was (the hysteron of Preisach).

Source: I. D. Mayergoyz, Mathematical Models of Hysteresis, Springer 1991, ch. 1.
"""

import numpy as np


def relay(x: np.ndarray, low: float, high: float) -> np.ndarray:
    """The relay over a whole record of shape (N,), off at first: 0.0 or 1.0."""
    switching = (x >= high) | (x <= low)
    last = np.maximum.accumulate(np.where(switching, np.arange(x.size), -1))
    return np.where(last < 0, 0.0, x[last] >= high)


def relay_step(last: float, x: float, low: float, high: float) -> float:
    """One sample: the new state, given the last one (0.0 at first)."""
    return 1.0 if x >= high else 0.0 if x <= low else last
