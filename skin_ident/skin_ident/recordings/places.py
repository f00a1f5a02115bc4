"""Where the messages of one topic lie in a buffer, and how to look at the same spot in all of them at once."""

from typing import Any

import numpy as np


class Places:
    """Messages that begin at `starts` (n,) of `buffer`. Where they are evenly spaced, as topics of one rate are, looking costs no copy."""

    def __init__(self, buffer: Any, starts: np.ndarray) -> None:
        self.buffer, self.starts = buffer, starts
        self.first, self.step = (int(starts[0]) if starts.size else 0), 0
        if starts.size > 1:
            steps = np.diff(starts)
            self.step = int(steps[0]) if steps[0] > 0 and (steps == steps[0]).all() else 0

    def __len__(self) -> int:
        return self.starts.size

    def only(self, keep: np.ndarray) -> "Places":
        """Some of the messages."""
        return self if keep.all() else Places(self.buffer, self.starts[keep])

    def moved(self, by: int) -> "Places":
        """The same messages, each looked at from `by` bytes further on."""
        out = Places.__new__(Places)
        out.buffer, out.starts, out.first, out.step = self.buffer, self.starts + by, self.first + by, self.step
        return out

    def at(self, offset: int, code: str) -> np.ndarray:
        """The item of numpy's type `code` at an offset of every message (n,): a view where they are evenly spaced, else a copy."""
        kind = np.dtype(code)
        if self.step:
            return np.ndarray((self.starts.size,), kind, self.buffer, self.first + offset, (self.step,))
        count = max(0, len(self.buffer) - kind.itemsize + 1)
        return np.ndarray((count,), kind, self.buffer, strides=(1,))[self.starts + offset]

    def share(self, offset: int, content: bytes) -> np.ndarray:
        """Which messages (n,) hold these bytes at an offset: word by word, the last word overlapping the one before."""
        same = np.ones(self.starts.size, bool)
        for start, size in _words(len(content)):
            word = np.frombuffer(content, f"u{size}", 1, start)[0]
            same &= self.at(offset + start, f"u{size}") == word
        return same

    def raw(self, i: int, size: int) -> bytes:
        """The i-th message."""
        start = int(self.starts[i])
        return bytes(self.buffer[start : start + size])


def _words(length: int) -> list[tuple[int, int]]:
    """Start and size of the machine words that cover so many bytes."""
    if length in (1, 2, 4, 8):
        return [(0, length)]
    if length > 8:
        return [(start, 8) for start in range(0, length - 8, 8)] + [(length - 8, 8)]
    half = 4 if length > 4 else 2
    return [(0, half), (length - half, half)]
