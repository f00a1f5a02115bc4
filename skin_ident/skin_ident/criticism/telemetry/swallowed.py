"""A threshold below which a channel reads nothing: its samples differ from a model without threshold, and are no accidents.

They are told from drop-outs by their timing: they occur whenever so little should be read, and not now and then.
"""

import numpy as np

NOTHING = 0.3  # largest reading that is nothing, as a share of the expected one
WHENEVER = 0.7  # share of the samples with such a small expected reading that must read nothing


def is_swallowed(read: list[np.ndarray], left: list[np.ndarray], inside: list[np.ndarray]) -> bool:
    """Whether a channel reads nothing whenever it should read about as little as in the samples `inside` (masks of each session). `read`
    (N,) are its readings and `left` (N,) its residuals."""
    read, should, inside = np.concatenate(read), np.concatenate(read) - np.concatenate(left), np.concatenate(inside)
    most = float(np.median(should[inside])) if inside.any() else 0.0
    as_little = (should > 0.5 * most) & (should < most)
    return bool(as_little.any()) and float(np.mean(np.abs(read[as_little]) < NOTHING * should[as_little])) > WHENEVER
