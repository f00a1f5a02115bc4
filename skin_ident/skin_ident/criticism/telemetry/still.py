"""Whether a channel moves at all. Real motion is smooth beside the channel's noise, because a plunger cannot jump from sample to sample.

With d the difference of neighbouring samples, white noise has var(d) = 2 var(y); a sinusoid with six samples or more in a period has less
than var(y). So a channel is still where var(y) < MOVES var(d) / 2, without spikes.
"""

import numpy as np

MOVES = 1.5  # between white noise, which has 1, and motion, which has 2 or more
SPIKES = 0.5  # percent of the samples that are clipped above and below
NOTHING = 1e-9  # share of the largest value that is rounding


def is_still(y: np.ndarray) -> bool:
    """Whether the samples (N,) are constant, or noise around a constant."""
    y = np.clip(y, *np.percentile(y, [SPIKES, 100.0 - SPIKES]))
    if y.size < 3 or np.ptp(y) <= NOTHING * np.max(np.abs(y)):
        return True
    return bool(np.var(y) < MOVES * np.mean(np.diff(y) ** 2) / 2.0)
