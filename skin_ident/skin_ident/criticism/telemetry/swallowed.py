"""A threshold below which a channel reads nothing: its samples leave a model that has none, and are no accidents.

They are told from drop-outs by when they occur: whenever as little should be read, and not now and then.
"""

import numpy as np

NOTHING = 0.3  # of what a channel should read, the most that it reads then
WHENEVER = 0.7  # of the times when it should read about as little


def is_swallowed(read: np.ndarray, left: np.ndarray, inside: np.ndarray) -> bool:
    """Whether a channel that should have read (N,) `read` less what a model has `left` of it reads nothing in the samples `inside`, a mask,
    and nothing whenever it should read about as little."""
    should = read - left
    most = float(np.median(should[inside])) if inside.any() else 0.0
    as_little = (should > 0.5 * most) & (should < most)
    return bool(as_little.any()) and float(np.mean(np.abs(read[as_little]) < NOTHING * should[as_little])) > WHENEVER
