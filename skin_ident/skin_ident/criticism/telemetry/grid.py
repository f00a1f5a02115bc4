"""On which grid of levels a channel sits: the trace of its converter, which a change of units carries along.

A converter of step q gives multiples of q. A force that was multiplied by 4.44822 sits on multiples of 4.44822 q, and a column under
the wrong name on those of another channel.
"""

import numpy as np

TOLERANCE = 2e-3  # of a step, plus what six written digits round away,
ROUNDED, MOST = 6e-6, 0.1  # up to so much of a step: beyond, a grid of finer steps would fit as well
FEWEST_LEVELS = 8  # that tell a grid
DUST = 4  # digits of a step, beyond which levels differ by how they were worked out
CLOSE = 2.5  # steps between neighbouring levels, in a record that dwells on many of them


def sits_on(y: np.ndarray, step: float) -> bool:
    """Whether the samples in y (N,) are a whole number of `step` apart, and their levels mostly just one or two."""
    if not step:
        return False
    levels = np.unique(np.round(y[y != 0.0] / step, DUST))
    if levels.size < FEWEST_LEVELS or np.ptp(levels) < FEWEST_LEVELS:
        return False
    return float(np.median(np.diff(levels))) < CLOSE and _on(y, step)


def _on(y: np.ndarray, step: float) -> bool:
    """Whether nearly all samples are whole steps apart. Where they begin is a matter of the tare; a few may have been interpolated."""
    turns = y / step
    off = turns - np.angle(np.mean(np.exp(2j * np.pi * turns))) / (2.0 * np.pi)  # a median of levels may lie between two of them
    off -= np.round(off)
    off = np.abs(off - np.median(off))
    return bool(np.mean(off < TOLERANCE + np.minimum(ROUNDED * np.abs(y / step), MOST)) > 0.97)


def factor_of(y: np.ndarray, step: float, factors: tuple[float, ...]) -> float | None:
    """The factor f of `factors` for which readings y (N,) sit on the grid of f × step, 1 first; None where it sits on none of them."""
    if _on(y, step):
        return 1.0
    for f in factors:
        if sits_on(y, f * step):
            return f
    return None
