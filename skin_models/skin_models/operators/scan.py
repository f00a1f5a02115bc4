"""Running composition of simple maps, in log2(N) passes over the array instead of a loop over the samples.

Where a state follows w[n] = f_n(w[n-1]) and the maps f_n belong to a family that is closed under composition, all f_n ∘ … ∘ f_1 come
from doubling: after pass j each entry holds the composition of its last 2^j maps. The clamps (play and stop) and the affine maps
(first-order recurrences with varying coefficients) are two such families, fractions of linear maps a third.

Source: W. D. Hillis and G. L. Steele, Data parallel algorithms, Communications of the ACM 29 (1986) 1170-1183.
"""

import numpy as np


def running_clamp(low: np.ndarray, high: np.ndarray, start: np.ndarray | float) -> np.ndarray:
    """w[n] = min(high[n], max(low[n], w[n-1])) with w[-1] = start, along the last axis; needs low <= high. Exact."""
    low, high = np.array(low, float), np.array(high, float)
    span = 1
    while span < low.shape[-1] and np.any(low[..., span:] < high[..., span:]):
        early_low, early_high = low[..., :-span], high[..., :-span]
        late_low, late_high = low[..., span:], high[..., span:]
        composed_low = np.minimum(late_high, np.maximum(late_low, early_low))
        high[..., span:] = np.minimum(late_high, np.maximum(late_low, early_high))
        low[..., span:] = composed_low
        span *= 2
    return np.minimum(high, np.maximum(low, np.asarray(start)[..., None]))


def running_affine(gain: np.ndarray, offset: np.ndarray, start: np.ndarray | float = 0.0) -> np.ndarray:
    """w[n] = gain[n] w[n-1] + offset[n] with w[-1] = start, along the last axis. Stable for |gain| <= 1."""
    gain, offset = np.array(gain, float), np.array(offset, float)
    span = 1
    while span < gain.shape[-1]:
        offset[..., span:] += gain[..., span:] * offset[..., :-span]
        gain[..., span:] *= gain[..., :-span].copy()
        span *= 2
    return offset + gain * np.asarray(start)[..., None]


def running_fraction(gain: np.ndarray, shift: np.ndarray, start: float = 0.0) -> np.ndarray:
    """w[n] = gain[n] (w[n-1] + shift[n]) / (1 + shift[n] w[n-1]) with w[-1] = start, for arrays (N,); |gain| <= 1, |shift| < 1.

    Each map is (a w + b) / (c w + 1). These are costly to compose, so the record is cut into blocks instead of doubling spans: all blocks
    compose their maps side by side, then the value runs from block to block.
    """
    length = max(int(0.5 * np.sqrt(gain.size)), 1)
    spare = -gain.size % length
    gain, shift = np.append(gain, np.ones(spare)), np.append(shift, np.zeros(spare))
    a, c = (np.ascontiguousarray(v.reshape(-1, length).T) for v in (gain, shift))
    b = a * c
    for j in range(1, length):
        a2, b2, c2 = a[j].copy(), b[j].copy(), c[j].copy()
        d = c2 * b[j - 1] + 1.0
        a[j], b[j], c[j] = (a2 * a[j - 1] + b2 * c[j - 1]) / d, (a2 * b[j - 1] + b2) / d, (c2 * a[j - 1] + c[j - 1]) / d
    starts = []
    for a1, b1, c1 in zip(a[-1].tolist(), b[-1].tolist(), c[-1].tolist(), strict=True):
        starts.append(start)
        start = (a1 * start + b1) / (c1 * start + 1.0)
    return ((a * starts + b) / (c * starts + 1.0)).T.ravel()[: a.size - spare]
