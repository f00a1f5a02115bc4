"""Interference: a line in the residual's spectrum, at full rate, at the same frequency in every session.

Each residual's periodogram is divided by its own smooth background (a running median); a line stands where the mean over sessions of the
normalised power is beyond what exponential statistics allow (R. A. Fisher, Tests of significance in harmonic analysis, 1929).
"""

import numpy as np
from scipy.ndimage import median_filter

from skin_ident.criticism.telemetry.symptom import Symptom, place_of, quantity

CHANCE = 1e-4  # of one false line per channel
LOWEST_HZ = 1.0  # below, the motion itself leaves lines in a residual
NARROW = 3  # bins that a line may be wide


def find_interference(channels: tuple[str, ...], residuals: list[np.ndarray], dt: float, n_taxels: int) -> list[Symptom]:
    """Periodic disturbances per channel, from residuals (C, N) at full rate."""
    n = min(e.shape[1] for e in residuals)
    frequency = np.fft.rfftfreq(n, dt)
    found = []
    for c, channel in enumerate(channels):
        ratio = np.mean([_over_background(e[c][:n]) for e in residuals], axis=0)
        ratio[(frequency < LOWEST_HZ) | (frequency > frequency[-1] - 2.0 / (n * dt))] = 0.0
        limit = 1.0 - np.log(CHANCE / n) / len(residuals) if len(residuals) > 1 else -np.log(CHANCE / n)
        i = int(np.argmax(ratio))
        if ratio[i] > 3.0 * limit and np.median(ratio[max(i - 12, 0) : i + 13]) < 0.05 * ratio[i]:
            amplitude = _amplitude([e[c] for e in residuals], frequency[i], dt)
            why = f"a line at {frequency[i]:.3g} Hz stands {ratio[i]:.0f} times over the background of {channel} in {len(residuals)} sessions"
            parameters = {"frequency": quantity(frequency[i], "Hz"), "amplitude": quantity(amplitude, "N")}
            found.append(Symptom("interference", place_of(channel, n_taxels), (channel,), parameters, {"why": why}))
    return found


def _over_background(e: np.ndarray) -> np.ndarray:
    n = e.size
    power = np.abs(np.fft.rfft((e - e.mean()) * np.hanning(n))) ** 2
    return power / np.maximum(median_filter(power, 101) / np.log(2.0), 1e-300)


def _amplitude(rows: list[np.ndarray], frequency: float, dt: float) -> float:
    def of(e: np.ndarray) -> float:
        turn = np.exp(-2j * np.pi * frequency * dt * np.arange(e.size)) * np.hanning(e.size)
        return 4.0 * abs(np.mean((e - e.mean()) * turn))

    return float(np.median([of(e) for e in rows]))
