"""Interference that comes and goes: how large it is while present, and for what share of the time.

The residual within `WIDTH_HZ` of the line has the envelope a(t). A steady line has mean(a^4) = mean(a^2)^2, noise twice that, and a line
that is present for a share s of the time 1 / s. Beyond `COMING` the line comes in bursts, and their amplitude is the envelope's `REACHED`
percentile.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.telemetry.symptom import Symptom, quantity

WIDTH_HZ = 1.5  # Hz to either side of the line that make its envelope
COMING = 4.0  # mean(a^4) / mean(a^2)^2 of bursts, twice that of noise
THERE = 0.5  # share of the bursts' amplitude from which the line is present
REACHED = 99.0  # percentile of the envelope that counts as its amplitude in bursts


def told_of_bursts(symptom: Symptom, recordings: list, channels: tuple[str, ...], rests: list[np.ndarray]) -> Symptom:
    """The symptom, with the size and share of the bursts added where its line comes in bursts in every recording that has it; else
    unchanged. `rests` (C, N) N are measured less simulated, at full rate."""
    if symptom.cause != "interference" or symptom.channels[0] not in channels or "frequency" not in symptom.parameters:
        return symptom
    row, frequency = channels.index(symptom.channels[0]), symptom.parameters["frequency"]["value"]
    there = symptom.evidence.get("only_in", [r.name for r in recordings])
    seen = [_bursts(e[row], frequency, r.dt) for e, r in zip(rests, recordings, strict=True) if r.name in there]
    if any(s is None for s in seen):
        return symptom
    size, share = (float(np.median(q)) for q in zip(*seen, strict=True))
    why = f"{symptom.evidence['why']}; it comes in bursts of about {size:.2g} N, {100.0 * share:.0f} % of the time"
    return replace(symptom, parameters={**symptom.parameters, "in_bursts": quantity(size, "N")}, evidence={**symptom.evidence, "why": why})


def envelope(e: np.ndarray, frequency: float, dt: float, width: float = WIDTH_HZ) -> np.ndarray:
    """Envelope a(t) of e (N,): the amplitude of its part within `width` (Hz) of a frequency."""
    at = np.fft.fftfreq(e.size, dt)
    return 2.0 * np.abs(np.fft.ifft(np.fft.fft(e - e.mean()) * (np.abs(at - frequency) < width)))


def coming(a: np.ndarray) -> float:
    """mean(a^4) / mean(a^2)^2 of an envelope (N,)."""
    return float(np.mean(a**4) / max(np.mean(a**2) ** 2, 1e-300))


def _bursts(e: np.ndarray, frequency: float, dt: float) -> tuple[float, float] | None:
    """Amplitude of the bursts, N, and their share of the time; None for a line that is always present."""
    a = envelope(e, frequency, dt)
    if coming(a) < COMING:
        return None
    size = float(np.percentile(a, REACHED))
    return size, float(np.mean(a > THERE * size))
