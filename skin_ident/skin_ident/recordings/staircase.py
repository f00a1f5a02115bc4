"""Reconstructs the path of the plunger from a depth that an encoder read in coarse steps.

An encoder tells, to a sample, when the plunger crossed from one cell (step) to the next, and nothing in between. The derivative of such a
staircase is zero, and then too large. A fit to that speed finds too little damping, because an error in a regressor draws its coefficient
to zero (W. A. Fuller, Measurement Error Models, 1987).

The reconstructed path crosses the border between two cells when the reading changed. It reaches the middle of a cell half a crossing time
later, at the speed of the cell before, and leaves the middle half a crossing time before the next border, at the speed of the next cell. So
it is straight on a ramp, and level where the plunger rests. In a cell that is left where it was entered, the path is a parabola: if the
plunger stayed r times as long as in the neighbouring cells, which are q wide, its top is beyond the border by

    e = q / ((1 + 2 / r)^2 - 1),        and if that is more than q, the plunger has rested in the middle.

An encoder with noise flickers: while the plunger rests, single readings fall into the next cell. Hundreds of such steps would dominate the
speed in a record of holds. So where the readings flicker and stay within two cells for a while, they are averaged.
"""

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter, minimum_filter1d, uniform_filter1d

FLICKS = 20  # fewest single readings in another cell than those before and after for a record to count as flickering
RESTING = 25  # samples of the window over which resting readings are averaged


def drawn_again(x: np.ndarray) -> np.ndarray:
    """Depth (N,) m without its staircase; unchanged where no two neighbouring samples are equal.

    It differs from the readings by at most half a step (the smallest change between readings) or the change per sample, whichever is
    larger; where readings flicker, by at most a step.
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
    """`again`, replaced by the running mean of the readings where these stay within two cells (apart from single readings)."""
    calm = median_filter(x, 5)
    rests = maximum_filter1d(calm, RESTING) - minimum_filter1d(calm, RESTING) < 1.5 * step
    return np.where(rests, uniform_filter1d(x, RESTING), again)


def _rise(cell: np.ndarray, length: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Signed distance of the parabola's top beyond the border of each cell; 0 where the path in the cell is no parabola."""
    up = np.diff(cell)
    rise = np.zeros(cell.size)
    if up.size < 2:
        return rise
    q = np.abs(up[:-1])
    slow = (q < 1.5 * q.min()) & (length[1:-1] > 1.0)  # moving by one cell at a time; at higher speed every reading is exact enough
    back = np.isclose(up[1:], -up[:-1], rtol=1e-3) & slow
    ratio = length[1:-1] / (0.5 * (before + after)[1:-1])
    beyond = q / ((1.0 + 2.0 / ratio) ** 2 - 1.0)
    rise[1:-1] = np.where(back & (beyond <= q), np.sign(up[:-1]) * beyond, 0.0)
    return rise
