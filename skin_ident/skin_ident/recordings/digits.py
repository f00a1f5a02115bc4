"""Hashes ("digits") that tell whether two readings are exactly equal, kept for readings that were interpolated between uneven stamps.

A copied block repeats exactly, but no longer does after interpolation, which places every sample differently between its neighbours. So a
hash of the reading nearest to each instant is kept beside the interpolated value: 32 bits, half the size of the reading itself.

Source: D. E. Knuth, The Art of Computer Programming 3, 1998, section 6.4 (multiplicative hashing).
"""

import numpy as np

MULTIPLIER = np.uint64(0x9E3779B97F4A7C15)  # 2^64 over the golden ratio
PIECE = 1 << 14  # samples that are processed at once, which bounds the memory
SAME_LATE = 0.5  # length of the mean phase vector above which all instants have about the same delay within a period


def digits_of(rows: np.ndarray) -> np.ndarray:
    """A hash for every reading (…, N): equal for equal readings, and rarely equal for different ones."""
    bits = np.ascontiguousarray(rows + 0.0, float).view(np.uint64)  # -0 is 0
    return ((bits ^ (bits >> np.uint64(32))) * MULTIPLIER >> np.uint64(32)).astype(np.uint32)


def digits_at(t: np.ndarray, known: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Digits (R, N) of the reading nearest to each instant of t (N,). `rows` are readings, or their digits, at increasing instants
    `known`."""
    at, out = nearest(t, known), np.empty((len(rows), t.size), np.uint32)
    for start in range(0, t.size, PIECE):
        part = rows[:, at[start : start + PIECE]]
        out[:, start : start + PIECE] = part if rows.dtype == np.uint32 else digits_of(part)
    return out


def nearest(t: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Indices of the instants `known` (increasing) nearest to each of t (N,), both in the same unit.

    A delay that all instants share within a period is removed first: at half a period, jitter would decide between the two neighbours.
    """
    period = float(np.median(np.diff(known)))
    phase = np.mean(np.exp(2j * np.pi * (t - known[_before(t, known)]) / period))
    if np.abs(phase) > SAME_LATE:
        t = t - period * np.angle(phase) / (2.0 * np.pi)
    before = _before(t, known)
    return before + (t - known[before] > known[before + 1] - t)


def _before(t: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Index of the last of `known` that is not after each of t, limited to 0 … size - 2."""
    return np.clip(np.searchsorted(known, t, side="right") - 1, 0, known.size - 2)
