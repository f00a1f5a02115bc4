"""Noise that grows with the load.

A capacitive taxel's noise grows with its reading. So does the force noise that an encoder's noise makes in stiffening skin. The standard
deviation is modelled as

    s_c(t) = s_c (1 + g_c min(|y_c(t) - y_c0|, y_c1) / y_c1).

|y_c - y_c0| is the load of channel c (`sessions.load`), and y_c1 the greatest load at which growth is fitted. g_c minimises the description
length of the innovations of a steady noise model, with exponentially distributed absolute values, because outliers would dominate squares.
Noise is taken as steady unless growth is clearly shorter (`CLEARLY`).

Source: A. C. Harvey, Estimating regression models with multiplicative heteroscedasticity, Econometrica 44 (1976) 461-465.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from skin_ident.criticism.sessions.load import GREATEST_PERCENTILE

GROWTHS = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 3.0])  # candidates for g_c: with more, air seems silent that stays on one step
CLEARLY = 10.0  # nats by which growth must shorten the description


class Channels(Protocol):
    """What a noise model needs of a session, (C, n) each: `weight`, 0 where a sample is not trusted, and `load` of each channel, N."""

    weight: np.ndarray
    load: np.ndarray


@dataclass(frozen=True)
class Growth:
    """g_c and y_c1 (N) of the module's equation, (C,) each."""

    more: np.ndarray
    greatest: np.ndarray

    @staticmethod
    def none(channels: int) -> "Growth":
        """No growth: steady noise in every channel."""
        return Growth(np.zeros(channels), np.ones(channels))

    @property
    def is_any(self) -> bool:
        """Whether the noise of any channel grows."""
        return bool(self.more.any())

    def loudness(self, s: Channels) -> np.ndarray:
        """Factor by which the noise of a session is louder than without load, (C, n)."""
        return 1.0 + self.more[:, None] * np.minimum(s.load / self.greatest[:, None], 1.0)


def growth(innovations: list[np.ndarray], sessions: list[Channels]) -> Growth:
    """Fits how the noise grows to the `innovations` [(C, n), …] of a steady noise model. Zeros are left-out samples."""
    size = np.concatenate([np.abs(w) for w in innovations], axis=1)
    load = np.concatenate([s.load for s in sessions], axis=1)
    found = [_of_one(*(x[s > 0.0] for x in (s, y))) for s, y in zip(size, load, strict=True)]
    return Growth(*np.array(found).T)


def _of_one(size: np.ndarray, load: np.ndarray) -> tuple[float, float]:
    """g_c and y_c1 (N) of one channel, by the shortest description of |innovation| `size` at `load`; g_c is 0 unless it is clearly shorter
    than that of steady noise."""
    greatest = float(np.percentile(load, GREATEST_PERCENTILE)) if load.size else 0.0
    if greatest <= 0.0:
        return 0.0, 1.0
    louder = [1.0 + g * np.minimum(load / greatest, 1.0) for g in GROWTHS]
    words = [size.size * np.log(np.mean(size / s)) + np.sum(np.log(s)) for s in louder]
    best = int(np.argmin(words))
    return (float(GROWTHS[best]) if words[best] < words[0] - CLEARLY else 0.0), greatest
