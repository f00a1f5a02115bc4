"""Collects the messages of one topic as arrays, a chunk at a time: by one index operation per field instead of one call per message."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.layout import Layout, NotPlain, learn
from skin_ident.recordings.mcap_chunk import BEFORE
from skin_ident.recordings.places import Places
from skin_ident.recordings.runs import LOGGED, Copier, Run

STAMP = ("header.stamp.sec", "header.stamp.nanosec")


class Reader(Protocol):
    """Decodes single messages, slowly; the fast way is learnt from it and checked against it. May raise anything on damaged bytes."""

    definitions: dict
    kind: str

    def path(self, raw: bytes) -> str:
        """The path of the wanted field in this message, taken for all messages."""

    def read(self, raw: bytes) -> tuple[np.ndarray, int]:
        """The wanted numbers (R,) and the stamp in ns, 0 where there is none."""


@dataclass
class Gatherer:
    """Collects messages, about `count` of them.

    The first `size` entries hold: stamp_ns (N,), log_ns (N,), rows (N, R). `lost` counts messages that could not be decoded, `odd` those
    with another number of values.
    """

    reader: Reader
    count: int
    log_ns: np.ndarray = field(init=False)
    stamp_ns: np.ndarray = field(init=False)
    rows: np.ndarray | None = None
    chosen: str = ""
    layout: Layout | None = None
    size: int = 0
    lost: int = 0
    odd: int = 0
    copiers: dict[int, Copier] = field(default_factory=dict)  # by channel

    def __post_init__(self) -> None:
        self.log_ns, self.stamp_ns = np.zeros((2, self.count), np.int64)

    def add_runs(self, channel: int, runs: Sequence[Run]) -> bool:
        """Take in evenly spaced records of an MCAP channel. Returns False, with nothing taken, where they must be decoded one by one."""
        if self.layout is None or self.layout.size < 0:
            return False
        if channel not in self.copiers:
            self.copiers[channel] = Copier(self.layout, self.layout.fields[self.chosen], channel)
        more = sum(run.count for run in runs)
        self._make_room(more)
        at = slice(self.size, self.size + more)
        found = self.copiers[channel].copied(runs, self.rows[at])
        if found is None:
            return False
        self.log_ns[at] = found.at(LOGGED, "<i8")
        self._stamp(found.moved(BEFORE), at)
        self.size += more
        return True

    def __call__(self, places: Places, sizes: np.ndarray, log_ns: np.ndarray) -> None:
        """Take in messages of these sizes (bytes), in their order."""
        if self.layout is None and not self._learn(places, sizes):
            self.lost += len(places)
            return
        self._make_room(len(places))
        if self._all_fit(places, sizes):
            self._bulk(places, log_ns)
            return
        fits = self._fits(places, sizes)
        for i, (size, stamp, fit) in enumerate(zip(sizes, log_ns, fits, strict=True)):
            if fit:
                self._bulk(Places(places.buffer, places.starts[i : i + 1]), log_ns[i : i + 1])
            else:
                self._single(places.raw(i, size), stamp)

    def _learn(self, places: Places, sizes: np.ndarray) -> bool:
        """Learn the layout from the first message that can be decoded; it is used only if both ways of reading that message agree."""
        for i, size in enumerate(sizes.tolist()):
            raw = places.raw(i, size)
            try:
                self.chosen = self.reader.path(raw)
                values, stamp = self.reader.read(raw)
                self.layout = learn(self.reader.definitions, self.reader.kind, raw, (self.chosen, *STAMP))
            except NotPlain:
                self.layout = Layout(-1, {}, ())  # fits nothing: every message goes the slow way
            except RecordingError:
                raise
            except Exception:  # generated code meets damaged bytes
                continue
            self.rows = np.empty((self.count, values.size))
            if self.layout.size >= 0 and not self._agrees(raw, values, stamp):
                self.layout = Layout(-1, {}, ())
            return True
        return False

    def _agrees(self, raw: bytes, values: np.ndarray, stamp: int) -> bool:
        if self.chosen not in self.layout.fields:
            return False
        one = Gatherer(self.reader, 1, layout=self.layout, chosen=self.chosen, rows=np.empty((1, values.size)))
        if self.layout.fields[self.chosen].count != values.size:
            return False
        one._bulk(Places(raw, np.zeros(1, np.int64)), np.zeros(1, np.int64))
        return np.array_equal(one.rows[0], values, equal_nan=True) and int(one.stamp_ns[0]) == stamp

    def _make_room(self, more: int) -> None:
        """Enlarge the arrays where more messages come than the file's summary has announced."""
        need = self.size + more
        if need > self.count:
            self.count = max(need, 2 * self.count)
            for name in ("log_ns", "stamp_ns", "rows"):
                old = getattr(self, name)
                new = np.zeros((self.count, *old.shape[1:]), old.dtype)
                new[: self.size] = old[: self.size]
                setattr(self, name, new)

    def _all_fit(self, places: Places, sizes: np.ndarray) -> bool:
        """Whether all messages have the layout; faster than `_fits`."""
        same = np.count_nonzero(sizes == self.layout.size) == sizes.size
        return same and all(places.all_share(offset, content) for offset, content in self.layout.fixed)

    def _fits(self, places: Places, sizes: np.ndarray) -> np.ndarray:
        """A mask of the messages that have the layout: the same size, and the same bytes where the layout requires it."""
        good = sizes == self.layout.size
        inside = places.only(good)
        for offset, content in self.layout.fixed if len(inside) else ():
            good[good] &= inside.share(offset, content)
            inside = places.only(good)
        return good

    def _bulk(self, places: Places, log_ns: np.ndarray) -> None:
        at = slice(self.size, self.size + len(places))
        self._stamp(places, at)
        self.log_ns[at] = log_ns
        rows, chosen = self.rows[at], self.layout.fields[self.chosen]
        if np.dtype(chosen.code) == rows.dtype and chosen.count:
            whole = f"V{8 * chosen.count}"
            rows.view(whole)[:, 0] = places.at(chosen.offset, whole)
        else:
            found = places.at(chosen.offset, f"V{chosen.count * int(chosen.code[2:])}")
            rows[...] = np.ascontiguousarray(found).view(chosen.code).reshape(rows.shape)
        self.size += len(places)

    def _stamp(self, places: Places, at: slice) -> None:
        """Read the header stamps of messages at these places."""
        f = self.layout.fields
        if STAMP[0] in f and STAMP[1] in f:
            sec, nanosec = (places.at(f[path].offset, f[path].code) for path in STAMP)
            np.multiply(sec, 1_000_000_000, out=self.stamp_ns[at], dtype=np.int64)
            self.stamp_ns[at] += nanosec

    def _single(self, raw: bytes, log_ns: int) -> None:
        try:
            row, stamp = self.reader.read(raw)
        except Exception:  # generated code meets damaged bytes
            self.lost += 1
            return
        if row.size != self.rows.shape[1]:
            self.odd += 1
            return
        self.log_ns[self.size], self.stamp_ns[self.size], self.rows[self.size] = log_ns, stamp, row
        self.size += 1
