"""The spread of sessions that press at different places, from the samples that may be believed.

What each session brings along as its share of every taxel (see `array.spreading`) is a slope over the whole record. A taxel that dies
part-way, or comes and goes, has a smaller slope there than its skin gives it: every session would then have a share that is wrong by
another factor, and the search would name a change of gain, or worse, for it.
"""

from dataclasses import replace

import numpy as np


def with_believed_spread(recordings: list, bad: list[np.ndarray]) -> list:
    """The recordings with their `spread` found again where `bad`, masks (C, N) whose last rows are the taxels', rules samples out.

    Slope of every taxel on depth, with speed beside it and in contact (on force, where that drives the test), over what it was over before;
    zero where a taxel has nothing to be believed. Recordings without a spread, or with nothing ruled out, come back as they are.
    """
    masks = [b[-len(r.taxels) :] for r, b in zip(recordings, bad, strict=True)]
    if any(r.spread is None for r in recordings) or not any(m.any() for m in masks):
        return recordings
    slopes = np.array([[_slope(r, y, ~b) for y, b in zip(r.taxels, m, strict=True)] for r, m in zip(recordings, masks, strict=True)])
    unit = _unit(slopes, np.array([r.spread for r in recordings]), np.array([m.any(axis=1) for m in masks]))
    if unit <= 0.0:
        return recordings
    return [replace(r, spread=row) for r, row in zip(recordings, np.maximum(slopes, 0.0) / unit, strict=True)]


def _unit(slopes: np.ndarray, spread: np.ndarray, touched: np.ndarray) -> float:
    """The slope that counts as 1, from the largest share (S, T) in which nothing was ruled out; the largest slope where there is none.

    Other taxels may have shares of the same recordings that are not looked at here.
    """
    whole = np.where(touched, 0.0, spread)
    if whole.max() <= 0.0:
        return float(slopes.max())
    at = np.unravel_index(np.argmax(whole), whole.shape)
    return float(slopes[at] / spread[at])


def _slope(recording, y: np.ndarray, kept: np.ndarray) -> float:
    """Elastic slope of one taxel (N,) over the samples of a mask (N,)."""
    if recording.depth is None:
        H = recording.force[:, None]
    else:
        x = recording.depth
        H = np.column_stack([x, np.gradient(x, recording.dt)]) * (x > 0.0)[:, None]
    return float(np.linalg.lstsq(H[kept], y[kept], rcond=None)[0][0]) if kept.any() else 0.0
