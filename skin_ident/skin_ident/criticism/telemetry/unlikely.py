"""Runs of one reading that noise does not make: the last value repeated where samples were lost.

White noise whose differences from sample to sample have the standard deviation s repeats a reading, in steps q, with a probability p of at
most q / (s sqrt(pi)). Wandering noise repeats its last one with less. So L equal readings in a row occur by chance at most N p^(L - 1)
times in N samples. A converter with uneven steps repeats readings, too, at its wide steps: there no other reading occurs near that one, at
any time.
"""

import numpy as np

from skin_ident.criticism.telemetry.excursions import held
from skin_ident.estimators.scale import normal_scale

LEAST = 4  # samples, the shortest run
AROUND = 100  # samples to either side: the quieter side gives the noise, and the nearer half must not rest either
CHANCE = 1e-4  # expected number of runs by chance
MOVED = 2.0  # steps by which the load must move meanwhile: a plunger at rest, or about to turn, is quieter than one that moves


def unlikely_runs(y: np.ndarray, e: np.ndarray, step: float, resting: np.ndarray) -> np.ndarray:
    """Mask (N,) of runs of one reading of `y`, with residual `e`, that last while the load moves and that noise would not make. Runs near a
    `resting` sample (N,) do not count."""
    mask = np.zeros(y.size, bool)
    again = np.diff(y, prepend=np.nan) == 0.0
    for a, b in zip(*held(y, LEAST), strict=True):
        moved = abs((y[b - 1] - e[b - 1]) - (y[a] - e[a]))
        if a < AROUND or y.size - b < AROUND or resting[a - AROUND // 2 : b + AROUND // 2].any() or moved < MOVED * step:
            continue
        sides = slice(a - AROUND, a), slice(b, b + AROUND)
        p = max(max(np.mean(again[side]), step / max(np.sqrt(np.pi) * _noise(y[side], e[side]), step)) for side in sides)
        mask[a:b] = y.size * p ** (b - a - 1) < CHANCE and not _wide(y, y[a], 0.5 * moved, b - a)
    return mask


def _noise(y: np.ndarray, e: np.ndarray) -> float:
    """Standard deviation of the noise in sample-to-sample differences of `y`: from the residual `e`, which contains depth noise as well, or
    from second differences, which contain little of a motion; the smaller one."""
    return min(normal_scale(np.diff(e)), normal_scale(np.diff(y, 2)) / np.sqrt(3.0))


def _wide(y: np.ndarray, reading: float, within: float, count: int) -> bool:
    """Whether the step of a `reading` is wide: apart from the run's `count` samples, it is read more often than all other readings `within`
    N."""
    close = y[np.abs(y - reading) < within]
    same = int(np.count_nonzero(close == reading))
    return close.size - same <= same - count
