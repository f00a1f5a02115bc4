"""How far up in frequency a comparison may go: where an encoder's steps would be more of the motion than the motion itself.

The steps q leave an error of density q^2 dt / 6 in the depth, and of (2 pi f)^2 times that in its speed. A fit takes both for motion, and
finds damping too small by the share that they have of what it fits (errors in variables: W. A. Fuller, Measurement Error Models, 1987,
ch. 1). Under noise that wanders a whitened fit weighs the squared speed by f^2 once more, so that the share is

    q^2 dt / 6 * fc^5 / 5  /  int_0^fc f^4 S_x df,

with S_x the spectral density of the depth while there is contact. A quick motion bears the whole band; a slow one that is read coarsely
says nothing of what is quick, and its comparison ends where the share does.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.sessions.band import CUTOFF_HZ
from skin_ident.recordings.staircase import drawn_again
from skin_ident.stretches import runs

SHARE = 0.02
LOWEST_HZ = 2.0
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
    """For recordings whose depth is read in steps of `step` m."""
    return Common(max(r.longest_period for r in recordings), cutoff_for(recordings, step))


def cutoff_for(recordings: list, step: float) -> float:
    """The cut-off, Hz, of the common band for recordings whose depth is read in steps of `step` m."""
    if step <= 0.0 or any(r.depth is None for r in recordings):
        return CUTOFF_HZ
    motion, errors = np.zeros(EDGES.size), np.zeros(EDGES.size)
    for r in recordings:
        for begin, end in zip(*runs(r.depth > 0.0), strict=True):
            seconds = (end - begin) * r.dt
            if seconds >= SHORTEST_S:
                f, power = _spectrum(drawn_again(r.depth[begin:end]), r.dt)
                jerked = np.cumsum(f**4 * np.maximum(power - step**2 * r.dt / 6.0, 0.0)) * f[1]
                motion += seconds * np.interp(EDGES, f, jerked)
                errors += seconds * step**2 * r.dt / 30.0 * EDGES**5
    if not motion.any():
        return CUTOFF_HZ
    lowest = max(LOWEST_HZ, FEWEST / (3.0 * min(r.t[-1] - r.t[0] for r in recordings)))
    return float(min(CUTOFF_HZ, max([lowest, *EDGES[errors <= SHARE * motion]])))


def _spectrum(x: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies, Hz, and the one-sided spectral density of x (N,), in its unit squared per Hz."""
    window = np.hanning(x.size)
    return np.fft.rfftfreq(x.size, dt), 2.0 * dt * np.abs(np.fft.rfft(window * (x - x.mean()))) ** 2 / np.sum(window**2)
