"""Which candidates are new: a motion that was recorded and did not tell the rivals apart will not do so when it is recorded again."""

import numpy as np

from skin_ident.criticism.sessions.session import Session
from skin_ident.separating.candidates import Candidate, candidates
from skin_models.signals import Motion

DRAWS = 4  # seeds of random motions that are tried until one was not recorded yet
SAME = 0.1  # a motion counts as recorded if the rms difference is below this share of its own standard deviation
FEWEST = 20  # samples under load; motions with fewer are taken as not recorded


def unrecorded(deepest: float, dt: float, sessions: list[Session]) -> list[Candidate]:
    """Every candidate (see `candidates`) whose motion under load is in no session. Random motions that were recorded are drawn again."""
    found: dict[str, Candidate] = {}
    for seed in range(DRAWS):
        missing = [k for k in candidates(deepest, dt, seed) if k.name not in found]
        found |= {k.name: k for k in missing if not any(holds(s.motion, k.motion) for s in sessions)}
        if all(k.name in found for k in missing):
            break
    return list(found.values())


def holds(recorded: Motion, motion: Motion) -> bool:
    """Whether a recorded motion contains, at any time, what `motion` does between its first and its last sample under load. A constant
    difference of depth is ignored, because the recorded and the commanded motion may have different zeros."""
    under = np.flatnonzero(motion.x > 0.0)
    if under.size < FEWEST:
        return False
    wanted = motion.x[under[0] : under[-1] + 1]
    t = np.arange(recorded.t[0], recorded.t[-1], motion.dt)
    if t.size < wanted.size:
        return False
    return _least_difference(np.interp(t, recorded.t, recorded.x), wanted) < SAME**2 * float(np.var(wanted))


def _least_difference(x: np.ndarray, wanted: np.ndarray) -> float:
    """The smallest variance of x - wanted over all shifts of `wanted` along `x`."""
    n, wanted = wanted.size, wanted - wanted.mean()
    total, squares = (np.concatenate([[0.0], np.cumsum(y)]) for y in (x, x**2))
    mean, square = ((y[n:] - y[:-n]) / n for y in (total, squares))
    size = 1 << int(x.size - 1).bit_length()
    matched = np.fft.irfft(np.fft.rfft(x, 2 * size) * np.conj(np.fft.rfft(wanted, 2 * size)), 2 * size)[: mean.size] / n
    return float(np.min(square - mean**2 + np.var(wanted) - 2.0 * matched))
