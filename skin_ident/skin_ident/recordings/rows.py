"""Operations on big blocks of rows (R, N) that need little extra memory, for either memory order.

Bags are read sample by sample, so a block of taxels is the transpose of a contiguous (N, R) array. Going through it row by row would
fetch all of it R times.
"""

import numpy as np

PIECE = 1 << 15  # samples that are processed at once
FOLD = 32  # samples that are laid side by side in a wide row


def all_finite(rows: np.ndarray) -> bool:
    """Whether every value is finite."""
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.isfinite(rows.sum()) or np.isfinite(rows).all())


def finite(rows: np.ndarray) -> np.ndarray:
    """A mask (N,) of the samples at which all rows are finite."""
    return np.concatenate([np.isfinite(part).all(axis=0) for part in _pieces(rows)])


def extremes(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest value of every row, (R,) each; NaN where a row holds one."""
    if not rows.T.flags.c_contiguous or rows.shape[1] < FOLD:
        return rows.min(axis=1), rows.max(axis=1)
    count, whole = len(rows), rows.shape[1] // FOLD * FOLD
    folded, rest = rows.T[:whole].reshape(-1, FOLD * count), rows.T[whole:]  # wide rows keep the processor's vector units busy
    low = np.vstack([folded.min(axis=0).reshape(FOLD, count), rest]).min(axis=0)
    return low, np.vstack([folded.max(axis=0).reshape(FOLD, count), rest]).max(axis=0)


def interpolated(t: np.ndarray, known: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Rows at increasing instants `known`, interpolated linearly to the instants t, in the same unit. The result has the memory order of
    `rows`."""
    after = np.clip(np.searchsorted(known, t, side="right"), 1, known.size - 1)
    weight = (t - known[after - 1]) / (known[after] - known[after - 1])
    by_sample = rows.strides[0] < rows.strides[-1]
    out = np.empty((t.size, len(rows))).T if by_sample else np.empty((len(rows), t.size))
    for start in range(0, t.size, PIECE):
        part = slice(start, start + PIECE)
        low = rows[:, after[part] - 1]
        with np.errstate(invalid="ignore"):  # infinite readings become NaN, and are treated as such
            out[:, part] = low + (rows[:, after[part]] - low) * weight[part]
    return out


def _pieces(rows: np.ndarray):
    return (rows[:, start : start + PIECE] for start in range(0, max(1, rows.shape[1]), PIECE))
