"""Interference: a line in the residual's spectrum, at full rate, at the same frequency in every session.

Each residual's periodogram is divided by its own smooth background (a running median); a line stands where the mean over sessions of the
normalised power is beyond what exponential statistics allow (R. A. Fisher, Tests of significance in harmonic analysis, 1929).
"""

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter

from skin_ident.criticism.telemetry.symptom import Symptom, place_of, quantity

CHANCE = 1e-4  # of one false line per channel
DRIFT = 5  # bins by which a line may differ from session to session
LOWEST_HZ = 1.0  # below, the motion itself leaves lines in a residual
AROUND, LONELY = 30, 0.15  # a line that comes in bursts has sidebands; within so many bins the median must stay below this share of it
TALL = 20.0  # times its background, where a motion has a line of its own
BY_DEPTH = 0.4  # of a line that the simulation may carry


def find_interference(
    channels: tuple[str, ...], residuals: list[np.ndarray], predicted: list[np.ndarray], dt: float, n_taxels: int
) -> list[Symptom]:
    """Periodic disturbances per channel, from residuals (C, N) at full rate.

    A line that the simulation carries as well came in by the depth: a harmonic of a periodic motion, or the steps of a coarse encoder at
    constant speed.
    """
    n = min(e.shape[1] for e in residuals)
    frequency = np.fft.rfftfreq(n, dt)
    found = []
    for c, channel in enumerate(channels):
        rows = [_over_background(e[c][:n]) for e in residuals]
        width = np.mean(rows, axis=0)
        ratio = np.median([maximum_filter1d(row, DRIFT) for row in rows], axis=0) if len(rows) > 2 else np.min(rows, axis=0)
        ratio[(frequency < LOWEST_HZ) | (frequency > frequency[-1] - 2.0 / (n * dt))] = 0.0
        limit = 1.0 - np.log(CHANCE / n) / len(residuals) if len(residuals) > 1 else -np.log(CHANCE / n)
        i = int(np.argmax(ratio))
        i += int(np.argmax(width[i : i + DRIFT]))
        around = np.median(width[max(i - AROUND, 0) : i + AROUND + 1])
        if ratio.max() > 3.0 * limit and around < LONELY * ratio.max():
            amplitude = _amplitude([e[c] for e in residuals], frequency[i], dt)
            if _amplitude([m[c] for m in predicted], frequency[i], dt) > BY_DEPTH * amplitude or _stands([m[c][:n] for m in predicted], i):
                continue
            line = f"a line at {frequency[i]:.3g} Hz stands {ratio.max():.0f} times over the background of {channel}"
            why = f"{line} in {len(residuals)} session{'s' * (len(residuals) > 1)}"
            parameters = {"frequency": quantity(frequency[i], "Hz"), "amplitude": quantity(amplitude, "N")}
            found.append(Symptom("interference", place_of(channel, n_taxels), (channel,), parameters, {"why": why}))
    return found


def _stands(rows: list[np.ndarray], i: int) -> bool:
    """Whether there is a line within a bin of `i` in most of these rows."""
    tall = [np.max(_over_background(row)[max(i - 1, 0) : i + 2]) for row in rows]
    return float(np.median(tall)) > TALL


def _over_background(e: np.ndarray) -> np.ndarray:
    n = e.size
    power = np.abs(np.fft.rfft((e - e.mean()) * np.hanning(n))) ** 2
    return power / np.maximum(median_filter(power, 101) / np.log(2.0), 1e-300)


def _amplitude(rows: list[np.ndarray], frequency: float, dt: float) -> float:
    def of(e: np.ndarray) -> float:
        turn = np.exp(-2j * np.pi * frequency * dt * np.arange(e.size)) * np.hanning(e.size)
        return 4.0 * abs(np.mean((e - e.mean()) * turn))

    return float(np.median([of(e) for e in rows]))
