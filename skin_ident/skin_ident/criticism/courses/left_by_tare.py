"""How far off a tare leaves a channel's zero.

A tare averages readings in the air. A reading in steps is set no better than to one of them, and noise that wanders is still somewhere when
the average ends: with the spectrum S of a channel's noise without load, the average of n samples has the variance

    sigma^2 = 1 / pi integral from 0 to pi of S(w) (sin(n w / 2) / (n sin(w / 2)))^2 dw.

Sessions are tared each; what they share is the smaller for it.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.gates.resolution import ROUNDED, converter_step
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.session import Session

AVERAGED_S = 0.5  # that a tare lasts at least
WANDERED = 2.5  # standard deviations of its average
MORE = 10.0  # fall of the squared whitened error, by which larger zeros may explain more


@dataclass(frozen=True)
class Tare:
    """Of one channel: the converter's `step`, N (0: none seen), and the standard deviation of its noise's average over a tare, N."""

    step: float
    wander: float

    @property
    def leaves(self) -> float:
        """The largest zero of one session, N: half a step of the tare, half of what it is taken from."""
        return float(np.hypot(self.step, WANDERED * self.wander))

    def leaves_all(self, sessions: int) -> float:
        """The largest zero, N, that so many sessions share."""
        return float(np.hypot(ROUNDED * self.step, WANDERED * self.wander / np.sqrt(sessions)))

    @property
    def said(self) -> str:
        """What the tare was of, in words."""
        if self.step > WANDERED * self.wander:
            return f"a tare that is read in steps of {self.step:.2g} N"
        return f"a tare in noise that wanders by {self.wander:.2g} N rms from one half second to another"


def tares(sessions: list[Session], noise: Whitener) -> list[Tare]:
    """What tares leave of every channel of `sessions`."""
    first = sessions[0]
    wander = noise.averaged(max(round(AVERAGED_S / first.band.spacing), 1))
    return [Tare(converter_step(sessions, c), float(w)) for c, w in zip(first.channels, wander, strict=True)]
