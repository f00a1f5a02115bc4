"""The levels of a converter, found from its readings.

They are equally spaced; the spacing is the largest step of which (nearly) all differences of neighbouring levels are multiples. Motion at
one speed visits levels one sample's way apart, most of all there are; where a reading at rest flickers by less, that is the spacing.
Interpolated readings can be anywhere between two levels, so steps must be found before interpolation.
"""

import numpy as np

FEWEST_LEVELS = 4  # from which a spacing is found
FINER, OFTEN = 0.6, 0.1  # share of a spacing below which a change of the reading is finer, and share of the changes that must be
MANY = 0.5  # ratio of different values to samples above which the readings are not quantized


def step_of(y: np.ndarray) -> float | None:
    """Spacing of the levels in `y` (N,), or None where the samples are not on levels."""
    levels = np.unique(y)
    if levels.size < FEWEST_LEVELS or levels.size > MANY * y.size:
        return None
    span = levels[-1] - levels[0]
    gaps = np.diff(levels)
    gaps = gaps[gaps > 1e-7 * span]
    step = _narrowest(gaps)
    changes = np.abs(np.diff(y))
    changes = changes[changes > 1e-7 * span]
    finer = changes[changes < FINER * step]
    if finer.size > OFTEN * changes.size:
        step = _narrowest(finer)
    multiples = gaps / step
    return step if np.mean(np.abs(multiples - np.round(multiples)) < 0.1) > 0.9 else None


def _narrowest(distances: np.ndarray) -> float:
    """The usual one among the least of some distances."""
    return float(np.median(distances[distances <= 1.2 * np.percentile(distances, 10.0)]))


def steps_of(rows: np.ndarray) -> tuple[float, ...]:
    """The spacing of the levels of every row (R, N), NaN left out; 0 where there is none."""
    return tuple(step_of(row[np.isfinite(row)]) or 0.0 for row in rows)
