"""The thesis's identification motion, x(t) = A sin(B (t - t0)) + C (eq 29), with A, B, C and t0 fitted instead of adjusted by hand.

For a given B the model is linear in a = A cos(B t0), b = -A sin(B t0) and C; Gauss-Newton finds B together with them. The stage starts from
rest, so the first samples do not belong to the sinusoid. They are cut off up to where the error falls to its later level.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skin_ident.estimators.errors import FitError
from skin_ident.estimators.scale import normal_scale
from skin_ident.recordings.recording import Recording
from skin_models.signals import Motion

ROUNDS = 30  # Gauss-Newton steps at most
BAD = 0.1  # ratio of rms error to amplitude from which a motion is no sinusoid
INSTEAD = "leave out --motion sinusoid to use the measured motion"
OUTSIDE = 5.0  # robust standard deviations: first samples with larger errors are cut off


@dataclass(frozen=True)
class Sinusoid:
    """amplitude A (m), omega B (rad/s), offset C (m), start t0 (s); rms and largest error (m) from sample `first` on."""

    amplitude: float
    omega: float
    offset: float
    start: float
    rms: float
    largest: float
    first: int

    def motion(self, t: np.ndarray) -> Motion:
        """Depth, speed and acceleration at t (N,) s, without the encoder's noise."""
        phase = self.omega * (t - self.start)
        a, w = self.amplitude, self.omega
        x, v, acc = self.offset + a * np.sin(phase), a * w * np.cos(phase), -a * w**2 * np.sin(phase)
        return Motion(t, x, v, acc, float(t[-1] - t[0]) / (t.size - 1))


def fit_sinusoid(t: np.ndarray, x: np.ndarray) -> Sinusoid:
    """The sinusoid fitted to a depth (N,). Raises `FitError` for a motion that is no sinusoid, or has less than one period."""
    first = 0
    for _ in range(3):
        linear, omega = _gauss_newton(t[first:], x[first:])
        error = x - _design(t, omega) @ linear
        later = error[first + (t.size - first) // 4 :]
        scale = normal_scale(later - np.median(later)) + 1e-12
        wrong = np.flatnonzero(np.abs(error[: t.size // 4]) > OUTSIDE * scale)
        new = int(wrong[-1]) + 1 if wrong.size else 0
        if new == first:
            break
        first = new
    return _checked(t, linear, omega, error[first:], first, float(np.ptp(x[first:])))


def _checked(t: np.ndarray, linear: np.ndarray, omega: float, error: np.ndarray, first: int, span: float) -> Sinusoid:
    """The sinusoid. Raises `FitError`, also for the slow and huge one of which a short arc is fitted to motions that span far less (m)."""
    a, b, c = linear
    amplitude, rms = float(np.hypot(a, b)), float(np.sqrt(np.mean(error**2)))
    if not rms < BAD * min(amplitude, 0.5 * span):
        raise FitError(f"the depth is no sinusoid: the best one misses it by {1e6 * rms:.3g} um rms; {INSTEAD}")
    if omega * (t[-1] - t[first]) < 2 * np.pi:
        raise FitError(f"the depth is no sinusoid, or less than one period of it was recorded; {INSTEAD}")
    start = float(np.mod(-np.arctan2(b, a), 2 * np.pi) / omega)
    return Sinusoid(amplitude, omega, float(c), start, rms, float(np.max(np.abs(error))), first)


def _gauss_newton(t: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, float]:
    omega = _first_guess(t, x)
    for _ in range(ROUNDS):
        design = _design(t, omega)
        linear = np.linalg.lstsq(design, x, rcond=None)[0]
        slope = (t - t[0]) * (linear[0] * design[:, 1] - linear[1] * design[:, 0])
        step = np.linalg.lstsq(np.column_stack([design, slope]), x - design @ linear, rcond=None)[0][3]
        omega += float(np.clip(step, -0.1 * omega, 0.1 * omega))
        if abs(step) < 1e-12 * omega:
            break
    return np.linalg.lstsq(_design(t, omega), x, rcond=None)[0], omega


def _first_guess(t: np.ndarray, x: np.ndarray) -> float:
    """Angular frequency (rad/s) of the highest line of the spectrum, zero-padded for a fine resolution."""
    centred = (x - x.mean()) * np.hanning(x.size)
    power = np.abs(np.fft.rfft(centred, 8 * x.size))
    dt = (t[-1] - t[0]) / (t.size - 1)
    return float(2 * np.pi * max(1, int(np.argmax(power))) / (8 * x.size * dt))


def _design(t: np.ndarray, omega: float) -> np.ndarray:
    return np.column_stack([np.sin(omega * t), np.cos(omega * t), np.ones_like(t)])


def as_sinusoids(recordings: Sequence[Recording]) -> tuple[list[Recording], list[Motion], list[Sinusoid]]:
    """The recordings cut to begin with their sinusoids, the motion of each, and the sinusoids. Raises `FitError` naming the recording."""
    parts, motions, found = [], [], []
    for r in recordings:
        if r.depth is None:
            raise FitError(f"{r.name}: no depth was recorded, and this fit needs it")
        try:
            sinusoid = fit_sinusoid(r.t, r.depth)
        except FitError as error:
            raise FitError(f"{r.name}: {error}") from error
        part = r.part(sinusoid.first, len(r))
        parts.append(part)
        motions.append(sinusoid.motion(part.t))
        found.append(sinusoid)
    return parts, motions, found
