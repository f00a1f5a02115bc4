"""The errors that a converter's steps cause in the estimates where the noise is too small to hide the steps.

A value y with noise of standard deviation sigma, read in steps q, has the mean error

    b(y) = q / pi  sum_k (-1)^k / k  exp(-2 (pi k sigma / q)^2)  sin(2 pi k (y / q + p))

This is no noise: the same motion makes the same error every time, and averaging does not remove it. The offset p of the levels is unknown.
The estimates move by G' b, so that over all p their covariance is

    1/2 sum_k c_k^2 Re(z_k z_k*'),   z_k = G' exp(2 pi i k y / q),   c_k the amplitudes above

Source: B. Widrow, I. Kollar, Quantization Noise, Cambridge University Press 2008, chapters 4 and 6.
"""

from collections.abc import Sequence

import numpy as np

HARMONICS = 30  # of the mean error, at most
SMALL = 1e-3  # of a step: smaller amplitudes are left out
LEVELS = 4  # fewest levels from which a converter is recognised
ON_GRID = 0.95  # share of the distances between levels that must be whole steps
UNSURE = 0.1  # of q^2 / 12: the error of a few steps may differ this much from that of many; the difference is not taken for noise
PROBES = 20_000  # samples of a session in which steps are looked for


def widest_step(sessions: Sequence[np.ndarray]) -> float | None:
    """The step of a channel (N,) in the sessions that show one, or None where none does. Each is asked by itself, for a tare moves all
    levels, and a rest visits only a few."""
    return max(filter(None, map(step_of, sessions)), default=None)


def step_of(y: np.ndarray) -> float | None:
    """The step between the levels of a channel (N,), or None where it has none."""
    some = y[:: -(-y.size // PROBES)]
    levels = np.unique(some)
    if not LEVELS <= levels.size <= 0.5 * some.size:
        return None
    apart = np.diff(levels)
    apart = apart[apart > 1e-6 * np.ptp(levels)]
    if apart.size < LEVELS - 1:
        return None
    step = float(np.median(apart))
    whole = np.rint(apart / step)
    fits = (whole > 0) & (np.abs(apart / step - whole) < 0.02)
    return float(np.mean(apart[fits] / whole[fits])) if fits.mean() >= ON_GRID else None


def noise_of(variance: float, step: float) -> float:
    """Standard deviation of the noise before the converter, from the variance of the residual of its readings."""
    return float(np.sqrt(max(0.0, variance - (1.0 + UNSURE) * step**2 / 12.0)))


def amplitudes(step: float, sigma: float) -> np.ndarray:
    """c_1, c_2, …: the amplitudes of the mean error's harmonics for noise of standard deviation `sigma`, in the unit of the step."""
    k = np.arange(1, HARMONICS + 1)
    c = step / (np.pi * k) * np.exp(-2.0 * (np.pi * k * sigma / step) ** 2)
    return c[c > SMALL * step]


def covariance_of_steps(
    gains: Sequence[np.ndarray], values: Sequence[np.ndarray], variance: float, step: float
) -> tuple[np.ndarray | float, float]:
    """Covariance (P, P) of one channel's coefficients due to its steps, and the share of the residual's variance that is noise.

    Per session: gains (N, P), the change of the coefficients per sample; values (N,), the channel without noise. `variance` is that of the
    residual, steps and noise together.
    """
    c = amplitudes(step, noise_of(variance, step))
    total: np.ndarray | float = 0.0
    turns = [np.exp(2j * np.pi * y / step) for y in values]
    now = [np.ones_like(turn) for turn in turns]
    for amplitude in c:
        now = [a * b for a, b in zip(now, turns, strict=True)]
        z = sum(g.T @ a for g, a in zip(gains, now, strict=True))
        total = total + 0.5 * amplitude**2 * np.outer(z, z.conj()).real
    return total, float(np.clip(1.0 - 0.5 * np.sum(c**2) / variance, 0.0, 1.0)) if variance > 0.0 else 1.0
