"""Noise that grows with the load.

A capacitive taxel's noise grows with what it reads, and so does the force that an encoder's noise presses into stiffening skin. Its
standard deviation is taken as

    s_c(t) = s_c (1 + g_c min(|y_c(t) - y_c0|, y_c1) / y_c1),

y_c what channel c reads, averaged over a quarter of a second lest the noise be measured by itself, y_c0 what it reads where least is
pressed, and y_c1 the greatest load that the growth was seen at; a channel that reads as far to either side of y_c0 feels none. The growth
g_c is the one under which the innovations of noise that is steady are described in the fewest words, where their absolute values are
exponential: outliers lead squares astray. Steady noise is believed unless growth says clearly more.

Source: A. C. Harvey, Estimating regression models with multiplicative heteroscedasticity, Econometrica 44 (1976) 461-465.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.ndimage import uniform_filter1d

GROWTHS = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 3.0])  # at a channel's greatest load; beyond, air seems silent that merely lies on one step
GREATEST = 99.0  # percent of the samples that are loaded less
CLEARLY = 10.0  # nats
AVERAGED_S = 0.25  # over which a load is averaged, so that its own noise is none
LEAST_PRESSED = 0.1  # of the samples
ONE_SIDED = 0.4  # of the greatest reading to one side, the least to the other that is noise


class Channels(Protocol):
    """What a noise model knows of a session, (C, n) each: `weight`, 0 where a sample may not be believed, and `load` of each channel, N."""

    weight: np.ndarray
    load: np.ndarray


@dataclass(frozen=True)
class Growth:
    """g_c and y_c1 (N) of the module's equation, (C,) each."""

    more: np.ndarray
    greatest: np.ndarray

    @staticmethod
    def none(channels: int) -> "Growth":
        """That of steady noise."""
        return Growth(np.zeros(channels), np.ones(channels))

    @property
    def is_any(self) -> bool:
        """Whether the noise of any channel grows."""
        return bool(self.more.any())

    def loudness(self, s: Channels) -> np.ndarray:
        """How many times louder than without load the noise of a session is, (C, n)."""
        return 1.0 + self.more[:, None] * np.minimum(s.load / self.greatest[:, None], 1.0)


def load_of(measured: np.ndarray, depth: np.ndarray, spacing: float) -> np.ndarray:
    """The load (C, n) of channels `measured` (C, n), N, every `spacing` seconds at `depth` (n,), whatever their zeros are. What goes to
    either side of the zero is no load but noise, and of a channel that feels little else it would seem to grow with itself."""
    resting = depth <= np.quantile(depth, LEAST_PRESSED)
    averaged = uniform_filter1d(measured, max(round(AVERAGED_S / spacing), 1), axis=1, mode="nearest")
    felt = averaged - np.median(measured[:, resting], axis=1, keepdims=True)
    less, more = np.sort(np.abs(np.percentile(felt, [100.0 - GREATEST, GREATEST], axis=1)), axis=0)
    return np.abs(felt) * (less < ONE_SIDED * more)[:, None]


def growth(innovations: list[np.ndarray], sessions: list[Channels]) -> Growth:
    """The growth of noise of which `innovations` [(C, n), …] are known as if it were steady. Zeros are none."""
    size = np.concatenate([np.abs(w) for w in innovations], axis=1)
    load = np.concatenate([s.load for s in sessions], axis=1)
    found = [_of_one(*(x[s > 0.0] for x in (s, y))) for s, y in zip(size, load, strict=True)]
    return Growth(*np.array(found).T)


def _of_one(size: np.ndarray, load: np.ndarray) -> tuple[float, float]:
    """How many times as loud, less one, the noise is under the greatest load, and that load, N, by the fewest words; 0 where that is not
    clearly fewer than of noise that is steady."""
    greatest = float(np.percentile(load, GREATEST)) if load.size else 0.0
    if greatest <= 0.0:
        return 0.0, 1.0
    louder = [1.0 + g * np.minimum(load / greatest, 1.0) for g in GROWTHS]
    words = [size.size * np.log(np.mean(size / s)) + np.sum(np.log(s)) for s in louder]
    best = int(np.argmin(words))
    return (float(GROWTHS[best]) if words[best] < words[0] - CLEARLY else 0.0), greatest
