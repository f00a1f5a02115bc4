"""Copies: blocks that repeat digit for digit, sessions that are one and the same, columns that hold the same numbers.

Noise does not repeat. A window of many changing samples that occurs twice in the measured channels was copied, whatever the clock or the
encoder says beside it; so was a channel that equals another one all the time.
"""

import numpy as np

from skin_ident.criticism.telemetry.symptom import Symptom, place_of, quantity

WINDOW = 32  # samples
LIVELY = 12  # different rows that a window must hold, so that a quiet hold is not taken for a copy
VALUES = 12  # different values that a column must hold
EQUAL = 0.98  # of its samples


def find_copies(recordings: list) -> list[Symptom]:
    """The first block that occurs twice, within a session or in two sessions, and columns that repeat another."""
    return [*_blocks(recordings), *_columns(recordings)]


def _blocks(recordings: list) -> list[Symptom]:
    seen: dict[bytes, tuple[int, int]] = {}
    rows = [np.ascontiguousarray(np.array(list(r.channels.values())).T) for r in recordings]
    for k, r in enumerate(recordings):
        new: dict[bytes, tuple[int, int]] = {}
        for start in range(len(r) - WINDOW):
            key = rows[k][start : start + WINDOW].tobytes()
            first = seen.get(key) or new.get(key)
            if first and (first[0] != k or start - first[1] >= WINDOW) and _lively(rows[k][start : start + WINDOW]):
                length = _common(rows[first[0]][first[1] :], rows[k][start:])
                return [_copy(recordings, (k, start), first, length)]
            new.setdefault(key, (k, start))
        seen |= new
    return []


def _lively(rows: np.ndarray) -> bool:
    return np.unique(rows, axis=0).shape[0] >= LIVELY


def _common(a: np.ndarray, b: np.ndarray) -> int:
    """How many samples of two stretches are the same from their beginning on."""
    n = min(len(a), len(b))
    differs = np.any(a[:n] != b[:n], axis=1)
    return int(np.argmax(differs)) if differs.any() else n


def _copy(recordings: list, here: tuple[int, int], first: tuple[int, int], length: int) -> Symptom:
    (k, start), (j, origin) = here, first
    r, source = recordings[k], recordings[j]
    whole = length >= 0.9 * len(r)
    if whole:
        why = f"{r.name} is a copy of {source.name}: {length} of its {len(r)} samples are the same digit for digit"
    else:
        here, there = f"{start * r.dt:.2f} s", f"{origin * source.dt:.2f} s"
        why = f"{length} samples of {r.name} from {here} on repeat {source.name} from {there} on, digit for digit"
    parameters = {"from": quantity(start * r.dt, "s"), "length": quantity(length * r.dt, "s")}
    channels = tuple(r.channels)
    mask = np.zeros(len(r), bool)
    mask[start : start + length] = not whole
    bad = {} if whole else {(r.name, c): mask for c in channels}
    kind = "copied session" if whole else "repeated block"
    return Symptom(
        "data_error",
        "load_cell" if "force" in channels else "taxel",
        channels,
        parameters,
        {"why": why, "kind": kind, "session": r.name},
        bad,
    )


def _columns(recordings: list) -> list[Symptom]:
    """Groups of channels that hold the same numbers, each group one symptom at the first channel that repeats."""
    groups: dict[bytes, list[str]] = {}
    for channel in recordings[0].channels:
        y = np.concatenate([r.channels[channel] for r in recordings])
        if np.unique(y).size >= VALUES:
            groups.setdefault(_fingerprint(y), []).append(channel)
    found = []
    for names in groups.values():
        rows = [np.concatenate([r.channels[c] for r in recordings]) for c in names]
        same = [c for c, row in zip(names[1:], rows[1:], strict=True) if np.mean(row == rows[0]) > EQUAL]
        if same:
            share = float(np.mean(rows[1] == rows[0]))
            hold = f"{', '.join(same[:8])} {'holds' if len(same) == 1 else 'hold'}"
            why = f"{hold} the same numbers as {names[0]} in {100 * share:.3g} % of {rows[0].size} samples"
            where = place_of(same[0], len(recordings[0].taxels))
            found.append(Symptom("data_error", where, (names[0], *same), {}, {"why": why, "kind": "copied column", "copies": len(same)}))
    return found


def _fingerprint(y: np.ndarray) -> bytes:
    """Equal for rows that are the same but for few samples: their deciles and extremes are not enough, some samples are added."""
    return np.percentile(y, [10, 30, 50, 70, 90]).tobytes()
