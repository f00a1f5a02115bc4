"""The zero error that a tare (zeroing in air) leaves in a channel.

A tare averages readings in the air. If readings come in steps, the zero is known no better than one step. If the noise is slow, the average
has not settled: with the spectrum S of a channel's noise without load, the average of n samples has the variance

    sigma^2 = 1 / pi integral from 0 to pi of S(w) (sin(n w / 2) / (n sin(w / 2)))^2 dw.

Every channel of every session is tared, and the largest of many zero errors is larger than a typical one. The bound is set so that with
probability 1 - `CHANCE` none of them exceeds it. A zero that all sessions share is smaller by the square root of their number.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from skin_ident.criticism.gates.resolution import ROUNDED, converter_step
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.session import Session
from skin_ident.stretches import runs

AVERAGED_S = 0.5  # s, that a tare lasts at least
CHANCE = 0.01  # probability that any of the zeros exceeds the bound
RESTING = 0.02  # share of the greatest driving force, below which it counts as at rest
FEWEST = 8  # averages needed to estimate how a resting force wanders
MORE_BY_LARGER_ZEROS = 10.0  # squared whitened units that larger zeros may explain in addition, for the bounded ones still to do


@dataclass(frozen=True)
class Tare:
    """The tare of one channel: the converter's `step`, N (0: none seen), the standard deviation of its noise averaged over a tare,
    `wander`, N, and how many `zeros` were set in all."""

    step: float
    wander: float
    zeros: int = 1

    @property
    def leaves(self) -> float:
        """The largest zero error of one session, N: half a step from the tare itself, half a step from the readings it is subtracted
        from."""
        return float(np.hypot(self.step, self._wandered))

    def leaves_all(self, sessions: int) -> float:
        """The largest zero error, N, that so many sessions share."""
        return float(np.hypot(ROUNDED * self.step, self._wandered / np.sqrt(sessions)))

    @property
    def _wandered(self) -> float:
        return float(norm.isf(0.5 * CHANCE / self.zeros)) * self.wander

    @property
    def said(self) -> str:
        """What limits the tare, in words."""
        if self.step > self._wandered:
            return f"a tare that is read in steps of {self.step:.2g} N"
        return f"a tare in noise that wanders by {self.wander:.2g} N rms from one half second to another"


def tares(sessions: list[Session], noise: Whitener) -> list[Tare]:
    """The tare of every channel of `sessions`."""
    first = sessions[0]
    wander = noise.averaged(max(round(AVERAGED_S / first.band.spacing), 1))
    zeros = len(first.channels) * len(sessions)
    return [Tare(converter_step(sessions, c), float(w), zeros) for c, w in zip(first.channels, wander, strict=True)]


def tare_of_drive(sessions: list[Session]) -> Tare:
    """The tare of the force that drives `sessions`: from its white noise, and from the scatter of its averages at rest, if that is
    larger."""
    noise, step = (max(getattr(s, of) for s in sessions) for of in ("drive_noise", "drive_step"))
    white = noise / float(np.sqrt(2.0 * sessions[0].band.edge * AVERAGED_S))
    averages = [a - np.mean(a) for a in map(_averages_at_rest, sessions) if a.size > 1]
    seen = sum(a.size - 1 for a in averages)
    wanders = float(np.sqrt(sum(np.sum(a**2) for a in averages) / seen)) if seen >= FEWEST else 0.0
    return Tare(step, max(white, wanders), len(sessions))


def drive_rests(s: Session) -> np.ndarray:
    """Mask (N,) of the samples at which the driving force is next to nothing."""
    size = np.abs(s.drive)
    return size < RESTING * size.max()


def _averages_at_rest(s: Session) -> np.ndarray:
    """Averages of the driving force at rest, each as long as a tare, N."""
    size = max(round(AVERAGED_S / s.motion.dt), 1)
    starts = [np.arange(a, b - size + 1, size) for a, b in zip(*runs(drive_rests(s)), strict=True)]
    return np.array([np.mean(s.drive[i : i + size]) for i in np.concatenate(starts or [np.zeros(0, int)])])
