"""Whether a channel moves at all: what moves is smooth beside its own noise, for a plunger cannot jump from sample to sample.

With d the difference of neighbouring samples, white noise has var(d) = 2 var(y); a sinusoid seen from six samples a period on has less than
var(y). So a channel is still where var(y) < MOVES var(d) / 2, spikes left aside.
"""

import numpy as np

MOVES = 1.5  # between white noise, which has 1, and what moves, from 2 on
SPIKES = 0.5  # percent of the samples, above and below
NOTHING = 1e-9  # of the largest value: rounding


def is_still(y: np.ndarray) -> bool:
    """Whether the samples (N,) are one constant, or noise around it."""
    y = np.clip(y, *np.percentile(y, [SPIKES, 100.0 - SPIKES]))
    if y.size < 3 or np.ptp(y) <= NOTHING * np.max(np.abs(y)):
        return True
    return bool(np.var(y) < MOVES * np.mean(np.diff(y) ** 2) / 2.0)
