"""Where flags hold: stretches of True in a row of samples."""

import numpy as np


def runs(mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where runs of True in a mask (N,) begin and end (exclusive)."""
    change = np.diff(np.concatenate([[0], mask.astype(np.int8), [0]]))
    return np.flatnonzero(change > 0), np.flatnonzero(change < 0)
