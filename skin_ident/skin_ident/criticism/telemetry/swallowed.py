"""A threshold below which a channel reads nothing: its samples leave a model that has none, and are no accidents.

They are told from drop-outs by when they occur: whenever as little should be read, and not now and then.
"""

import numpy as np

NOTHING = 0.3  # of what a channel should read, the most that it reads then
WHENEVER = 0.7  # of the times when it should read about as little


def is_swallowed(read: list[np.ndarray], left: list[np.ndarray], inside: list[np.ndarray]) -> bool:
    """Whether a channel that should have `read` (N,) of each session less what a model has `left` of it reads nothing in the samples
    `inside`, masks, and nothing whenever it should read about as little."""
    read, should, inside = np.concatenate(read), np.concatenate(read) - np.concatenate(left), np.concatenate(inside)
    most = float(np.median(should[inside])) if inside.any() else 0.0
    as_little = (should > 0.5 * most) & (should < most)
    return bool(as_little.any()) and float(np.mean(np.abs(read[as_little]) < NOTHING * should[as_little])) > WHENEVER
