"""Sessions that press at different places: each brings its own share of every taxel along, so that one model can be fitted to all.

A share is a slope over the record. A taxel that dies part-way, or comes and goes, has a smaller one over the whole of it than its skin
gives it: every session would then have a share that is wrong by another factor, and the search would name a change of gain, or worse, for
it. So where something is ruled out the slopes are found again, from the samples that may be believed.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.array.layout import Layout


def with_spread(recordings: list, layout: Layout | str) -> list:
    """The recordings, with `spread` set where they press at different places: slope of every taxel on depth (on force, where that drives
    the test) over the largest slope of all. Each has a zero of its own in each recording, which would else be a slope of what it hardly
    feels."""
    if isinstance(layout, str) or not layout.several_contacts:
        return recordings
    slopes = np.array([np.linalg.lstsq(_beside_zero(r), r.taxels.T, rcond=None)[0][0] for r in recordings])
    return _spread(recordings, slopes, slopes.max())


def with_believed_spread(recordings: list, bad: list[np.ndarray]) -> list:
    """The recordings with their `spread` found again where `bad`, masks (C, N) whose last rows are the taxels', rules samples out; zero
    where a taxel has nothing to be believed. Recordings without a spread, or with nothing ruled out, come back as they are.
    """
    masks = [b[-len(r.taxels) :] for r, b in zip(recordings, bad, strict=True)]
    if any(r.spread is None for r in recordings) or not any(m.any() for m in masks):
        return recordings
    slopes = np.array([_slopes(r, ~m) for r, m in zip(recordings, masks, strict=True)])
    unit = _unit(slopes, np.array([r.spread for r in recordings]), np.array([m.any(axis=1) for m in masks]))
    return _spread(recordings, slopes, unit) if unit > 0.0 else recordings


def loads(recording) -> np.ndarray:
    """What the taxels answer to, (N, 2): depth, and speed, in contact; (N, 1) force, where that drives the test. The elastic slope is that
    on the first column."""
    if recording.depth is None:
        return recording.force[:, None]
    x = recording.depth
    return np.column_stack([x, np.gradient(x, recording.dt)]) * (x > 0.0)[:, None]


def _spread(recordings: list, slopes: np.ndarray, unit: float) -> list:
    return [replace(r, spread=row) for r, row in zip(recordings, np.maximum(slopes, 0.0) / unit, strict=True)]


def _beside_zero(recording) -> np.ndarray:
    """What taxels answer to, and their zero, (N, 3) or (N, 2)."""
    H = loads(recording)
    return np.column_stack([H, np.ones(len(H))])


def _slopes(recording, kept: np.ndarray) -> list[float]:
    """Elastic slope of every taxel over its samples of a mask (T, N), beside its zero."""
    H = _beside_zero(recording)
    return [float(np.linalg.lstsq(H[k], y[k], rcond=None)[0][0]) if k.any() else 0.0 for y, k in zip(recording.taxels, kept, strict=True)]


def _unit(slopes: np.ndarray, spread: np.ndarray, touched: np.ndarray) -> float:
    """The slope that counts as 1, from the largest share (S, T) in which nothing was ruled out; the largest slope where there is none.

    Other taxels may have shares of the same recordings that are not looked at here.
    """
    whole = np.where(touched, 0.0, spread)
    if whole.max() <= 0.0:
        return float(slopes.max())
    at = np.unravel_index(np.argmax(whole), whole.shape)
    return float(slopes[at] / spread[at])
