"""A depth that an encoder read in coarse steps, drawn again as the path that gave these readings.

An encoder says when the plunger crossed from one cell to the next, to a sample; in between it says nothing. A staircase taken at its word
has no speed and then too much of it, and a fit to such a speed finds too little damping (an error in a regressor draws its coefficient
to zero: W. A. Fuller, Measurement Error Models, 1987). The path drawn here crosses each cell's border when the reading changed, and is in
the middle of the cell half a crossing later, at the speed of the cell before; there it stays until half a crossing, at the speed of the
next cell, before it leaves: straight on a ramp, level where the plunger rests.
"""

import numpy as np


def drawn_again(x: np.ndarray) -> np.ndarray:
    """Depth (N,) m without its staircase, never further than half a step from what was read; itself where no two samples are alike."""
    change = np.flatnonzero(np.diff(x) != 0.0) + 1
    if change.size == 0 or change.size == x.size - 1:
        return x
    begin, end = np.concatenate([[0], change]), np.concatenate([change, [x.size]])
    length = end - begin
    border = 0.5 * (x[change - 1] + x[change])
    before, after = np.concatenate([[np.inf], length[:-1]]), np.concatenate([length[1:], [np.inf]])
    reached = begin + 0.5 * np.minimum(length, before) - 0.5
    left = end - 0.5 * np.minimum(length, after) - 0.5
    when = np.concatenate([change - 0.5, reached, left])
    where = np.concatenate([border, x[begin], x[begin]])
    order = np.argsort(when, kind="stable")
    return np.interp(np.arange(x.size), when[order], where[order])
