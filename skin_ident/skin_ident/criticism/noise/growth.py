"""Noise that grows with the load.

A capacitive taxel's noise grows with what it reads, and so does the force that an encoder's noise presses into stiffening skin. Its
standard deviation is taken as

    s_c(t) = s_c (1 + g_c |y_c(t)|),

y_c what channel c reads, averaged over a quarter of a second lest the noise be measured by itself. The growth g_c is the one under which
the innovations of noise that is steady are described in the fewest words, where their absolute values are exponential: heavy tails do not
lead astray there what outliers would with squares. Steady noise is believed unless growth says clearly more.

Source: A. C. Harvey, Estimating regression models with multiplicative heteroscedasticity, Econometrica 44 (1976) 461-465.
"""

from typing import Protocol

import numpy as np
from scipy.ndimage import uniform_filter1d

GROWTHS = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 3.0])  # at a channel's greatest load; beyond, air seems silent that merely lies on one step
GREATEST = 99.0  # percent of the samples that are loaded less
CLEARLY = 10.0  # nats
AVERAGED_S = 0.25


class Channels(Protocol):
    """What a noise model knows of a session, (C, n) each: `weight`, 0 where a sample may not be believed, and `load`, what a channel reads
    (N)."""

    weight: np.ndarray
    load: np.ndarray


def load_of(measured: np.ndarray, spacing: float) -> np.ndarray:
    """The load (C, n) of channels `measured` (C, n) every `spacing` seconds, N."""
    return np.abs(uniform_filter1d(measured, max(round(AVERAGED_S / spacing), 1), axis=1, mode="nearest"))


def growth(innovations: list[np.ndarray], sessions: list[Channels]) -> np.ndarray:
    """g (C,), 1/N, of innovations (C, n) of noise that was taken as steady. Zeros are none."""
    size = np.concatenate([np.abs(w) for w in innovations], axis=1)
    load = np.concatenate([s.load for s in sessions], axis=1)
    return np.array([_of_one(*(x[s > 0.0] for x in (s, y))) if s.any() else 0.0 for s, y in zip(size, load, strict=True)])


def _of_one(size: np.ndarray, load: np.ndarray) -> float:
    greatest = float(np.percentile(load, GREATEST))
    if greatest <= 0.0:
        return 0.0
    words = [size.size * np.log(np.mean(size / s)) + np.sum(np.log(s)) for s in (1.0 + g * load / greatest for g in GROWTHS)]
    best = int(np.argmin(words))
    return float(GROWTHS[best] / greatest) if words[best] < words[0] - CLEARLY else 0.0
