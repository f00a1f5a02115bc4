"""Clipped peaks: pieces of a record that all lie at its greatest readings, on one level, below the model.

A converter or an amplifier that clips before noise is added leaves no pile of samples at one value. If only a few quick peaks are clipped,
it leaves a few short pieces. Accidents do not occur at the greatest loads alone, nor end at one level.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of

NOISE = 4.0  # noise widths of the residual: between the levels of pieces, about the level, and (twice) of any other reading above it
INSIDE = 0.25  # share of a piece at either end where the reading may still be moving

LASTING_S = 0.1  # s, window in which most samples of a piece are far off


@dataclass(frozen=True)
class Piece:
    """A run of samples of one channel of one session."""

    session: str
    channel: str
    start: float
    seconds: float
    size: float  # N
    met: bool  # whether contact is made or lost there, or a mass is jolted


def samples_of(own: list[Piece], s: Session) -> np.ndarray:
    """Mask (N,) of the samples of a session's pieces, and of those within `LASTING_S` of them, which a window may have missed."""
    t, mine = s.motion.t, [p for p in own if p.session == s.name]
    return np.any([np.zeros(t.size, bool), *((t > p.start - LASTING_S) & (t < p.start + p.seconds + LASTING_S) for p in mine)], axis=0)


def pieces_in_words(own: list[Piece]) -> str:
    """The first few of the pieces, in words."""
    return ", ".join(f"{p.session} at {p.start:.1f} s for {p.seconds:.2g} s" for p in own[:4]) + (", …" if len(own) > 4 else "")


def clipped_peaks(own: list[Piece], sessions: list[Session], rest: list[np.ndarray], width: np.ndarray) -> Symptom | None:
    """The pieces of one channel as saturation, with outliers as an alternative that looks the same; None where they do not look like
    saturation.

    `rest` are measured less simulated rows (C, N) of each session at full rate, `width` (C, 1) N the noise width of each channel's
    residual.
    """
    channel = own[0].channel
    c = sessions[0].channels.index(channel)
    noise, at = float(width[c, 0]), {s.name: (s.motion.t, s.raw[c], s.raw[c] - e[c]) for s, e in zip(sessions, rest, strict=True)}
    inside = [[row[_within(at[p.session][0], p)] for row in at[p.session][1:]] for p in own]
    levels = np.array([np.median(y) for y, _ in inside])
    level = float(np.median(levels))
    steady = all(np.median(np.abs(y - level)) < NOISE * noise for y, _ in inside)
    below = all(np.all(simulated > level) for _, simulated in inside)
    highest = max(float(y.max()) for _, y, _ in at.values())
    if not steady or not below or np.ptp(levels) > NOISE * noise or highest > level + 2.0 * NOISE * noise:
        return None
    bad = {(name, channel): simulated > level for name, (_, _, simulated) in at.items() if np.any(simulated > level)}
    where = sensor_of(channel, sessions[0].n_taxels)
    seconds, beyond = max(p.seconds for p in own), max(p.size for p in own)
    why = (
        f"{channel} stays at {level:.4g} N, its greatest reading, in {len(own)} peaks of up to {seconds:.2g} s, while the other "
        f"channels say that it should rise further, by up to {beyond:.3g} N"
    )
    evidence = {"why": why, "pieces": [{"session": p.session, "start": p.start, "seconds": float(p.seconds)} for p in own]}
    parameters = {"level": quantity(level, "N")}
    return Symptom("saturation", where, (channel,), parameters, evidence, bad, (("outliers", where),), "press beyond this level and hold")


def _within(t: np.ndarray, p: Piece) -> np.ndarray:
    """Mask (N,) of the middle of a piece."""
    middle, half = p.start + 0.5 * p.seconds, (0.5 - INSIDE) * p.seconds
    return np.abs(t - middle) <= max(half, 0.5 * (t[1] - t[0]))
