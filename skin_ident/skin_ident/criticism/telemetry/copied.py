"""Copies: blocks that repeat digit for digit, sessions that are one and the same, columns that hold the same numbers.

Noise does not repeat. A window of many changing samples that occurs twice in the measured channels was copied, whatever the clock or the
encoder says beside it; so was a channel that equals another one all the time. Where a converter is coarse beside the noise, the same motion
gives the same numbers for a while by itself: how often short windows recur in these very recordings tells how long chance can last.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.telemetry.symptom import Symptom, place_of, quantity

WINDOW = 32  # samples
LIVELY = 12  # different rows that a window must hold, so that a quiet hold is not taken for a copy
SHORT = (8, 16)  # samples of the windows whose recurrences tell about chance
CHANCE = 0.01  # recurrences of the length found that chance may bring at most
VALUES = 12  # different values that a column must hold
EQUAL = 0.98  # of its samples
COLUMN = "copied column"


def find_copies(recordings: list) -> list[Symptom]:
    """The first block that occurs twice, within a session or in two sessions, and columns that repeat another."""
    return [*_blocks(recordings), *_columns(recordings)]


def _blocks(recordings: list) -> list[Symptom]:
    """The longest stretch that has been there before, unless chance may have brought it."""
    rows = [np.ascontiguousarray(np.array(list(r.channels.values())).T) for r in recordings]
    repeats = list(_repeats(rows))
    again = max(repeats, key=lambda r: r.length, default=None)
    return [_copy(recordings, again)] if again and _by_chance(rows, repeats, again.length) < CHANCE else []


@dataclass(frozen=True)
class Repeat:
    """`length` samples from `start` of recording `at` on that were there before: from `origin` of recording `source` on."""

    at: int
    start: int
    source: int
    origin: int
    length: int


def _repeats(rows: list[np.ndarray]) -> Iterator[Repeat]:
    seen: dict[bytes, tuple[int, int]] = {}
    for k, row in enumerate(rows):
        new: dict[bytes, tuple[int, int]] = {}
        told = 0
        for start in range(len(row) - WINDOW):
            key = row[start : start + WINDOW].tobytes()
            first = seen.get(key) or new.setdefault(key, (k, start))
            apart = first[0] != k or start - first[1] >= WINDOW
            if apart and start >= told and _lively(row[start : start + WINDOW]):
                length = _common(rows[first[0]][first[1] :], row[start:])
                told = start + length
                yield Repeat(k, start, *first, length)
        seen |= new


def _lively(rows: np.ndarray) -> bool:
    return np.unique(rows, axis=0).shape[0] >= LIVELY * len(rows) // WINDOW


def _by_chance(rows: list[np.ndarray], repeats: list[Repeat], length: int) -> float:
    """How many windows of `length` would recur by themselves: what recurs of short windows elsewhere, carried on geometrically."""
    kept = [np.ones(len(row), bool) for row in rows]
    for r in repeats:
        kept[r.at][r.start : r.start + r.length] = False
    many, few = (_recurring([row[k] for row, k in zip(rows, kept, strict=True)], n) for n in SHORT)
    if few < 1:
        return 0.0
    return few * (few / max(many, few)) ** ((length - SHORT[1]) / (SHORT[1] - SHORT[0]))


def _recurring(rows: list[np.ndarray], size: int) -> int:
    """Lively windows of `size` samples that have been there before."""
    seen, count = set(), 0
    for r in rows:
        for start in range(len(r) - size):
            key = r[start : start + size].tobytes()
            count += key in seen and _lively(r[start : start + size])
            seen.add(key)
    return count


def _common(a: np.ndarray, b: np.ndarray) -> int:
    """How many samples of two stretches are the same from their beginning on."""
    n = min(len(a), len(b))
    differs = np.any(a[:n] != b[:n], axis=1)
    return int(np.argmax(differs)) if differs.any() else n


def _copy(recordings: list, again: Repeat) -> Symptom:
    r, source = recordings[again.at], recordings[again.source]
    start, length = again.start, again.length
    whole = length >= 0.9 * len(r)
    if whole:
        why = f"{r.name} is a copy of {source.name}: {length} of its {len(r)} samples are the same digit for digit"
    else:
        since = f"{length} samples of {r.name} from {start * r.dt:.2f} s on"
        why = f"{since} repeat {source.name} from {again.origin * source.dt:.2f} s on, digit for digit"
    parameters = {"from": quantity(start * r.dt, "s"), "length": quantity(length * r.dt, "s")}
    channels = tuple(r.channels)
    mask = np.zeros(len(r), bool)
    mask[start : start + length] = not whole
    bad = {} if whole else {(r.name, c): mask for c in channels}
    evidence = {"why": why, "kind": "copied session" if whole else "repeated block", "session": r.name}
    return Symptom("data_error", "load_cell" if "force" in channels else "taxel", channels, parameters, evidence, bad)


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
            why = f"{hold} the same numbers as {names[0]} in {100 * share:.3g} % of {rows[0].size} samples, and "
            why += "is judged no further" if len(same) == 1 else "are judged no further"
            where = place_of(same[0], len(recordings[0].taxels))
            found.append(Symptom("data_error", where, (names[0], *same), {}, {"why": why, "kind": COLUMN, "copies": len(same)}))
    return found


def copies_among(symptoms: Iterable[Symptom], recording) -> tuple[str, ...]:
    """The taxels that only repeat another channel, digit for digit: they say nothing of what they are called after. A force that drives a
    test without depth is no channel to be judged, and without any taxel nothing would be left."""
    copies = tuple(c for s in symptoms if s.evidence.get("kind") == COLUMN for c in s.channels[1:])
    return copies if recording.depth is not None or len(copies) < len(recording.taxels) else ()


def emptied(recording, copies: tuple[str, ...]):
    """The recording with zeros in these taxels, so that nothing is criticised or learnt twice."""
    taxels = recording.taxels.copy()
    taxels[[int(c.partition("_")[2]) for c in copies]] = 0.0
    return replace(recording, taxels=taxels) if copies else recording


def _fingerprint(y: np.ndarray) -> bytes:
    """Equal for rows that are the same but for few samples: their deciles and extremes are not enough, some samples are added."""
    return np.percentile(y, [10, 30, 50, 70, 90]).tobytes()
