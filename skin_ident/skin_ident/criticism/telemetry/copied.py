"""Data errors that show without a model: blocks that repeat exactly, columns that were swapped, units that changed.

Noise does not repeat. A window of many changing samples that occurs twice, digit for digit in every channel, was copied.
"""

import numpy as np

from skin_ident.criticism.telemetry.symptom import Symptom, quantity

WINDOW = 32  # samples
LIVELY = 12  # different rows that a window must hold, so that a quiet hold is not taken for a copy
UNIT_FACTORS = (1000.0, 1e-3, 10.0, 0.1, 9.80665, 1 / 9.80665, 4.44822, 1 / 4.44822)
NEAR = 0.06  # relative, how close a ratio of slopes must come to such a factor


def find_copies(recordings: list) -> list[Symptom]:
    """Blocks that occur twice, within a session or in two sessions."""
    seen: dict[bytes, tuple[str, int]] = {}
    for r in recordings:
        rows = np.ascontiguousarray(np.array(list(r.channels.values())).T)
        new: dict[bytes, tuple[str, int]] = {}
        for start in range(0, len(r) - WINDOW):
            key = rows[start : start + WINDOW].tobytes()
            first = seen.get(key) or new.get(key)
            if first and np.unique(rows[start : start + WINDOW], axis=0).shape[0] >= LIVELY:
                if first[0] != r.name or start - first[1] >= WINDOW:
                    return [_copy(r, start, first, list(r.channels))]
            new.setdefault(key, (r.name, start))
        seen |= new
    return []


def _copy(recording, start: int, first: tuple[str, int], channels: list[str]) -> Symptom:
    why = f"from {start * recording.dt:.2f} s on, {recording.name} repeats {first[0]} from {first[1] * recording.dt:.2f} s on, digit for digit"
    return Symptom("data_error", "rig", tuple(channels), {"repeat_from": quantity(start * recording.dt, "s")}, {"why": why})


def find_unit_changes(recordings: list) -> list[Symptom]:
    """A channel whose slope against depth differs between sessions by a factor that only a unit has."""
    found = []
    for channel in recordings[0].channels:
        slopes = np.array([_slope(r, channel) for r in recordings])
        if len(slopes) < 2 or not np.all(np.isfinite(slopes)) or np.any(np.abs(slopes) < 1e-9):
            continue
        for r, ratio in zip(recordings, slopes / np.median(slopes), strict=True):
            factor = next((f for f in UNIT_FACTORS if abs(ratio / f - 1.0) < NEAR), None)
            if factor:
                why = f"{channel} of {r.name} is {ratio:.4g} times what the other sessions say: a factor of units"
                where = "load_cell" if channel == "force" else channel
                found.append(Symptom("data_error", where, (channel,), {"factor": quantity(factor, "1")}, {"why": why, "session": r.name}))
    return found


def _slope(recording, channel: str) -> float:
    x, y = recording.depth, recording.channels.get(channel)
    if x is None or y is None or np.ptp(x) == 0.0:
        return float("nan")
    x = x - x.mean()
    return float(x @ (y - y.mean()) / (x @ x))
