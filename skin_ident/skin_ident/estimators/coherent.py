"""Errors that repeat with the motion: a converter's steps under a slow sine make the same error in every period.

Such an error does not average out over periods, and a noise model smooth in frequency does not see it: its power sits on the harmonics of
the motion. What lies on the second to ninth harmonic, over what the noise model expects there, tells how much sits on the first, which the
fit has absorbed.
"""

from collections.abc import Sequence

import numpy as np

HARMONICS = range(2, 10)
NEAR = 2  # bins to either side of a line, for motions of no whole number of periods
ALONE = 0.5  # least share of the motion's power on its strongest line
CHANCE = 2.6  # below this, the harmonics of white noise may look as strong


def inflation(residuals: Sequence[np.ndarray], gains: Sequence[np.ndarray], ar: np.ndarray, std: float) -> float:
    """By how much the variance of the coefficients grows (1: not at all).

    residuals: (n,) per session; gains: (n, P), how each coefficient depends on each sample; the noise model.
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
    """The bin, with a fraction, of the motion's strongest line; None where its power is spread out."""
    scaled = gain / np.maximum(np.sqrt(np.sum(gain**2, axis=0)), 1e-300)
    power = np.sum(np.abs(np.fft.rfft(scaled - scaled.mean(axis=0), axis=0)) ** 2, axis=1)
    k = int(np.argmax(power))
    near = slice(max(1, k - NEAR), k + NEAR + 1)
    if k <= NEAR or power[near].sum() < ALONE * power.sum():
        return None
    return float(np.sum(np.arange(near.start, near.start + power[near].size) * power[near]) / power[near].sum())
