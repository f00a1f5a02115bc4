"""How far up in frequency a comparison may go: where an encoder's steps and noise would be more of the motion than the motion itself.

The steps q, and white noise as loud as that of such steps, leave an error of density q^2 dt / 6 in the depth, and of (2 pi f)^2 times that
in its speed. A fit takes both for motion, and finds damping too small by the share that they have of what it fits (errors in variables:
W. A. Fuller, Measurement Error Models, 1987, ch. 1). Under noise that wanders a whitened fit weighs the squared speed by f^2 once more, so
that the share is

    q^2 dt / 6 * fc^5 / 5  /  int_0^fc f^4 S_x df,

with S_x the spectral density of the depth while there is contact. A quick motion bears the whole band; a slow one that is read coarsely
says nothing of what is quick, and its comparison ends where the share does.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.sessions.band import CUTOFF_HZ
from skin_ident.estimators.scale import white_noise
from skin_ident.recordings.staircase import drawn_again
from skin_ident.stretches import runs

SHARE = 0.02  # of the motion, by the integral of f^4 S over the band, the most that steps and noise of the depth may be
LOWEST_HZ = 2.0  # of any band, however coarse the encoder is
FEWEST = 250  # samples that the band keeps of the shortest recording, at three times its cut-off
EDGES = CUTOFF_HZ * (LOWEST_HZ / CUTOFF_HZ) ** np.linspace(0.0, 1.0, 9)
SHORTEST_S = 1.0  # a time of contact that counts


@dataclass(frozen=True)
class Common:
    """What the bands of recordings that are compared share: the longest period, s, at which any channel was read, and the cut-off, Hz."""

    slowest: float = 0.0
    cutoff: float = CUTOFF_HZ


ALONE = Common()


def common_to(recordings: list, step: float) -> Common:
    """For recordings whose depth is read in steps of `step` m, and noise besides."""
    return Common(max(r.longest_period for r in recordings), cutoff_for(recordings, step))


def cutoff_for(recordings: list, step: float) -> float:
    """The cut-off, Hz, of the common band for recordings whose depth is read in steps of `step` m, and noise besides."""
    if any(r.depth is None for r in recordings):
        return CUTOFF_HZ
    each = [_jerked(r.depth, r.dt, np.hypot(step, np.sqrt(12.0) * beside_rounding(r)), EDGES) for r in recordings]
    motion, errors = np.sum(each, axis=0)
    if not motion.any():
        return CUTOFF_HZ
    lowest = max(LOWEST_HZ, FEWEST / (3.0 * min(r.t[-1] - r.t[0] for r in recordings)))
    return float(min(CUTOFF_HZ, max([lowest, *EDGES[errors <= SHARE * motion]])))


def dilution(sessions: list) -> float:
    """The share that white noise of the encoder has of what damping is fitted to in `sessions`: by as much it is found too small."""
    noise = [np.sqrt(12.0) * s.depth_noise for s in sessions]
    each = [_jerked(s.motion.x, s.motion.dt, q, np.array([s.band.edge]), s.period) for q, s in zip(noise, sessions, strict=True)]
    motion, errors = np.sum(each, axis=0)
    return float(errors[0] / max(motion[0], 1e-300)) if errors[0] > 0.0 else 0.0


def _jerked(x: np.ndarray, dt: float, step: float, edges: np.ndarray, period: float | None = None) -> np.ndarray:
    """Of a depth x (N,), read every `period` with errors as of steps, int f^4 S df from 0 to every edge, (2, E): of the motion in contact,
    and of the errors."""
    density, out = step**2 * (period or dt) / 6.0, np.zeros((2, edges.size))
    for begin, end in zip(*runs(x > 0.0), strict=True):
        seconds = (end - begin) * dt
        if seconds >= SHORTEST_S:
            f, power = _spectrum(drawn_again(x[begin:end]), dt)
            motion = np.cumsum(f**4 * np.maximum(power - density, 0.0)) * f[1]
            out += seconds * np.array([np.interp(edges, f, motion), density * edges**5 / 5.0])
    return out


def beside_rounding(recording) -> float:
    """The white noise of the depth beside that of rounding to its steps, m rms."""
    return float(np.sqrt(max(white_noise(recording.depth) ** 2 - (recording.step("depth") or 0.0) ** 2 / 12.0, 0.0)))


def _spectrum(x: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies, Hz, and the one-sided spectral density of x (N,), in its unit squared per Hz."""
    window = np.hanning(x.size)
    return np.fft.rfftfreq(x.size, dt), 2.0 * dt * np.abs(np.fft.rfft(window * (x - x.mean()))) ** 2 / np.sum(window**2)
