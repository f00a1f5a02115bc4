"""Arrays from what a user gives."""

from typing import Any

import numpy as np

from skin_models.errors import ModelError, SkinError


def numbers(given: Any, what: str, error: type[SkinError] = ModelError) -> np.ndarray:
    """`given` as an array of floats, itself if it is one. Raises `error` naming `what` for text, ragged lists and the like."""
    try:
        return np.asarray(given, float)
    except (TypeError, ValueError) as cause:
        raise error(f"{what} must be numbers in an array of one shape") from cause
