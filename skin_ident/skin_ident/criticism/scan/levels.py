"""The levels of a converter in the readings of a scan, found without being told.

The steps need not be quite equal: readings are often rounded again after conversion (those of thesis Table 4-10 are 0.098 N apart, but
for every eighth step or so, which is 0.118 N). So a spacing counts as found where the gaps between neighbouring levels pile up at it and
hardly any is smaller; readings without a converter have gaps of all sizes.
"""

from dataclasses import dataclass

import numpy as np

FEWEST = 20  # readings
PILE = 0.2  # share of the gaps that must be one step
STRAY = 0.08  # share of the gaps that may be smaller than a step
WITHIN = (0.75, 1.35)  # a gap of one step, in steps
NEAR = 0.6  # of a step: closer than this is no level of its own


@dataclass(frozen=True, eq=False)
class Levels:
    """`step` N between neighbouring levels, and the readings that sit on no level (indices into what was given)."""

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
    """Readings whose level is used less than a neighbour, closer to it than steps are but farther than rounding."""
    rounding = np.array([half_digit(v) for v in levels])
    apart = np.diff(levels)
    group = np.cumsum(np.r_[0, apart > 1.01 * (rounding[1:] + rounding[:-1])])  # levels that only rounding tells apart
    used = np.bincount(group, count)
    lonely = np.zeros(levels.size, bool)
    for i in np.flatnonzero((np.diff(group) > 0) & (apart < NEAR * step)):
        less = min((i, i + 1), key=lambda j: used[group[j]])
        lonely |= (group == group[less]) & (used[group[i]] != used[group[i + 1]])
    return np.flatnonzero(np.isin(np.round(y, 9), levels[lonely]))


def half_digit(v: float) -> float:
    """Half a unit of the last of three significant digits (or of the digits that the number has)."""
    if v == 0.0:
        return 0.0
    return 0.5 * 10.0 ** (np.floor(np.log10(abs(v))) - 2)
