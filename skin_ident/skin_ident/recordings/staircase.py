"""A depth that an encoder read in coarse steps, drawn again as the path that gave these readings.

An encoder says when the plunger crossed from one cell to the next, to a sample; in between it says nothing. A staircase taken at its word
has no speed and then too much of it, and a fit to such a speed finds too little damping (an error in a regressor draws its coefficient
to zero: W. A. Fuller, Measurement Error Models, 1987). The path drawn here crosses each cell's border when the reading changed. It is in
the middle of the cell half a crossing later, at the speed of the cell before; there it stays until half a crossing, at the speed of the
next cell, before it leaves: straight on a ramp, level where the plunger rests. A cell that is left where it was entered holds the top of
a parabola: with the cell r times as long as its neighbours, which are q wide, the top is beyond the border by

    e = q / ((1 + 2 / r)^2 - 1),        and where that is more than q, the plunger has rested in the middle.

An encoder with noise of its own flickers: while the plunger rests single readings fall into the next cell. Hundreds of such steps would be
most of all the speed in a record of holds. Where a reading flickers and keeps to two cells for a while, it is averaged over that while.
"""

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter, minimum_filter1d, uniform_filter1d

FLICKS = 20  # single readings in another cell than those before and after, from which a record flickers
RESTING = 25  # samples


def drawn_again(x: np.ndarray) -> np.ndarray:
    """Depth (N,) m without its staircase; itself where no two samples are alike.

    Never further from what was read than half a step, which is the smallest change from one reading to the next, or than a sample's change;
    or than a step where the reading flickers.
    """
    change = np.flatnonzero(np.diff(x) != 0.0) + 1
    if change.size == 0 or change.size == x.size - 1:
        return x
    begin, end = np.concatenate([[0], change]), np.concatenate([change, [x.size]])
    cell, border = x[begin], 0.5 * (x[change - 1] + x[change])
    length = (end - begin).astype(float)
    before, after = np.concatenate([[np.inf], length[:-1]]), np.concatenate([length[1:], [np.inf]])
    rise = _rise(cell, length, before, after)
    turns = np.flatnonzero(rise)
    rests = np.flatnonzero(rise == 0.0)
    reached = begin[rests] + 0.5 * np.minimum(length, before)[rests] - 0.5
    left = end[rests] - 0.5 * np.minimum(length, after)[rests] - 0.5
    middle = 0.5 * (begin + end)[turns] - 0.5
    quarter = 0.25 * length[turns]
    foot, top = border[turns - 1], rise[turns]
    when = np.concatenate([change - 0.5, reached, left, middle - quarter, middle, middle + quarter])
    where = np.concatenate([border, cell[rests], cell[rests], foot + 0.75 * top, foot + top, foot + 0.75 * top])
    order = np.argsort(when, kind="stable")
    again = np.interp(np.arange(x.size), when[order], where[order])
    jumps = np.abs(np.diff(x))
    step = jumps[jumps > 0.0].min()
    allowed = np.maximum(0.5 * step, np.abs(np.gradient(x)))
    again = np.clip(again, x - allowed, x + allowed)
    flicks = (x[1:-1] != x[:-2]) & (x[:-2] == x[2:])
    return _steady(x, again, step) if np.count_nonzero(flicks) >= FLICKS else again


def _steady(x: np.ndarray, again: np.ndarray, step: float) -> np.ndarray:
    """`again`, but the mean of the readings where these keep to two cells, single ones left aside."""
    calm = median_filter(x, 5)
    rests = maximum_filter1d(calm, RESTING) - minimum_filter1d(calm, RESTING) < 1.5 * step
    return np.where(rests, uniform_filter1d(x, RESTING), again)


def _rise(cell: np.ndarray, length: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """How far the top of each cell's parabola is beyond its border, signed; 0 where the cell holds none."""
    up = np.diff(cell)
    rise = np.zeros(cell.size)
    if up.size < 2:
        return rise
    q = np.abs(up[:-1])
    slow = (q < 1.5 * q.min()) & (length[1:-1] > 1.0)  # from cell to cell; faster, every reading stands for itself
    back = np.isclose(up[1:], -up[:-1], rtol=1e-3) & slow
    ratio = length[1:-1] / (0.5 * (before + after)[1:-1])
    beyond = q / ((1.0 + 2.0 / ratio) ** 2 - 1.0)
    rise[1:-1] = np.where(back & (beyond <= q), np.sign(up[:-1]) * beyond, 0.0)
    return rise
