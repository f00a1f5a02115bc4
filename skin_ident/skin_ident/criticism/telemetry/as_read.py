"""A channel of a session as it was read: at the instants of its own readings, where its topic came at other ones than the recording's.

A spike of a reading, or one that was sent twice, is a hump or a slope between the recording's instants: what single readings tell is looked
for among these, and what is found is marked on the recording's samples that hang on it.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.recordings.readings import Readings
from skin_ident.stretches import without


@dataclass(frozen=True)
class AsRead:
    """What a model leaves, e (M,), of readings y (M,), N, and where a force may really jump, `jumps` (M,): at instants that are its `own`
    beside the recording's t (N,), or at those."""

    e: np.ndarray
    y: np.ndarray
    jumps: np.ndarray
    t: np.ndarray | None = None
    own: Readings | None = None

    def on_grid(self, mask: np.ndarray) -> np.ndarray:
        """Mask (N,) of the recording's samples that hang on readings of the `mask` (M,)."""
        return mask if self.own is None else self.own.spanned(mask, self.t)

    def beside(self, on_grid: np.ndarray) -> np.ndarray:
        """Mask (M,) of the readings nearest to which the recording's samples are in a mask (N,)."""
        return on_grid if self.own is None else on_grid[nearest_samples(self.own, self.t)]

    def kept(self, mask: np.ndarray, on_grid: np.ndarray) -> np.ndarray:
        """The runs of readings of the `mask` (M,) of which the recording's samples, or some, are among those of another mask (N,)."""
        if self.own is None:
            return mask & on_grid
        return without(mask, lambda a, b: not on_grid[self.own.span(a, b, self.t)].any())


def as_read(e: np.ndarray, y: np.ndarray, jumps: np.ndarray, t: np.ndarray | None = None, own: Readings | None = None) -> AsRead:
    """A channel that is e, y and jumps (N,) at the recording's instants t, with its `own` readings, if any. Where a model has been
    put in the place of samples, so that nothing is left of them, it is in that of the readings beside them."""
    if own is None:
        return AsRead(e, y, jumps)
    beside = nearest_samples(own, t)
    model = np.interp(own.t, t, y - e)
    left = np.where(e[beside] == 0.0, 0.0, own.y - model)
    return AsRead(left, model + left, own.ringing(jumps, t[1] - t[0])[beside], t, own)


def nearest_samples(own: Readings, t: np.ndarray) -> np.ndarray:
    """Which of the instants t (N,) is nearest to each reading, (M,)."""
    return np.searchsorted(0.5 * (t[1:] + t[:-1]), own.t)


def calm_lines(channel: str, row: int, recordings: list, residuals: list[np.ndarray], calm: list[np.ndarray]) -> list[AsRead]:
    """A channel as every recording read it, where that is `row` of residuals (C, N): `jumps` is where it is not `calm` (N,)."""
    every = zip(recordings, residuals, calm, strict=True)
    return [as_read(e[row], r.channels[channel], ~still, r.t, r.own(channel)) for r, e, still in every]
