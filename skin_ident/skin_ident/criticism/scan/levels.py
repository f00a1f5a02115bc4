"""The levels of a converter in the readings of a scan, found from the readings alone.

The steps need not be quite equal, because readings are often rounded again after conversion: those of thesis Table 4-10 are 0.098 N apart,
except for about every eighth step, which is 0.118 N. So a spacing counts as found where many gaps between neighbouring levels are close to
it and hardly any gap is smaller. Readings without converter steps have gaps of all sizes.
"""

from dataclasses import dataclass

import numpy as np

FEWEST = 20  # readings that are needed
PILE = 0.2  # share of the gaps that must be one step
STRAY = 0.08  # share of the gaps that may be smaller than NEAR steps
WITHIN = (0.75, 1.35)  # in steps: a gap in this range counts as one step
NEAR = 0.6  # in steps: two levels closer than this cannot both be levels of the converter


@dataclass(frozen=True, eq=False)
class Levels:
    """`step` N between neighbouring levels, and the indices `off` of readings that are on no level."""

    step: float
    off: np.ndarray


def find_levels(y: np.ndarray) -> Levels | None:
    """The levels of readings (N,), or None where they show none."""
    y = np.asarray(y, float)
    levels, count = np.unique(np.round(y, 9), return_counts=True)
    if y.size < FEWEST or levels.size < 3 or levels.size > 0.8 * y.size:
        return None
    gaps = np.diff(levels)
    candidates = np.unique(np.round(gaps, 9))
    piles = [np.mean((gaps > WITHIN[0] * q) & (gaps < WITHIN[1] * q)) for q in candidates]
    strays = [np.mean(gaps < NEAR * q) for q in candidates]
    fit = [i for i, (pile, stray) in enumerate(zip(piles, strays, strict=True)) if pile >= PILE and stray <= STRAY]
    if not fit:
        return None
    q = candidates[max(fit, key=lambda i: piles[i])]
    step = float(np.median(gaps[(gaps > WITHIN[0] * q) & (gaps < WITHIN[1] * q)]))
    return Levels(step, _off(y, levels, count, step))


def _off(y: np.ndarray, levels: np.ndarray, count: np.ndarray, step: float) -> np.ndarray:
    """Indices of readings on no level. Their value is less than NEAR steps from another level, but more than rounding explains, and fewer
    readings have it than have the other level."""
    rounding = np.array([half_digit(v) for v in levels])
    apart = np.diff(levels)
    group = np.cumsum(np.r_[0, apart > 1.01 * (rounding[1:] + rounding[:-1])])  # levels that differ by rounding only share a group
    used = np.bincount(group, count)
    lonely = np.zeros(levels.size, bool)
    for i in np.flatnonzero((np.diff(group) > 0) & (apart < NEAR * step)):
        less = min((i, i + 1), key=lambda j: used[group[j]])
        lonely |= (group == group[less]) & (used[group[i]] != used[group[i + 1]])
    return np.flatnonzero(np.isin(np.round(y, 9), levels[lonely]))


def half_digit(v: float) -> float:
    """Half a unit of the third significant digit of a number."""
    if v == 0.0:
        return 0.0
    return 0.5 * 10.0 ** (np.floor(np.log10(abs(v))) - 2)
