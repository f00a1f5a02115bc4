"""Sinusoidal motion, the thesis's input for parameter identification (eq 29), begun and ended without a jolt.

    x(t) = C - A cos(phi(t))

starts at rest at its least depth C - A. The phase speed phi' grows from 0 to 2 pi f over the lead-in by a smooth step, stays there for
`periods` whole or broken periods, and falls back to 0 over the lead-out, so that depth, speed and acceleration are all continuous and
the depth never leaves [C - A, C + A]. During a lead of n periods the phase advances by n / 2 turns.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_motion_profiles.fields import number
from skin_motion_profiles.profile import MM, Profile, depth
from skin_motion_profiles.trajectory import Piece, Reach, State, sampled_reach


@dataclass(frozen=True)
class Sine(Profile):
    """A sine of one frequency. Thesis section 4.3.1 records four periods."""

    kind: ClassVar[str] = "sine"
    example: ClassVar = {"amplitude_mm": 0.3, "frequency_hz": 0.5, "offset_mm": 0.5, "periods": 4}

    amplitude_mm: float = number("mm, half of the way from crest to trough", lower=1e-3, upper=75.0)
    frequency_hz: float = number("Hz, frequency", lower=1e-3, upper=100.0)
    offset_mm: float | None = depth("depth about which it swings; left out: the amplitude, so that it just reaches the surface")
    periods: float = number("periods at full frequency, any number", 4.0, lower=0.0, upper=1e5)
    lead_periods: float = number("periods that the lead-in and the lead-out take each", 1.0, lower=0.25, upper=20.0)

    def pieces(self, start: float) -> Iterable[Piece]:
        """One piece: lead-in, periods, lead-out; `start` does not matter."""
        centre = self.amplitude_mm if self.offset_mm is None else self.offset_mm
        lead = self.lead_periods / self.frequency_hz
        return (_Swing(lead, self.periods / self.frequency_hz, self.frequency_hz, self.amplitude_mm * MM, centre * MM),)


@dataclass(frozen=True)
class _Swing(Piece):
    lead: float  # s
    steady: float  # s
    frequency: float  # Hz
    amplitude: float  # m
    centre: float  # m

    @property
    def duration(self) -> float:
        """Length with both leads, s."""
        return self.steady + 2.0 * self.lead

    @property
    def swiftest(self) -> float:
        """Period, or the lead where that is shorter, s."""
        return min(1.0 / self.frequency, self.lead)

    def at(self, t: np.ndarray) -> State:
        """x = centre - amplitude cos(phase), with its two derivatives; `t` (N,) s."""
        phase, rate, change = self._phase(t)
        cos, sin = np.cos(phase), np.sin(phase)
        return State(
            self.centre - self.amplitude * cos,
            self.amplitude * sin * rate,
            self.amplitude * (cos * rate**2 + sin * change),
        )

    def _phase(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Phase (rad) and its first two derivatives. The smooth step 3 u^2 - 2 u^3 integrates to u^3 - u^4 / 2."""
        omega = 2.0 * np.pi * self.frequency
        into, out = np.clip(t / self.lead, 0.0, 1.0), np.clip((self.duration - t) / self.lead, 0.0, 1.0)
        whole = np.clip(t - self.lead, 0.0, self.steady)
        phase = omega * (self.lead * (into**3 - 0.5 * into**4) + whole + self.lead * (0.5 - (out**3 - 0.5 * out**4)))
        rate = omega * np.minimum(into**2 * (3.0 - 2.0 * into), out**2 * (3.0 - 2.0 * out))
        change = omega / self.lead * (6.0 * into * (1.0 - into) - 6.0 * out * (1.0 - out))
        return phase, rate, change

    def reach(self) -> Reach:
        """From samples: it has no closed form."""
        return sampled_reach(self)
