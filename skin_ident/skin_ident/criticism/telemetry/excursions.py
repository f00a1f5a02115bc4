"""Excursions: a channel jumps away between two samples and jumps back soon after.

Skin pressed by a plunger of finite acceleration does not do that, whatever else is wrong with it. The jump must be in the measurement, not
in the model, which may place a contact wrongly. A single jump does not count: it may be a contact made or lost.
"""

import numpy as np
from scipy.ndimage import maximum_filter1d

from skin_ident.stretches import runs, without

LONGEST = 8  # samples of one excursion
BACK = 0.45  # share of the smaller jump within which it must come back
OWN_SHARE = 0.6  # share of a jump in the residual that must be in the measurement itself
SLOPE = 0.35  # share of a jump that the change just before or after it may have
STILL = 0.5  # share of a jump by which the model itself may move
AROUND = 3  # samples around it that are searched for such movement: the model may misplace a contact by so many
PUSHED, BESIDE = 0.35, 8  # share of an excursion, from which the model makes it, too; samples beside it: depth is smoothed, forces are not
CLUSTER = 12  # samples between excursions of one burst
MEMBERS = 3  # excursions that make a burst


def excursions(e: np.ndarray, y: np.ndarray, limit: float) -> np.ndarray:
    """Mask (N,) of excursions, by jumps larger than `limit`, in the residual `e` of the measurement `y`."""
    d = np.diff(e)
    far = np.abs(d) > limit
    if not far.any():
        return np.zeros(e.size, bool)
    dy = np.diff(y)
    sharp = far & (dy * np.sign(d) > OWN_SHARE * np.abs(d)) & _sudden(d)
    calm = maximum_filter1d(np.abs(dy - d), 2 * AROUND + 1) < STILL * np.abs(d)
    return _of_their_own(paired(e, d, np.flatnonzero(sharp & calm)), e, y - e)


def _sudden(d: np.ndarray) -> np.ndarray:
    """Mask (N-1,) of changes that are not part of a slope over two samples or more, which the push of a mass makes."""
    padded = np.pad(d, 1)
    return np.maximum(padded[:-2] * np.sign(d), padded[2:] * np.sign(d)) < SLOPE * np.abs(d)


def _of_their_own(mask: np.ndarray, e: np.ndarray, model: np.ndarray) -> np.ndarray:
    """The mask without excursions that the model makes as well, only lower: a plunger that suddenly moves on by a step pushes for one
    sample."""

    def of_the_model(a: int, b: int) -> bool:
        far = e[a] - e[a - 1]
        m = model[max(a - BESIDE, 0) : b + BESIDE] * np.sign(far)
        return max(_tallest(m), _tallest(m - np.linspace(m[0], m[-1], m.size))) > PUSHED * abs(far)

    return without(mask, of_the_model)


def _tallest(m: np.ndarray) -> float:
    """The greatest prominence of a peak in m: how far it rises above the lowest values on both sides of it. It need not be the highest
    sample: a plunger that halts for a moment on its way in leaves a dip in a rising force."""
    before, after = np.minimum.accumulate(m), np.minimum.accumulate(m[::-1])[::-1]
    return float(np.max(m - np.maximum(before, after)))


def paired(e: np.ndarray, d: np.ndarray, sharp: np.ndarray) -> np.ndarray:
    """Mask (N,) of the samples between a jump and the next one back to where it came from."""
    mask = np.zeros(e.size, bool)
    k = 0
    while k < sharp.size:
        i = sharp[k]
        later = sharp[k + 1 : k + 1 + LONGEST]
        back = [j for j in later if j - i <= LONGEST and d[i] * d[j] < 0.0 and abs(e[j + 1] - e[i]) <= BACK * min(abs(d[i]), abs(d[j]))]
        if back:
            mask[i + 1 : back[0] + 1] = True
            k = int(np.searchsorted(sharp, back[0])) + 1
        else:
            k += 1
    return mask


def fill_clusters(mask: np.ndarray) -> np.ndarray:
    """The mask (N,) with the gaps inside bursts filled."""
    starts, ends = runs(mask)
    if starts.size < MEMBERS:
        return mask
    filled = mask.copy()
    group = np.concatenate([[0], np.cumsum(starts[1:] - ends[:-1] > CLUSTER)])
    for g in np.flatnonzero(np.bincount(group) >= MEMBERS):
        mine = np.flatnonzero(group == g)
        filled[starts[mine[0]] : ends[mine[-1]]] = True
    return filled


def held(y: np.ndarray, shortest: int) -> tuple[np.ndarray, np.ndarray]:
    """Begin and end (exclusive) of runs of one value that are at least `shortest` samples long and followed by another value."""
    starts = np.flatnonzero(np.diff(y, prepend=np.nan) != 0.0)
    ends = np.append(starts[1:], y.size)
    long = (ends - starts >= shortest) & (ends < y.size)
    return starts[long], ends[long]
