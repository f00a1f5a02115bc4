"""Masks over samples: runs of True in them, and where readings change."""

from collections.abc import Callable, Iterable

import numpy as np


def runs(mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Begins and ends (exclusive) of the runs of True in a mask (N,)."""
    change = np.diff(np.concatenate([[0], mask.astype(np.int8), [0]]))
    return np.flatnonzero(change > 0), np.flatnonzero(change < 0)


def changed(readings: np.ndarray) -> np.ndarray:
    """Mask (N,) of the samples whose reading differs from the one before; the first is none of them."""
    return np.append(False, readings[1:] != readings[:-1])


def marked(n: int, stretches: Iterable[tuple[int, int]]) -> np.ndarray:
    """A mask (n,) that is True in stretches a..b (b exclusive)."""
    mask = np.zeros(n, bool)
    for a, b in stretches:
        mask[a:b] = True
    return mask


def without(mask: np.ndarray, dropped: Callable[[int, int], bool]) -> np.ndarray:
    """The mask (N,) without those of its runs a..b (b exclusive) for which `dropped(a, b)` is true."""
    out = mask.copy()
    for a, b in zip(*runs(mask), strict=True):
        if dropped(a, b):
            out[a:b] = False
    return out
