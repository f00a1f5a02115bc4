"""Runs of one reading that noise does not make: the last value sent once more where samples were lost.

White noise whose differences from sample to sample have the standard deviation s gives one reading, in steps q, with a probability p of at
most q / (s sqrt(pi)); noise that wanders repeats its last one with less. So L equal readings in a row come by chance at most N p^(L - 1)
times in N samples. A converter whose steps are uneven does that, too, at its wide ones: there no other reading is found near that one, at
any time.
"""

import numpy as np

from skin_ident.criticism.telemetry.excursions import held
from skin_ident.estimators.scale import normal_scale

LEAST = 4  # samples
AROUND = 100  # samples to either side, by which noise is known
CHANCE = 1e-4  # runs that chance may bring
MOVED = 2.0  # steps, by which the load moves meanwhile: a plunger at rest, or about to turn, is quieter than one that moves


def unlikely_runs(y: np.ndarray, e: np.ndarray, step: float) -> np.ndarray:
    """Mask (N,) of runs of one reading of `y`, whose model leaves `e`, that go on while the load does and noise would not."""
    mask = np.zeros(y.size, bool)
    again = np.diff(y, prepend=np.nan) == 0.0
    for a, b in zip(*held(y, LEAST), strict=True):
        moved = abs((y[b - 1] - e[b - 1]) - (y[a] - e[a]))
        near = np.r_[max(a - AROUND, 0) : a, b : min(b + AROUND, y.size)]
        if near.size < AROUND or moved < MOVED * step or _wide(y, y[a], 0.5 * moved, b - a):
            continue
        spread = normal_scale(np.diff(e[near]))
        p = max(np.mean(again[near]), step / max(np.sqrt(np.pi) * spread, step))
        mask[a:b] = y.size * p ** (b - a - 1) < CHANCE
    return mask


def _wide(y: np.ndarray, reading: float, within: float, count: int) -> bool:
    """Whether a step is so wide that readings `within` newtons of this one are rarer than itself, `count` times aside."""
    close = np.abs(y - reading) < within
    same = int(np.count_nonzero(y[close] == reading))
    return np.count_nonzero(close) - same <= same - count
