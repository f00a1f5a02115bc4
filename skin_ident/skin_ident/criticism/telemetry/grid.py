"""Finds the grid of converter levels on which a channel sits; it shows a change of units.

A converter of step q gives multiples of q. A force that was multiplied by 4.44822 sits on multiples of 4.44822 q, and a column under the
wrong name sits on the grid of another channel.
"""

import numpy as np

TOLERANCE = 2e-3  # of a step, plus the rounding error of six written digits
ROUNDED, MOST = 6e-6, 0.1  # that error, relative to the value; its limit in steps, beyond which a finer grid would fit as well
FEWEST_LEVELS = 8  # levels that show a grid
DUST = 4  # decimal digits of a step to which levels are rounded: beyond, they differ by rounding of the calculation
CLOSE = 2.5  # steps between neighbouring levels, in a record that visits many of them


def sits_on(y: np.ndarray, step: float) -> bool:
    """Whether the samples in y (N,) are whole numbers of `step` apart, and neighbouring levels mostly only one or two steps."""
    if not step:
        return False
    levels = np.unique(np.round(y[y != 0.0] / step, DUST))
    if levels.size < FEWEST_LEVELS or np.ptp(levels) < FEWEST_LEVELS:
        return False
    return float(np.median(np.diff(levels))) < CLOSE and _on(y, step)


def _on(y: np.ndarray, step: float) -> bool:
    """Whether nearly all samples are whole steps apart. The offset of the grid does not matter, as it depends on the tare; a few samples
    may be interpolated."""
    turns = y / step
    off = turns - np.angle(np.mean(np.exp(2j * np.pi * turns))) / (2.0 * np.pi)  # a circular mean; a median may lie between two levels
    off -= np.round(off)
    off = np.abs(off - np.median(off))
    return bool(np.mean(off < TOLERANCE + np.minimum(ROUNDED * np.abs(y / step), MOST)) > 0.97)


def factor_of(y: np.ndarray, step: float, factors: tuple[float, ...]) -> float | None:
    """The factor f of `factors` for which readings y (N,) sit on the grid of f × step, with 1 tried first; None where they sit on none of
    them."""
    if _on(y, step):
        return 1.0
    for f in factors:
        if sits_on(y, f * step):
            return f
    return None
