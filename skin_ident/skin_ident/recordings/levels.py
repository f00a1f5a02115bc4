"""The levels of a converter, found from its readings.

They are equally spaced; the spacing is the largest step of which (nearly) all differences of neighbouring levels are multiples.
Interpolated readings can be anywhere between two levels, so steps must be found before interpolation.
"""

import numpy as np

FEWEST_LEVELS = 4  # from which a spacing is found
MANY = 0.5  # ratio of different values to samples above which the readings are not quantized


def step_of(y: np.ndarray) -> float | None:
    """Spacing of the levels in `y` (N,), or None where the samples are not on levels."""
    levels = np.unique(y)
    if levels.size < FEWEST_LEVELS or levels.size > MANY * y.size:
        return None
    span = levels[-1] - levels[0]
    gaps = np.diff(levels)
    gaps = gaps[gaps > 1e-7 * span]
    step = float(np.median(gaps[gaps <= 1.2 * np.percentile(gaps, 10.0)]))
    multiples = gaps / step
    return step if np.mean(np.abs(multiples - np.round(multiples)) < 0.1) > 0.9 else None


def steps_of(rows: np.ndarray) -> tuple[float, ...]:
    """The spacing of the levels of every row (R, N), NaN left out; 0 where there is none."""
    return tuple(step_of(row[np.isfinite(row)]) or 0.0 for row in rows)
