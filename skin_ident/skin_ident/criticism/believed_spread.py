"""The spread of sessions that press at different places, from the samples that may be believed.

What each session brings along as its share of every taxel (see `array.spreading`) is a slope over the whole record. A taxel that dies
part-way, or comes and goes, has a smaller slope there than its skin gives it: every session would then have a share that is wrong by
another factor, and the search would name a change of gain, or worse, for it.
"""

from dataclasses import replace

import numpy as np


def with_believed_spread(recordings: list, bad: list[np.ndarray]) -> list:
    """The recordings with their `spread` found again where `bad`, masks (C, N) whose last rows are the taxels', rules samples out.

    Slope of every taxel on depth, with speed beside it and in contact (on force, where that drives the test), over the largest of all;
    zero where a taxel has nothing to be believed. Recordings without a spread, or with nothing ruled out, come back as they are.
    """
    masks = [b[-len(r.taxels) :] for r, b in zip(recordings, bad, strict=True)]
    if any(r.spread is None for r in recordings) or not any(m.any() for m in masks):
        return recordings
    slopes = np.array([[_slope(r, y, ~b) for y, b in zip(r.taxels, m, strict=True)] for r, m in zip(recordings, masks, strict=True)])
    if slopes.max() <= 0.0:
        return recordings
    return [replace(r, spread=row) for r, row in zip(recordings, np.maximum(slopes, 0.0) / slopes.max(), strict=True)]


def _slope(recording, y: np.ndarray, kept: np.ndarray) -> float:
    """Elastic slope of one taxel (N,) over the samples of a mask (N,)."""
    if recording.depth is None:
        H = recording.force[:, None]
    else:
        x = recording.depth
        H = np.column_stack([x, np.gradient(x, recording.dt)]) * (x > 0.0)[:, None]
    return float(np.linalg.lstsq(H[kept], y[kept], rcond=None)[0][0]) if kept.any() else 0.0
