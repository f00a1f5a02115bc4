"""A channel of a session at the times of its own readings, where its topic was recorded at other times than the recording's.

Interpolated to the recording's times, a spike or a reading that was sent twice becomes a hump or a slope. So faults of single readings are
looked for among the readings, and what is found is marked on the recording's samples that depend on them.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.recordings.readings import Readings
from skin_ident.stretches import without


@dataclass(frozen=True)
class AsRead:
    """Residual e (M,), N, of readings y (M,), N, and a mask `jumps` (M,) of where a force may really jump. M counts the channel's `own`
    readings beside the recording's times t (N,), or, without those, the recording's samples."""

    e: np.ndarray
    y: np.ndarray
    jumps: np.ndarray
    t: np.ndarray | None = None
    own: Readings | None = None

    def on_grid(self, mask: np.ndarray) -> np.ndarray:
        """Mask (N,) of the recording's samples that depend on the readings in `mask` (M,)."""
        return mask if self.own is None else self.own.spanned(mask, self.t)

    def beside(self, on_grid: np.ndarray) -> np.ndarray:
        """Mask (M,) of the readings whose nearest sample of the recording is in `on_grid` (N,)."""
        return on_grid if self.own is None else on_grid[nearest_samples(self.own, self.t)]

    def kept(self, mask: np.ndarray, on_grid: np.ndarray) -> np.ndarray:
        """Mask (M,) of the runs of readings in `mask` (M,) that overlap the recording's samples in `on_grid` (N,)."""
        if self.own is None:
            return mask & on_grid
        return without(mask, lambda a, b: not on_grid[self.own.span(a, b, self.t)].any())


def as_read(e: np.ndarray, y: np.ndarray, jumps: np.ndarray, t: np.ndarray | None = None, own: Readings | None = None) -> AsRead:
    """A channel with residual e, measurement y and jumps (N,) at the recording's times t, and its `own` readings, if any. Where e is zero
    because samples were replaced by the model, the readings beside them are replaced by it, too."""
    if own is None:
        return AsRead(e, y, jumps)
    beside = nearest_samples(own, t)
    model = np.interp(own.t, t, y - e)
    left = np.where(e[beside] == 0.0, 0.0, own.y - model)
    return AsRead(left, model + left, own.ringing(jumps, t[1] - t[0])[beside], t, own)


def nearest_samples(own: Readings, t: np.ndarray) -> np.ndarray:
    """Index of the time in t (N,) that is nearest to each reading, (M,)."""
    return np.searchsorted(0.5 * (t[1:] + t[:-1]), own.t)


def calm_lines(channel: str, row: int, recordings: list, residuals: list[np.ndarray], calm: list[np.ndarray]) -> list[AsRead]:
    """A channel, `row` of the residuals (C, N), as every recording read it; `jumps` is where it is not `calm` (N,)."""
    every = zip(recordings, residuals, calm, strict=True)
    return [as_read(e[row], r.channels[channel], ~still, r.t, r.own(channel)) for r, e, still in every]
