"""Errors that repeat with the motion: under a slow sine, the steps of a converter make the same error in every period.

Such an error does not average out over periods. A noise model that is smooth in frequency misses it, because its power is at the harmonics
of the motion. The power at the second to ninth harmonic, relative to the noise model, tells how much there is at the first harmonic, where
the fit has absorbed it.
"""

from collections.abc import Sequence

import numpy as np

HARMONICS = range(2, 10)
NEAR = 2  # bins to either side of a line that count with it, for motions that are no whole number of periods
ALONE = 0.5  # least share of the motion's power in its strongest line; with less, the motion is not periodic
CHANCE = 2.6  # a smaller ratio may be chance: harmonics of white noise can look as strong


def inflation(residuals: Sequence[np.ndarray], gains: Sequence[np.ndarray], ar: np.ndarray, std: float) -> float:
    """The factor by which the variance of the coefficients grows (1: not at all).

    `residuals` (n,) and `gains` (n, P), the change of each coefficient per sample, are per session; `ar` and `std` are the noise model.
    """
    found = [_excess(e, g, ar, std) for e, g in zip(residuals, gains, strict=True)]
    found = [x for x in found if x is not None]
    excess = float(np.mean(found)) if found else 1.0
    return excess if excess > CHANCE else 1.0


def _excess(e: np.ndarray, gain: np.ndarray, ar: np.ndarray, std: float) -> float | None:
    line = _line(gain)
    if line is None or std <= 0.0:
        return None
    power = np.abs(np.fft.rfft(e)) ** 2 / e.size
    wide = 2 * NEAR + 1
    at = [round(h * line) for h in HARMONICS if h * line + NEAR < power.size]
    if not at:
        return None
    omega = 2 * np.pi * np.array(at) / e.size
    expected = std**2 / np.abs(1.0 - np.exp(-1j * np.outer(omega, np.arange(1, ar.size + 1))) @ ar) ** 2
    seen = np.array([power[k - NEAR : k + NEAR + 1].sum() for k in at])
    return float(np.mean(seen / expected)) - (wide - 1)


def _line(gain: np.ndarray) -> float | None:
    """The (fractional) frequency bin of the motion's strongest line; None where its power is spread out."""
    scaled = gain / np.maximum(np.sqrt(np.sum(gain**2, axis=0)), 1e-300)
    power = np.sum(np.abs(np.fft.rfft(scaled - scaled.mean(axis=0), axis=0)) ** 2, axis=1)
    k = int(np.argmax(power))
    near = slice(max(1, k - NEAR), k + NEAR + 1)
    if k <= NEAR or power[near].sum() < ALONE * power.sum():
        return None
    return float(np.sum(np.arange(near.start, near.start + power[near].size) * power[near]) / power[near].sum())
