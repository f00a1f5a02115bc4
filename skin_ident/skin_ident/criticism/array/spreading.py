"""Sessions that press at different places: each brings its own share of every taxel along, so that one model can be fitted to all."""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.array.layout import Layout


def with_spread(recordings: list, layout: Layout | str) -> list:
    """The recordings, with `spread` set where they press at different places: slope of every taxel on depth (on force, where that drives
    the test) over the largest slope of all."""
    if isinstance(layout, str) or not layout.several_contacts:
        return recordings
    slopes = np.array([_slopes(r) for r in recordings])
    return [replace(r, spread=row) for r, row in zip(recordings, np.maximum(slopes, 0.0) / slopes.max(), strict=True)]


def _slopes(recording) -> np.ndarray:
    """Elastic slope of every taxel (T,), by least squares on depth and speed in contact."""
    if recording.depth is None:
        return recording.taxels @ recording.force / (recording.force @ recording.force)
    x = recording.depth
    H = np.column_stack([x, np.gradient(x, recording.dt)]) * (x > 0.0)[:, None]
    return np.linalg.lstsq(H, recording.taxels.T, rcond=None)[0][0]
