"""How far noise reaches, so that heavy-tailed noise stays noise.

A fault is not merely far out: more samples are far out than the tail of any noise would have there. Of those beyond l, a tail that falls
with the power n leaves (l / L)^n beyond L. Where there are more, with a chance below `TAIL_CHANCE`, something other than noise is at work.

No noise falls more slowly than Student's t with `HEAVIEST_TAIL` degrees of freedom. The tails of the normal distribution, of Laplace's and
of Student's t all grow steeper outwards, so a tail falls beyond l at least as steeply as before it. Where the counts show that steepness
surely, it is used for n. Spikes themselves only make the counts less steep.
"""

from collections.abc import Callable

import numpy as np
from scipy.stats import binom, chi2

from skin_ident.estimators.scale import normal_scale

LEAST_LIMIT = 7.0  # robust standard deviations: no limit is lower
HEAVIEST_TAIL = 2.45  # degrees of freedom: noise with three, somewhat uneven
TAIL_CHANCE = 1e-6  # chance of so many far samples in such a tail
LEVELS = 2.0 ** (0.5 * np.arange(20))  # levels, in units of the lowest, at which exceedances are counted
BELOW = 2.0**1.5  # the lowest level is this factor below the limit: nearer to the noise width excursions run into each other
HALF = 2  # number of LEVELS from half of a level to the level, over which the tail's steepness is measured
DOUBT = 0.01  # chance of such counts if the tail were less steep


def reach(d: np.ndarray, smallest: float = 0.0) -> float:
    """`LEAST_LIMIT` robust standard deviations of d (N,). `smallest` is a lower bound of the standard deviation, for converters coarser
    than the noise.

    The standard deviation is the larger of those from the median and from the 80 % quantile of |d|: readings of a coarse converter stand
    still half of the time.
    """
    size = np.abs(d)
    return LEAST_LIMIT * max(normal_scale(size), float(np.percentile(size, 80.0)) / 1.2816, smallest, 1e-12)


def stands_apart(start: float, count: Callable[[float], int], step: float = 0.0, nearest: float = 0.0) -> float | None:
    """The lowest level, from `start` up, that is exceeded more often than any tail of noise allows; None where there is none.

    `count(level)` is how many exceed a level. Lower levels, from `nearest` up, are used for comparison. With converter steps, what exceeds
    a level was rounded to the next whole `step`, from half a step below it on.
    """
    levels = start / BELOW * LEVELS
    real = np.maximum(levels, (np.ceil(levels / step) - 0.5) * step) if step > 0.0 else levels
    beyond = np.array([count(level) for level in levels])
    steepness = _steepness(real, beyond)
    for i in np.flatnonzero((levels >= 0.999 * start) & (beyond > 0)):
        share = (real[:i] / levels[i]) ** steepness[:i]
        by_chance = binom.sf(beyond[i] - 1, beyond[:i], np.minimum(share, 1.0))
        if np.any(by_chance[levels[:i] >= 0.999 * nearest] < TAIL_CHANCE):
            return float(levels[i])
    return None


def _steepness(levels: np.ndarray, beyond: np.ndarray) -> np.ndarray:
    """The power with which a tail surely falls beyond each of `levels`, which `beyond` samples exceed."""
    few, many = chi2.ppf(DOUBT, 2.0 * np.maximum(beyond[:-HALF], 0.5)) / 2.0, chi2.isf(DOUBT, 2.0 * (beyond[HALF:] + 1.0)) / 2.0
    falls = np.log(few / many) / np.log(np.maximum(levels[HALF:] / levels[:-HALF], 1.01))
    return np.maximum(HEAVIEST_TAIL, np.concatenate([np.full(HALF, HEAVIEST_TAIL), falls]))


def smallest_step(y: np.ndarray) -> float:
    """The least distance between two values in y (N,), up to rounding errors; 0 for a constant."""
    gaps = np.diff(np.unique(y))
    gaps = gaps[gaps > 1e-7 * max(float(np.ptp(y)), 1e-12)]
    return float(np.percentile(gaps, 5.0)) if gaps.size else 0.0
