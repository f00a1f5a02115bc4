"""Odd random-phase multisine with detection lines left out.

    m(t) = sum over excited lines k of  k^-p cos(2 pi k f0 t + phase_k),      x(t) = C + A w(t) m(t) / max |m|

Only odd multiples k of the base frequency f0 are excited, and of every `group` neighbouring odd lines one, drawn at random, is left out.
What the response shows on the even lines is even (static asymmetry), on the odd lines left out it is odd nonlinearity or memory, and
on neither: then the skin was linear. `even_detection_lines`, `odd_detection_lines` and `excited_lines` say which
is which. w fades in and out over one period each, smoothly to the second derivative, so that in between the motion is strictly periodic.

Source: R. Pintelon and J. Schoukens, System Identification: A Frequency Domain Approach, 2nd ed., Wiley 2012, section 4.3.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.fields import number, whole
from skin_motion_profiles.profile import MM, Profile, depth
from skin_motion_profiles.trajectory import Piece, Reach, State, sampled_reach

_DRAWS = 50  # sets of phases tried for the lowest peak


@dataclass(frozen=True)
class Multisine(Profile):
    """`periods` periods of a multisine about `offset_mm`, and one more to fade in and one to fade out."""

    kind: ClassVar[str] = "multisine"
    example: ClassVar = {"seed": 1, "amplitude_mm": 0.4, "base_frequency_hz": 0.25, "periods": 2}

    seed: int = whole("seed of the phases and of the lines left out", ...)
    amplitude_mm: float = number("mm, greatest distance from the offset", lower=1e-3, upper=75.0)
    base_frequency_hz: float = number("Hz, distance of two lines and one over the period", 0.1, lower=1e-3, upper=10.0)
    highest_hz: float = number("Hz, highest line", 5.0, lower=1e-3, upper=100.0)
    offset_mm: float | None = depth("depth about which it moves; left out: the amplitude, so that it just reaches the surface")
    periods: int = whole("whole periods at full size", 1, lower=1, upper=10000)
    group: int = whole("of so many odd lines one is left out", 4, lower=2, upper=1000)
    falling: float = number("exponent p of the amplitudes k^-p: 0 is flat in depth, 1 in speed", 1.0, lower=0.0, upper=3.0)

    def check(self) -> None:
        """Raise `ProfileError` where there are fewer odd lines than a group has."""
        if self.odd_lines.size < self.group:
            raise ProfileError(
                f"{self.label}: up to highest_hz = {self.highest_hz:g} there are {self.odd_lines.size} odd multiples of "
                f"{self.base_frequency_hz:g} Hz, fewer than group = {self.group}: raise highest_hz"
            )

    @cached_property
    def odd_lines(self) -> np.ndarray:
        """All odd multiples of the base frequency up to the highest, (n,)."""
        return np.arange(1, int(self.highest_hz / self.base_frequency_hz + 1e-9) + 1, 2)

    @cached_property
    def excited_lines(self) -> np.ndarray:
        """Multiples of the base frequency that are excited, (n,). The lowest line always is."""
        rng = np.random.default_rng([self.seed, 0])
        groups = [self.odd_lines[i : i + self.group] for i in range(1, self.odd_lines.size, self.group)]
        out = {int(g[rng.integers(g.size)]) for g in groups if g.size == self.group or len(groups) == 1}
        return np.array([k for k in self.odd_lines.tolist() if k not in out])

    @cached_property
    def odd_detection_lines(self) -> np.ndarray:
        """Odd multiples that were left out, (n,): memory and odd nonlinearity show there."""
        return np.setdiff1d(self.odd_lines, self.excited_lines)

    @cached_property
    def even_detection_lines(self) -> np.ndarray:
        """Even multiples up to the highest line, (n,): even nonlinearity shows there."""
        return np.arange(2, int(self.odd_lines[-1]) + 1, 2)

    def pieces(self, start: float) -> Iterable[Piece]:
        """One piece: a period to fade in, the whole periods, one to fade out; `start` does not matter."""
        centre = (self.amplitude_mm if self.offset_mm is None else self.offset_mm) * MM
        amplitudes, phases = self._spectrum
        return (_Lines(1.0 / self.base_frequency_hz, self.periods, tuple(self.excited_lines.tolist()), amplitudes, phases, centre),)

    @cached_property
    def _spectrum(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Amplitude (m) and phase (rad) of every excited line: of several random sets of phases the one with the lowest peak."""
        lines, rng = self.excited_lines, np.random.default_rng([self.seed, 1])
        sizes = lines.astype(float) ** -self.falling
        draws = [2.0 * np.pi * rng.random(lines.size) for _ in range(_DRAWS)]
        best = min(draws, key=lambda phases: _peak(lines, sizes, phases, 8))
        amplitudes = self.amplitude_mm * MM / _peak(lines, sizes, best, 128) * sizes
        return tuple(amplitudes.tolist()), tuple(best.tolist())


def _peak(lines: np.ndarray, sizes: np.ndarray, phases: np.ndarray, density: int) -> float:
    """Greatest absolute value over a period, from `density` samples per period of the highest line."""
    n = density * int(lines[-1])
    spectrum = np.zeros(n // 2 + 1, complex)
    spectrum[lines] = 0.5 * n * sizes * np.exp(1j * phases)
    return float(np.abs(np.fft.irfft(spectrum, n)).max())


@dataclass(frozen=True)
class _Lines(Piece):
    period: float  # s
    periods: int
    lines: tuple[int, ...]
    amplitudes: tuple[float, ...]  # m
    phases: tuple[float, ...]  # rad
    centre: float  # m

    @property
    def duration(self) -> float:
        """Length with both fades, s."""
        return (self.periods + 2) * self.period

    @property
    def swiftest(self) -> float:
        """Period of the highest line, s."""
        return self.period / self.lines[-1]

    def at(self, t: np.ndarray) -> State:
        """The sum of the module's docstring, faded, with its two derivatives; `t` (N,) s."""
        omega, sizes = 2.0 * np.pi * np.array(self.lines) / self.period, np.array(self.amplitudes)
        angles = np.outer(t, omega) + np.array(self.phases)
        m, dm, ddm = np.cos(angles) @ sizes, -np.sin(angles) @ (sizes * omega), -np.cos(angles) @ (sizes * omega**2)
        w, dw, ddw = self._window(t)
        return State(self.centre + w * m, dw * m + w * dm, ddw * m + 2.0 * dw * dm + w * ddm)

    def _window(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The fade and its two derivatives: 10 u^3 - 15 u^4 + 6 u^5 of the time since the beginning, or until the end."""
        late = t > 0.5 * self.duration
        u = np.clip(np.where(late, self.duration - t, t) / self.period, 0.0, 1.0)
        sign = np.where(late, -1.0, 1.0)
        return (
            u**3 * (10.0 - 15.0 * u + 6.0 * u**2),
            sign * 30.0 * u**2 * (1.0 - u) ** 2 / self.period,
            60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / self.period**2,
        )

    def reach(self) -> Reach:
        """From samples: it has no closed form."""
        return sampled_reach(self)
