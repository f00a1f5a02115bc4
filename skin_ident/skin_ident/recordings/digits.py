"""What tells one reading from another, digit for digit, after readings were interpolated between uneven stamps.

A block that was copied repeats exactly, and no longer does once each of its samples lies a little further between its neighbours. So the
digits of the reading nearest to each instant are kept beside what was interpolated: 32 bits of each, half of what the reading itself would
take.

Source: D. E. Knuth, The Art of Computer Programming 3, 1998, section 6.4 (multiplicative hashing).
"""

import numpy as np

MULTIPLIER = np.uint64(0x9E3779B97F4A7C15)  # 2^64 over the golden ratio
PIECE = 1 << 14  # samples that are looked at in one go, which bounds the memory
SAME_LATE = 0.5  # mean of the phases of what is late: below it, instants are late by all sorts of shares of a period


def digits_of(rows: np.ndarray) -> np.ndarray:
    """A number for every reading (…, N), the same for the same digits; few that differ share one."""
    bits = np.ascontiguousarray(rows + 0.0, float).view(np.uint64)  # -0 is 0
    return ((bits ^ (bits >> np.uint64(32))) * MULTIPLIER >> np.uint64(32)).astype(np.uint32)


def digits_at(t: np.ndarray, known: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Digits (R, N) of readings `rows` at increasing instants `known`, each beside the instants of t (N,) to which it is nearest; `rows`
    may be digits already."""
    at, out = nearest(t, known), np.empty((len(rows), t.size), np.uint32)
    for start in range(0, t.size, PIECE):
        part = rows[:, at[start : start + PIECE]]
        out[:, start : start + PIECE] = part if rows.dtype == np.uint32 else digits_of(part)
    return out


def nearest(t: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Which of increasing instants `known` is nearest to each of t (N,), both in the same unit, but for what all of them are late by, of a
    period: at half of one a trembling stamp would go to either neighbour."""
    period = float(np.median(np.diff(known)))
    phase = np.mean(np.exp(2j * np.pi * (t - known[_before(t, known)]) / period))
    if np.abs(phase) > SAME_LATE:
        t = t - period * np.angle(phase) / (2.0 * np.pi)
    before = _before(t, known)
    return before + (t - known[before] > known[before + 1] - t)


def _before(t: np.ndarray, known: np.ndarray) -> np.ndarray:
    """The last of `known` but one that is not after each of t, or the first."""
    return np.clip(np.searchsorted(known, t, side="right") - 1, 0, known.size - 2)
