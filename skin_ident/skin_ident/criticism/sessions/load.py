"""The load of a channel: by how much its reading y_c(t) differs from y_c0, its reading without load.

y_c is averaged over a quarter of a second, so that it does not contain the noise itself, and y_c0 is the reading at the smallest depths. A
channel that reads about as far below y_c0 as above it is taken to feel no load.
"""

import numpy as np
from scipy.ndimage import uniform_filter1d

GREATEST_PERCENTILE = 99.0  # percentile of a channel's load that is taken as its greatest load
AVERAGED_S = 0.25  # s over which the reading is averaged, so that its own noise does not count as load
LEAST_PRESSED = 0.1  # share of the samples, those of the smallest depths, that give the reading without load
ONE_SIDED = 0.4  # ratio of the readings' reach to the one side of the zero and to the other, from which both are noise, not load


def load_of(measured: np.ndarray, depth: np.ndarray, spacing: float) -> np.ndarray:
    """The load (C, n), N, of channels `measured` (C, n), N, sampled every `spacing` seconds at `depth` (n,), whatever their zero offsets
    are. A channel that reads about equally far to both sides of its zero gets no load: its readings are mostly noise, which would seem to
    grow with itself."""
    resting = depth <= np.quantile(depth, LEAST_PRESSED)
    averaged = uniform_filter1d(measured, max(round(AVERAGED_S / spacing), 1), axis=1, mode="nearest")
    felt = averaged - np.median(measured[:, resting], axis=1, keepdims=True)
    less, more = np.sort(np.abs(np.percentile(felt, [100.0 - GREATEST_PERCENTILE, GREATEST_PERCENTILE], axis=1)), axis=0)
    return np.abs(felt) * (less < ONE_SIDED * more)[:, None]
