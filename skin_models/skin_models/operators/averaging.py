"""Moving averages of an input that is linear between samples.

    z(t) = 1/W int_(t - W)^t y,        y(t) = y[0] before the first sample

Exact for any window W, also for one that is no whole number of samples.
"""

from functools import lru_cache
from typing import Any

import numpy as np
from scipy.signal import lfilter


def averaged(y: np.ndarray, window: float, dt: float) -> np.ndarray:
    """z (..., N) of y, over a window in seconds; y itself where the window is 0."""
    if window == 0.0:
        return y
    samples = window / dt
    above = y - y[..., :1]  # sums of what differs from the beginning lose no digits to a large level
    if samples < 1.0:  # a difference of sums would lose them
        return y[..., :1] + lfilter(_weights(samples), [1.0], above)
    area = np.zeros_like(above)
    np.cumsum(0.5 * (above[..., 1:] + above[..., :-1]), axis=-1, out=area[..., 1:])
    n = np.arange(y.shape[-1])
    began = np.maximum(n - samples, 0.0)
    whole = np.minimum(began.astype(int), max(y.shape[-1] - 2, 0))
    part = began - whole
    rise = above[..., np.minimum(whole + 1, y.shape[-1] - 1)] - above[..., whole]
    return y[..., :1] + (area - area[..., whole] - part * (above[..., whole] + 0.5 * part * rise)) / samples


def averaged_step(state: np.ndarray | None, y: Any, window: float, dt: float) -> tuple[np.ndarray, Any]:
    """One sample of the same: the state (the samples that the window touches, newest first; None before the first) after it, and z."""
    weights = _weights(window / dt)
    y = np.asarray(y, float)
    last = np.broadcast_to(y, (weights.size, *y.shape)) if state is None else state
    state = np.concatenate([y[None], last[:-1]])
    return state, np.tensordot(weights, state, 1)[()]


@lru_cache(maxsize=64)
def _weights(samples: float) -> np.ndarray:
    """What each sample counts for, newest first: trapezia, of which the last may be cut off."""
    if samples == 0.0:
        return np.ones(1)
    whole = int(samples)
    part = samples - whole
    weights = np.zeros(whole + 2)
    weights[:whole] += 0.5
    weights[1 : whole + 1] += 0.5
    weights[whole : whole + 2] += part * (1.0 - 0.5 * part), 0.5 * part**2
    return weights / samples
