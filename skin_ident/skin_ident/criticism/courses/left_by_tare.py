"""How far off a tare leaves a channel's zero.

A tare averages readings in the air. A reading in steps is set no better than to one of them, and noise that wanders is still somewhere when
the average ends: with the spectrum S of a channel's noise without load, the average of n samples has the variance

    sigma^2 = 1 / pi integral from 0 to pi of S(w) (sin(n w / 2) / (n sin(w / 2)))^2 dw.

Every channel of every session is tared, and the worst of many zeros lies further off than any one does: so far that none of them lies
further but with a chance of `CHANCE`. What sessions share is the smaller for their number.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from skin_ident.criticism.gates.resolution import ROUNDED, converter_step
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.session import Session
from skin_ident.stretches import runs

AVERAGED_S = 0.5  # that a tare lasts at least
CHANCE = 0.01  # that any zero lies further off than is said
RESTING = 0.02  # of the greatest force, below which next to nothing presses
FEWEST = 8  # averages that tell how a force wanders
MORE = 10.0  # fall of the squared whitened error, by which larger zeros may explain more


@dataclass(frozen=True)
class Tare:
    """Of one channel: the converter's `step`, N (0: none seen), and the standard deviation of its noise's average over a tare, N; of how
    many `zeros` that were set it is one."""

    step: float
    wander: float
    zeros: int = 1

    @property
    def leaves(self) -> float:
        """The largest zero of one session, N: half a step of the tare, half of what it is taken from."""
        return float(np.hypot(self.step, self._wandered))

    def leaves_all(self, sessions: int) -> float:
        """The largest zero, N, that so many sessions share."""
        return float(np.hypot(ROUNDED * self.step, self._wandered / np.sqrt(sessions)))

    @property
    def _wandered(self) -> float:
        return float(norm.isf(0.5 * CHANCE / self.zeros)) * self.wander

    @property
    def said(self) -> str:
        """What the tare was of, in words."""
        if self.step > self._wandered:
            return f"a tare that is read in steps of {self.step:.2g} N"
        return f"a tare in noise that wanders by {self.wander:.2g} N rms from one half second to another"


def tares(sessions: list[Session], noise: Whitener) -> list[Tare]:
    """What tares leave of every channel of `sessions`."""
    first = sessions[0]
    wander = noise.averaged(max(round(AVERAGED_S / first.band.spacing), 1))
    zeros = len(first.channels) * len(sessions)
    return [Tare(converter_step(sessions, c), float(w), zeros) for c, w in zip(first.channels, wander, strict=True)]


def tare_of_drive(sessions: list[Session]) -> Tare:
    """What tares leave of the force that drives `sessions`: by what is white of its noise, and how averages of it wander while it rests."""
    noise, step = (max(getattr(s, of) for s in sessions) for of in ("drive_noise", "drive_step"))
    white = noise / float(np.sqrt(2.0 * sessions[0].band.edge * AVERAGED_S))
    averages = [a - np.mean(a) for a in map(_averages_at_rest, sessions) if a.size > 1]
    seen = sum(a.size - 1 for a in averages)
    wanders = float(np.sqrt(sum(np.sum(a**2) for a in averages) / seen)) if seen >= FEWEST else 0.0
    return Tare(step, max(white, wanders), len(sessions))


def drive_rests(s: Session) -> np.ndarray:
    """Where next to nothing presses in a test that a force drives, (N,)."""
    return np.abs(s.drive) < RESTING * s.drive.max()


def _averages_at_rest(s: Session) -> np.ndarray:
    """The averages of the driving force over times as long as a tare while it rests, N."""
    size = max(round(AVERAGED_S / s.motion.dt), 1)
    starts = [np.arange(a, b - size + 1, size) for a, b in zip(*runs(drive_rests(s)), strict=True)]
    return np.array([np.mean(s.drive[i : i + size]) for i in np.concatenate(starts or [np.zeros(0, int)])])
