"""Copies evenly spaced records of one topic for a group of chunks at a time, and checks them together.

Reading costs more for the number of calls than for the number of bytes, so as few calls as possible are made per chunk: the bytes around
the numbers are copied unchecked, and checked when the group is complete.
"""

import struct
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from skin_ident.recordings.layout import Field, Layout
from skin_ident.recordings.mcap_chunk import BEFORE, MESSAGE
from skin_ident.recordings.places import Places

SMALL = 256  # bytes: up to so many bytes of numbers are copied together with what surrounds them
LOGGED = 15  # offset of the log time in a record


class Run(NamedTuple):
    """`count` records of one channel, `step` bytes apart, the first of them `first` bytes from the beginning of `data`."""

    data: Any
    first: int
    step: int
    count: int


class Copier:
    """Copies records whose messages have a layout; `numbers` is the field of the wanted numbers."""

    def __init__(self, layout: Layout, numbers: Field, channel: int) -> None:
        self.size, self.code, self.count = BEFORE + layout.size, np.dtype(numbers.code), numbers.count
        self.begin = BEFORE + numbers.offset
        end = self.begin + numbers.count * self.code.itemsize
        fixed = [(0, struct.pack("<BQH", MESSAGE, layout.size + 22, channel)), *((BEFORE + at, same) for at, same in layout.fixed)]
        others = [(BEFORE + f.offset, f.count * np.dtype(f.code).itemsize) for f in layout.fields.values() if f is not numbers]
        last = max(at + size for at, size in [*((at, len(same)) for at, same in fixed), *others])
        self.apart = end - self.begin > SMALL
        spans = [(0, self.begin), *([(end, last)] if last > end else [])] if self.apart else [(0, max(end, last))]
        self.copies = [_Copy(start, stop, fixed) for start, stop in spans]
        self.able = all(at + size <= spans[0][1] for at, size in others)

    def copied(self, runs: Sequence[Run], rows: np.ndarray) -> Places | None:
        """Copies the numbers of every record into `rows` (n, R), and returns the places of the copied bytes before them (and of the numbers
        too, where they are few).

        None where a record does not have the layout; the content of `rows` is then undefined.
        """
        if not self.able or any(run.first + (run.count - 1) * run.step + self.size > len(run.data) for run in runs):
            return None
        if not all(copy.taken(runs, len(rows)) for copy in self.copies):
            return None
        head = self.copies[0].places(len(rows))
        if self.apart:
            self._numbers(runs, rows)
        else:
            rows[...] = np.ndarray(rows.shape, self.code, head.buffer, self.begin, (head.step, self.code.itemsize))
        return head

    def _numbers(self, runs: Sequence[Run], rows: np.ndarray) -> None:
        whole, at = f"V{self.code.itemsize * self.count}", 0
        for data, first, step, count in runs:
            here = rows[at : at + count]
            if self.code == rows.dtype:
                here.view(whole)[:, 0] = np.ndarray((count,), whole, data, first + self.begin, (step,))
            else:
                here[...] = np.ndarray(here.shape, self.code, data, first + self.begin, (step, self.code.itemsize))
            at += count


class _Copy:
    """Copies of the bytes from `start` to `stop` of every record, one after the other, and which of them must be the same in all
    records."""

    def __init__(self, start: int, stop: int, fixed: Sequence[tuple[int, bytes]]) -> None:
        self.start, self.kind = start, np.dtype(f"V{stop - start}")
        self.one = np.zeros((2, stop - start), np.uint8)  # the required bytes, and a mask of where bytes are required
        for at, same in fixed:
            if start <= at < stop:
                self.one[0, at - start : at - start + len(same)] = np.frombuffer(same, np.uint8)
                self.one[1, at - start : at - start + len(same)] = 255
        self._make_room(0)

    def _make_room(self, count: int) -> None:
        self.records = np.zeros(8 * (count // 8 + 1), self.kind)  # eight records fill whole words
        self.bytes = self.records.view(np.uint8)
        self.same, self.where = (np.tile(row, self.records.size).view(np.uint64) for row in self.one)

    def taken(self, runs: Sequence[Run], total: int) -> bool:
        """Copy `total` records, and return whether all hold the required bytes."""
        if total > self.records.size:
            self._make_room(2 * total)
        at = 0
        for data, first, step, count in runs:
            self.records[at : at + count] = np.ndarray((count,), self.kind, data, first + self.start, (step,))
            at += count
        words = (total + 7) // 8 * self.kind.itemsize
        self.records[total : (total + 7) // 8 * 8] = self.records[:1]
        return not (((self.bytes.view(np.uint64)[:words] ^ self.same[:words]) & self.where[:words]).any())

    def places(self, count: int) -> Places:
        """The places of the copied records."""
        return Places.evenly(self.bytes, self.kind.itemsize, count)
