"""What the effects of the skin share: they act on both branches, and only in contact."""

from typing import Any

import numpy as np


def depth_in_contact(x: Any) -> Any:
    """Depth, m, where the plunger is in the skin; zero in the air."""
    return np.maximum(x, 0.0)


def branches(sensed: float, dispersed: float, f: Any, x: Any) -> np.ndarray:
    """A force history `f`, scaled for the sensed and for the dispersed branch, zero in the air (x <= 0): shape (2,) or (2, N)."""
    return np.multiply.outer(np.array([sensed, dispersed]), f * (np.asarray(x) > 0.0))
