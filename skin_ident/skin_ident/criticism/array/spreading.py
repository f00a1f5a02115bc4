"""Sessions that press at different places: each carries its own share of every taxel, so that one model can be fitted to all.

A share is a slope over the record. A taxel that dies part-way, or comes and goes, has too small a slope over the whole record. The
session's shares would then be wrong by different factors, and the search would name a gain error or worse. So where samples are ruled out
the slopes are computed again from the trusted samples.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.array.layout import Layout


def with_spread(recordings: list, layout: Layout | str) -> list:
    """The recordings with `spread` set if they press at different places: slope of every taxel on depth (on force, where that drives the
    test) over the largest slope of all. A zero per taxel and recording is fitted too, since it would be taken for a slope of a taxel that
    is hardly loaded."""
    if isinstance(layout, str) or not layout.several_contacts:
        return recordings
    slopes = np.array([np.linalg.lstsq(beside_zero(r), r.taxels.T, rcond=None)[0][0] for r in recordings])
    return _spread(recordings, slopes, slopes.max())


def with_believed_spread(recordings: list, bad: list[np.ndarray]) -> list:
    """The recordings with `spread` computed again without the samples that `bad` rules out; `bad` are masks (C, N) whose last rows are the
    taxels. 0 where a taxel has no trusted sample. Recordings without a spread, or without bad samples, are returned unchanged."""
    masks = [b[-len(r.taxels) :] for r, b in zip(recordings, bad, strict=True)]
    if any(r.spread is None for r in recordings) or not any(m.any() for m in masks):
        return recordings
    slopes = np.array([_slopes(r, ~m) for r, m in zip(recordings, masks, strict=True)])
    unit = _unit(slopes, np.array([r.spread for r in recordings]), np.array([m.any(axis=1) for m in masks]))
    return _spread(recordings, slopes, unit) if unit > 0.0 else recordings


def beside_zero(recording) -> np.ndarray:
    """Regressors of the taxels and a column of ones for their zero: depth and speed in contact, (N, 3), or force, (N, 2), where that drives
    the test. The elastic slope is that on the first column."""
    if recording.depth is None:
        return np.column_stack([recording.force, np.ones(recording.force.size)])
    x = recording.depth
    touched = (x > 0.0)[:, None]
    return np.hstack([np.column_stack([x, np.gradient(x, recording.dt)]) * touched, np.ones((x.size, 1))])


def _spread(recordings: list, slopes: np.ndarray, unit: float) -> list:
    return [replace(r, spread=row) for r, row in zip(recordings, np.maximum(slopes, 0.0) / unit, strict=True)]


def _slopes(recording, kept: np.ndarray) -> list[float]:
    """Elastic slope of every taxel over its samples in a mask (T, N), with a free zero."""
    H = beside_zero(recording)
    return [float(np.linalg.lstsq(H[k], y[k], rcond=None)[0][0]) if k.any() else 0.0 for y, k in zip(recording.taxels, kept, strict=True)]


def _unit(slopes: np.ndarray, spread: np.ndarray, touched: np.ndarray) -> float:
    """The slope that counts as share 1, derived from the largest share (S, T) in which nothing was ruled out; else the largest slope.

    It is taken over from the old shares because these recordings may hold only some of the taxels.
    """
    whole = np.where(touched, 0.0, spread)
    if whole.max() <= 0.0:
        return float(slopes.max())
    at = np.unravel_index(np.argmax(whole), whole.shape)
    return float(slopes[at] / spread[at])
