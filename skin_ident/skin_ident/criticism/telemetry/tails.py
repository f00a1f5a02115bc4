"""How far noise reaches, so that heavy-tailed noise stays noise.

A fault is not merely far out: more samples are far out than the tail of any noise would leave there. Of those beyond l, a tail that falls
with the power n leaves (l / L)^n beyond L; where there are more, with a chance of `CHANCE`, something else than noise is at work.

Nothing falls more slowly than Student's t with `HEAVIEST` degrees of freedom. The tails of the normal distribution, of Laplace's and of
Student's t all grow steeper outwards, so that a tail falls beyond l at least as steeply as it does before: where the counts show that
surely, n is that. Spikes themselves make it flatter, never steeper.
"""

from collections.abc import Callable

import numpy as np
from scipy.stats import binom, chi2

from skin_ident.estimators.scale import normal_scale

LEAST = 7.0  # robust standard deviations: no limit is lower
HEAVIEST = 2.45  # degrees of freedom: noise of three, somewhat uneven
CHANCE = 1e-6  # of so many far ones, in a tail like that
LEVELS = 2.0 ** (0.5 * np.arange(20))
BELOW = 2.0**1.5  # the comparison starts so much below the limit: nearer to the noise's width excursions run into each other
HALF = 2  # LEVELS to half of a level: from there to the level the tail shows how steep it is
DOUBT = 0.01  # chance that its counts were as they are, were it not so steep


def reach(d: np.ndarray, smallest: float = 0.0) -> float:
    """`LEAST` robust standard deviations of d (N,). `smallest` is the least of these, for converters coarser than the noise.

    From the median and the upper fifth of |d|, whichever says more: readings of a coarse converter stand still half of the time.
    """
    size = np.abs(d)
    return LEAST * max(normal_scale(size), float(np.percentile(size, 80.0)) / 1.2816, smallest, 1e-12)


def stands_apart(start: float, count: Callable[[float], int], step: float = 0.0, nearest: float = 0.0) -> float | None:
    """The least level, from `start` up, beyond which there are more than any tail of noise would leave; None where there is none.

    `count(level)` says how many go beyond a level; lower levels, from `nearest` up, are asked for comparison. In steps of a converter what
    goes beyond a level was rounded up to the next whole `step`, from half a step below it.
    """
    levels = start / BELOW * LEVELS
    real = np.maximum(levels, (np.ceil(levels / step) - 0.5) * step) if step > 0.0 else levels
    beyond = np.array([count(level) for level in levels])
    steepness = _steepness(real, beyond)
    for i in np.flatnonzero((levels >= 0.999 * start) & (beyond > 0)):
        share = (real[:i] / levels[i]) ** steepness[:i]
        by_chance = binom.sf(beyond[i] - 1, beyond[:i], np.minimum(share, 1.0))
        if np.any(by_chance[levels[:i] >= 0.999 * nearest] < CHANCE):
            return float(levels[i])
    return None


def _steepness(levels: np.ndarray, beyond: np.ndarray) -> np.ndarray:
    """The power with which a tail surely falls beyond each of `levels`, of which so many are `beyond`."""
    few, many = chi2.ppf(DOUBT, 2.0 * np.maximum(beyond[:-HALF], 0.5)) / 2.0, chi2.isf(DOUBT, 2.0 * (beyond[HALF:] + 1.0)) / 2.0
    falls = np.log(few / many) / np.log(np.maximum(levels[HALF:] / levels[:-HALF], 1.01))
    return np.maximum(HEAVIEST, np.concatenate([np.full(HALF, HEAVIEST), falls]))


def smallest_step(y: np.ndarray) -> float:
    """The least distance between two values that occur in y (N,), rounding errors apart; 0 for a constant."""
    gaps = np.diff(np.unique(y))
    gaps = gaps[gaps > 1e-7 * max(float(np.ptp(y)), 1e-12)]
    return float(np.percentile(gaps, 5.0)) if gaps.size else 0.0
