"""The slow part of a noise: what is left of it when readings are averaged over a fifth of a second.

Averages m of n samples of white noise of variance s^2 have the variance s^2 / n. Where a noise w wanders beside it,

    var m = var w + s^2 / n,      cov(m_k, m_k+1) = exp(-T / tau) var w,

with T between the averages and w an autoregressive noise of time constant tau, slow beside T.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skin_ident.stretches import runs

AVERAGED_S = 0.2  # s, of one average
FEWEST = 30  # averages for a verdict
SHORTEST, LONGEST = 0.1, 20.0  # averages, of a time constant that they can show


@dataclass(frozen=True)
class SlowPart:
    """Root mean square `rms` of the slow part, and that of the rest, `quick`, in the unit of the noise; its time constant `tau`, s."""

    rms: float
    quick: float
    tau: float


def slow_part(rows: Sequence[np.ndarray], used: Sequence[np.ndarray], period: float) -> SlowPart | None:
    """The slow part of the noise in `rows` (N,), one for each session, at the samples in the masks `used` (N,); None where they hold too
    few averages."""
    n = max(round(AVERAGED_S / period), 2)
    stretches = [row[a:b] for row, mask in zip(rows, used, strict=True) for a, b in zip(*runs(mask), strict=True)]
    blocks = [s[: s.size // n * n].reshape(-1, n) for s in stretches if s.size >= n]
    if sum(map(len, blocks)) < FEWEST:
        return None
    quick = float(np.mean(np.var(np.concatenate(blocks), axis=1, ddof=1)))
    means = [b.mean(axis=1) for b in blocks]
    slow = float(np.mean(np.concatenate(means) ** 2)) - quick / n
    beside = np.concatenate([m[1:] * m[:-1] for m in means])
    alike = float(np.mean(beside)) / slow if slow > 0.0 and beside.size else 0.0
    tau = -n * period / np.log(np.clip(alike, np.exp(-1.0 / SHORTEST), np.exp(-1.0 / LONGEST)))
    return SlowPart(float(np.sqrt(max(slow, 0.0))), float(np.sqrt(quick)), float(tau))
