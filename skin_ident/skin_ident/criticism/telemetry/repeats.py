"""Stretches of a record that occurred before, digit for digit, and how long they must be to exceed chance.

Noise does not repeat. But where a converter is coarse beside the noise, the same motion gives the same numbers for a while. How often short
windows recur in these recordings shows how long chance can last. It shows nothing of what is periodic: hum that is as long as a few samples
goes through the same numbers for as long as a hold lasts, and meets them again in the next.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from skin_ident.criticism.telemetry.sent_twice import is_periodic, sent_twice
from skin_ident.recordings.digits import MULTIPLIER

WINDOW = 24  # samples of a window, more than of those that measure chance
LIVELY = 9  # different readings that a window must hold, so that a quiet hold is not taken for a copy
SHORT = (8, 16)  # samples of the windows whose recurrences measure chance
CHANCE = 0.001  # largest number of recurrences of this length expected by chance
PART = 100_000  # windows examined at a time, which bounds the memory


@dataclass(frozen=True)
class Repeat:
    """`length` samples from `start` of recording `at` on that occurred before, from `origin` of recording `source` on. `lively` counts
    those in windows with enough different readings: a coarse reading at rest repeats itself, which shows nothing. `by_chance` is the number
    of stretches as lively that would recur by chance, as short windows do elsewhere in these recordings."""

    at: int
    start: int
    source: int
    origin: int
    length: int
    lively: int
    by_chance: float = np.inf

    @property
    def is_rare(self) -> bool:
        """Whether chance does not explain it."""
        return self.by_chance < CHANCE

    def is_part_of(self, other: "Repeat") -> bool:
        """Whether all its samples are among those of another."""
        return self.at == other.at and other.start <= self.start and self.start + self.length <= other.start + other.length


def repeats_of(rows: list[np.ndarray]) -> list[Repeat]:
    """Repeats in readings (N, C) of each recording, the longest first; after them short blocks that were sent twice in a row. What is
    periodic in itself is left out."""
    codes = _codes(rows)
    every = sorted(_repeats(codes), key=lambda r: -r.length)
    expected = _by_chance(codes, every) if every else None
    long = [replace(r, by_chance=expected(r.lively)) for r in every]
    short = [Repeat(k, start, k, origin, *rest) for k, start, origin, *rest in sent_twice(codes, WINDOW)]
    through = [r for r in long if not is_periodic(codes[r.at][r.start : r.start + r.length], WINDOW)]
    return [*through, *(r for r in short if r.is_rare and not any(r.is_part_of(other) for other in long))]


def _codes(rows: list[np.ndarray]) -> list[np.ndarray]:
    """A number for every different reading, by recording."""
    every = np.concatenate(rows)
    codes = np.unique(every, axis=0, return_inverse=True)[1].ravel().astype(np.uint64)
    return np.split(codes, np.cumsum([len(row) for row in rows])[:-1])


def _repeats(codes: list[np.ndarray]) -> Iterator[Repeat]:
    """Every stretch that equals an earlier one elsewhere, extended in both directions from the first equal window."""
    at, start, first = _recurring(codes, WINDOW)
    source, origin = at[first], start[first]
    apart = (source != at) | (start - origin >= WINDOW)
    told = dict.fromkeys(range(len(codes)), 0)
    for i in np.flatnonzero(apart & (first != np.arange(at.size))):
        k, s = int(at[i]), int(start[i])
        if s >= told[k]:
            j, o = int(source[i]), int(origin[i])
            length = _common(codes[j][o:], codes[k][s:])
            if length >= WINDOW:
                before = _common(codes[j][:o][::-1], codes[k][told[k] : s][::-1])
                told[k] = s + length
                mine = start[(at == k) & (start >= s - before) & (start <= s + length - WINDOW)]
                yield Repeat(k, s - before, j, o - before, length + before, WINDOW + int(np.minimum(np.diff(mine), WINDOW).sum()))


def _recurring(codes: list[np.ndarray], size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Recording and start of every lively window of `size` samples, and the index of the first window that equals it."""
    powers = np.cumprod(np.full(size, MULTIPLIER))  # weights of the windows' polynomial hash
    at, start, hashes = [], [], []
    for k, row in enumerate(codes):
        for begin in range(0, row.size - size + 1, PART):
            windows = sliding_window_view(row[begin : begin + PART + size - 1], size)
            lively = np.flatnonzero(_different(windows) >= LIVELY * size // WINDOW)
            at.append(np.full(lively.size, k))
            start.append(begin + lively)
            hashes.append((windows[lively] * powers).sum(axis=1, dtype=np.uint64))
    if not at:
        return np.zeros(0, int), np.zeros(0, int), np.zeros(0, int)
    _, first, which = np.unique(np.concatenate(hashes), return_index=True, return_inverse=True)
    return np.concatenate(at), np.concatenate(start), first[which.ravel()]


def _different(windows: np.ndarray) -> np.ndarray:
    """Number of different readings in every window (…, n)."""
    return 1 + np.count_nonzero(np.diff(np.sort(windows, axis=-1), axis=-1), axis=-1)


def _by_chance(codes: list[np.ndarray], repeats: list[Repeat]):
    """A function of the length: how many windows of it would recur by chance. It extrapolates the recurrences of short windows outside the
    `repeats` geometrically."""
    kept = [np.ones(row.size, bool) for row in codes]
    for r in repeats:
        kept[r.at][r.start : r.start + r.length] = False
    rest = [row[k] for row, k in zip(codes, kept, strict=True)]
    many, few = (int(np.count_nonzero(first != np.arange(first.size))) for *_, first in (_recurring(rest, n) for n in SHORT))
    return lambda length: few * (few / max(many, few, 1)) ** ((length - SHORT[1]) / (SHORT[1] - SHORT[0]))


def _common(a: np.ndarray, b: np.ndarray) -> int:
    """Number of leading samples that two stretches have in common."""
    n = min(a.size, b.size)
    differs = a[:n] != b[:n]
    return int(np.argmax(differs)) if differs.any() else n
