"""The places of one topic's messages in a buffer, and access to the same offset in all of them at once."""

from functools import lru_cache
from typing import Any

import numpy as np


class Places:
    """Messages that begin at `starts` (n,) of `buffer`. Where they are evenly spaced, as usual for one rate, access needs no copy."""

    def __init__(self, buffer: Any, starts: np.ndarray) -> None:
        self.buffer, self.count, self._starts = buffer, starts.size, starts
        self.first, self.step = (int(starts[0]) if starts.size else 0), 0
        if starts.size > 1:
            step = int(starts[1]) - self.first
            # decreasing unsigned offsets wrap around to huge differences, which never equal a positive step
            if step > 0 and np.count_nonzero(np.subtract(starts[1:], starts[:-1]) == step) == starts.size - 1:
                self.step = step

    @classmethod
    def evenly(cls, buffer: Any, step: int, count: int) -> "Places":
        """`count` messages, `step` bytes apart, the first at the beginning of the buffer."""
        out = cls.__new__(cls)
        out.buffer, out.count, out.first, out.step, out._starts = buffer, count, 0, step, None
        return out

    def __len__(self) -> int:
        return self.count

    @property
    def starts(self) -> np.ndarray:
        """Where the messages begin (n,)."""
        if self._starts is None:
            self._starts = self.first + self.step * np.arange(self.count)
        return self._starts

    @property
    def last(self) -> int:
        """Where the last of them begins, in their order."""
        return self.first + self.step * (self.count - 1) if self.step else int(self.starts[-1])

    def only(self, keep: np.ndarray) -> "Places":
        """The messages that a mask (count,) selects, in their order."""
        return self if keep.all() else Places(self.buffer, self.starts[keep])

    def moved(self, by: int) -> "Places":
        """The same messages, with each place moved by `by` bytes."""
        out = Places.__new__(Places)
        out.buffer, out.count, out.first, out.step = self.buffer, self.count, self.first + by, self.step
        out._starts = None if self.step else self.starts + by
        return out

    def at(self, offset: int, code: str | np.dtype) -> np.ndarray:
        """The item of numpy's type `code` at an offset of every message (n,): a view where they are evenly spaced, else a copy."""
        if self.step:
            return np.ndarray((self.count,), code, self.buffer, self.first + offset, (self.step,))
        kind = np.dtype(code)
        count = max(0, len(self.buffer) - kind.itemsize + 1)
        return np.ndarray((count,), kind, self.buffer, strides=(1,))[self.starts + offset]

    def all_share(self, offset: int, content: bytes) -> bool:
        """Whether every message holds these bytes at an offset. They are compared as machine words, of which the last two may overlap."""
        return all(np.count_nonzero(self.at(offset + start, code) == word) == self.count for start, code, word in _words(content))

    def share(self, offset: int, content: bytes) -> np.ndarray:
        """A mask (n,) of the messages that hold these bytes at an offset."""
        same = np.ones(self.count, bool)
        for start, code, word in _words(content):
            same &= self.at(offset + start, code) == word
        return same

    def raw(self, i: int, size: int) -> bytes:
        """The first `size` bytes of the i-th message."""
        start = int(self.starts[i]) if self._starts is not None or not self.step else self.first + i * self.step
        return bytes(self.buffer[start : start + size])


@lru_cache(256)
def _words(content: bytes) -> tuple[tuple[int, np.dtype, np.generic], ...]:
    """Start, type and value of the machine words that cover so many bytes."""
    places = [(start, np.dtype(f"u{size}")) for start, size in _cover(len(content))]
    return tuple((start, kind, np.frombuffer(content, kind, 1, start)[0]) for start, kind in places)


def _cover(length: int) -> list[tuple[int, int]]:
    """Start and size of words that cover so many bytes."""
    if length in (1, 2, 4, 8):
        return [(0, length)]
    if length > 8:
        return [(start, 8) for start in range(0, length - 8, 8)] + [(length - 8, 8)]
    half = 4 if length > 4 else 2
    return [(0, half), (length - half, half)]
