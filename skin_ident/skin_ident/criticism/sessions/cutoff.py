"""The cut-off of a comparison: above it an encoder's steps and noise would be too large a part of the motion.

Steps q, and white noise as strong as that of such steps, leave an error of spectral density q^2 dt / 6 in the depth, and of (2 pi f)^2
times that in its speed. A fit takes both for motion, and underestimates the damping by the share that the errors have of the fitted signal
(errors in variables: W. A. Fuller, Measurement Error Models, 1987, ch. 1). Under wandering noise a whitened fit weighs the squared speed by
another f^2, so that the share is

    q^2 dt / 6 * fc^5 / 5  /  int_0^fc f^4 S_x df,

with S_x the spectral density of the depth in contact. A quick motion allows the whole band. A slow one that is read coarsely says nothing
about high frequencies, and its comparison ends where this share reaches its limit.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.sessions.band import CUTOFF_HZ
from skin_ident.estimators.scale import white_noise
from skin_ident.recordings.staircase import drawn_again
from skin_ident.stretches import runs

SHARE = 0.02  # largest share of encoder errors in the motion, by the integral of f^4 S over the band
LOWEST_HZ = 2.0  # lowest cut-off, however coarse the encoder is
FEWEST = 250  # samples that the band must keep of the shortest recording, at three times its cut-off
EDGES = CUTOFF_HZ * (LOWEST_HZ / CUTOFF_HZ) ** np.linspace(0.0, 1.0, 9)  # candidates for the cut-off, Hz
SHORTEST_S = 1.0  # s, shortest contact whose motion counts


@dataclass(frozen=True)
class Common:
    """What compared recordings share: the longest sampling period of any channel, `slowest` s, the `cutoff` of the band, Hz, and the
    longest period of any recording, `rarest` s."""

    slowest: float = 0.0
    cutoff: float = CUTOFF_HZ
    rarest: float = 0.0


ALONE = Common()


def common_to(recordings: list, step: float) -> Common:
    """The common period and cut-off of recordings whose depth is read in steps of `step` m, with noise besides."""
    return Common(max(r.longest_period for r in recordings), cutoff_for(recordings, step), max(r.dt for r in recordings))


def cutoff_for(recordings: list, step: float) -> float:
    """The cut-off, Hz, of the common band for recordings whose depth is read in steps of `step` m, with noise besides. It is `CUTOFF_HZ`
    where any recording has no depth."""
    if any(r.depth is None for r in recordings):
        return CUTOFF_HZ
    each = [_jerked(r.depth, r.dt, np.hypot(step, np.sqrt(12.0) * beside_rounding(r)), EDGES) for r in recordings]
    motion, errors = np.sum(each, axis=0)
    if not motion.any():
        return CUTOFF_HZ
    lowest = max(LOWEST_HZ, FEWEST / (3.0 * min(r.t[-1] - r.t[0] for r in recordings)))
    return float(min(CUTOFF_HZ, max([lowest, *EDGES[errors <= SHARE * motion]])))


def dilution(sessions: list) -> float:
    """The share of the encoder's white noise in the signal to which damping is fitted in `sessions`; damping is underestimated by this
    share."""
    noise = [np.sqrt(12.0) * s.depth_noise for s in sessions]
    each = [_jerked(s.motion.x, s.motion.dt, q, np.array([s.band.edge]), s.period) for q, s in zip(noise, sessions, strict=True)]
    motion, errors = np.sum(each, axis=0)
    return float(errors[0] / max(motion[0], 1e-300)) if errors[0] > 0.0 else 0.0


def _jerked(x: np.ndarray, dt: float, step: float, edges: np.ndarray, period: float | None = None) -> np.ndarray:
    """int f^4 S df from 0 to each of the `edges`, (2, E), of a depth x (N,) in contact: of the motion, and of the errors of steps `step`
    read every `period` (default `dt`) s."""
    density, out = step**2 * (period or dt) / 6.0, np.zeros((2, edges.size))
    for begin, end in zip(*runs(x > 0.0), strict=True):
        seconds = (end - begin) * dt
        if seconds >= SHORTEST_S:
            f, power = _spectrum(drawn_again(x[begin:end]), dt)
            motion = np.cumsum(f**4 * np.maximum(power - density, 0.0)) * f[1]
            out += seconds * np.array([np.interp(edges, f, motion), density * edges**5 / 5.0])
    return out


def beside_rounding(recording) -> float:
    """White noise of the depth beyond the rounding to its steps, m rms."""
    return float(np.sqrt(max(white_noise(recording.depth) ** 2 - (recording.step("depth") or 0.0) ** 2 / 12.0, 0.0)))


def _spectrum(x: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies, Hz, and the one-sided spectral density of x (N,), in its unit squared per Hz."""
    window = np.hanning(x.size)
    return np.fft.rfftfreq(x.size, dt), 2.0 * dt * np.abs(np.fft.rfft(window * (x - x.mean()))) ** 2 / np.sum(window**2)
