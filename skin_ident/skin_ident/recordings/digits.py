"""What tells one reading from another, digit for digit, after readings were interpolated between uneven stamps.

A block that was copied repeats exactly, and no longer does once each of its samples lies a little further between its neighbours. So the
digits of the reading nearest to each instant are kept beside what was interpolated: 32 bits of each (D. E. Knuth, The Art of Computer
Programming 3, 1998, section 6.4: multiplicative hashing), half of what the reading itself would take.
"""

import numpy as np

MULTIPLIER = np.uint64(0x9E3779B97F4A7C15)  # 2^64 over the golden ratio


def digits_of(rows: np.ndarray) -> np.ndarray:
    """A number for every reading (…, N), the same for the same digits; two that differ share one once in four billion times."""
    bits = np.ascontiguousarray(rows + 0.0, float).view(np.uint64)  # -0 is 0
    return ((bits ^ (bits >> np.uint64(32))) * MULTIPLIER >> np.uint64(32)).astype(np.uint32)


def nearest(t: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Which of increasing instants `known` is nearest to each of t (N,); both in the same unit."""
    after = np.clip(np.searchsorted(known, t), 1, known.size - 1)
    return after - (t - known[after - 1] <= known[after] - t)
