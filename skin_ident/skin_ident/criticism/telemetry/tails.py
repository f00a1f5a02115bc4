"""How far noise reaches, so that heavy-tailed noise stays noise.

A fault is not merely far out: more samples are far out than the tail of any noise would leave there. Of those beyond l, a tail no heavier
than that of Student's t with `HEAVIEST` degrees of freedom leaves (l / L)^HEAVIEST beyond L; where there are more, with a chance of
`CHANCE`, something else than noise is at work. Bursts and spikes do not disturb this, as a t distribution fitted to all samples would be.
"""

from collections.abc import Callable

import numpy as np
from scipy.stats import binom

LEAST = 7.0  # robust standard deviations: no limit is lower
HEAVIEST = 2.45  # degrees of freedom: noise of three, somewhat uneven
CHANCE = 1e-5  # of so many far ones, in a tail like that
LEVELS = 2.0 ** (0.5 * np.arange(20))
BELOW = 4.0  # the comparison starts so much below the limit


def reach(d: np.ndarray, smallest: float = 0.0) -> float:
    """`LEAST` robust standard deviations of d (N,). `smallest` is the least of these, for converters coarser than the noise.

    From the median and the upper fifth of |d|, whichever says more: readings of a coarse converter stand still half of the time.
    """
    size = np.abs(d)
    return LEAST * max(1.4826 * float(np.median(size)), float(np.percentile(size, 80.0)) / 1.2816, smallest, 1e-12)


def stands_apart(start: float, count: Callable[[float], int], step: float = 0.0) -> float | None:
    """The least level, from `start` up, beyond which there are more than any tail of noise would leave; None where there is none.

    `count(level)` says how many go beyond a level; lower levels are asked for comparison. In steps of a converter what goes beyond a level
    was rounded up to the next whole `step`, from half a step below it.
    """
    levels = start / BELOW * LEVELS
    real = np.maximum(levels, (np.ceil(levels / step) - 0.5) * step) if step > 0.0 else levels
    beyond = np.array([count(level) for level in levels])
    for i in np.flatnonzero((levels >= 0.999 * start) & (beyond > 0)):
        share = (real[:i] / levels[i]) ** HEAVIEST
        if np.any(binom.sf(beyond[i] - 1, beyond[:i], np.minimum(share, 1.0)) < CHANCE):
            return float(levels[i])
    return None


def smallest_step(y: np.ndarray) -> float:
    """The least distance between two values that occur, rounding errors apart; 0 for a constant."""
    gaps = np.diff(np.unique(y))
    gaps = gaps[gaps > 1e-7 * max(float(np.ptp(y)), 1e-12)]
    return float(np.percentile(gaps, 5.0)) if gaps.size else 0.0
