"""Offsets of numbers in a serialised message, learnt from one message and checked on every other.

If strings and sequences have the same lengths in every CDR message of a topic, all numbers are at the same offsets, and a thousand messages
can be read as one strided array. `learn` walks through one message along its definition and notes the offset of every wanted field, and the
bytes that must not change (lengths, names of joints). A message that differs in those bytes is decoded on its own.

Plain CDR, version 1: numbers are aligned to their size, counted from the end of the 4-byte header. Source: OMG DDS-XTypes 1.3, section
7.4.1.
"""

import struct
from collections.abc import Iterable
from dataclasses import dataclass, field

from rosbags.interfaces import Nodetype

SIZES = {
    "bool": 1, "byte": 1, "char": 1, "octet": 1, "int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4, "uint32": 4, "float32": 4,
    "int64": 8, "uint64": 8, "float64": 8,
}  # fmt: skip
CODES = {"float32": "f4", "float64": "f8", "int32": "i4", "uint32": "u4", "uint8": "u1", "byte": "u1", "bool": "u1", "int64": "i8"}
FREE = ("frame_id",)  # strings whose content may change, as long as their length does not


class NotPlain(Exception):
    """The message cannot be read by offsets: its definition holds something that is not handled here, or it ends too early."""


@dataclass(frozen=True)
class Field:
    """Consecutive numbers of one type: offset (bytes), numpy's type code, count."""

    offset: int
    code: str
    count: int


@dataclass(frozen=True)
class Layout:
    """Length of the message, the wanted fields by path, and the stretches (offset, bytes) that every message must share."""

    size: int
    fields: dict[str, Field]
    fixed: tuple[tuple[int, bytes], ...]


def learn(definitions: dict, kind: str, raw: bytes, wanted: Iterable[str]) -> Layout:
    """The layout of `raw`, a message of type `kind`. Raises `NotPlain`."""
    walk = _Walk(definitions, bytes(raw), frozenset(wanted))
    try:
        walk.message(kind, "")
    except (struct.error, IndexError, KeyError) as error:
        raise NotPlain from error
    if walk.at > len(raw):
        raise NotPlain
    return Layout(len(raw), walk.fields, _merged(walk.fixed, bytes(raw)))


@dataclass
class _Walk:
    definitions: dict
    raw: bytes
    wanted: frozenset[str]
    fields: dict[str, Field] = field(default_factory=dict)
    fixed: list[tuple[int, int]] = field(default_factory=list)
    at: int = 4

    def __post_init__(self) -> None:
        if self.raw[:2] not in (b"\x00\x01", b"\x00\x00"):
            raise NotPlain
        self.order = "<" if self.raw[1] else ">"
        self.fixed.append((0, 2))

    def message(self, kind: str, path: str) -> None:
        """Walk the fields of a message of this kind, one after the other."""
        for name, description in self.definitions[kind][1]:
            self.item(f"{path}.{name}" if path else name, *description)

    def item(self, path: str, node: Nodetype, content) -> None:
        """Walk one field: a message, a number or text, or an array of either."""
        if node == Nodetype.NAME:
            self.message(content, path)
        elif node == Nodetype.BASE:
            self.run(path, content[0], 1)
        else:
            (inner, of), count = content
            count = count if node == Nodetype.ARRAY else self.length()
            if inner == Nodetype.BASE:
                self.run(path, of[0], count)
            else:
                for i in range(count):
                    self.item(f"{path}[{i}]", inner, of)

    def length(self) -> int:
        """A sequence's or string's length, which every message must share."""
        self.align(4)
        value = struct.unpack_from(self.order + "I", self.raw, self.at)[0]
        self.fixed.append((self.at, 4))
        self.at += 4
        return value

    def align(self, size: int) -> None:
        """Skip the padding before a number of so many bytes; alignment is counted from the end of the header."""
        self.at += (4 - self.at) % size

    def run(self, path: str, base: str, count: int) -> None:
        """Walk so many numbers or texts of one type."""
        if base == "string":
            for _ in range(count):
                size = self.length()
                if path.rpartition(".")[2] not in FREE:
                    self.fixed.append((self.at, size))
                self.at += size
            return
        if base not in SIZES:
            raise NotPlain
        if count:
            self.align(SIZES[base])
        if base in CODES:
            self.note(path, self.order + CODES[base], count)
        self.at += count * SIZES[base]

    def note(self, path: str, code: str, count: int) -> None:
        """Note the offset of a field, or of one of its numbers (`position[2]`), if it is wanted."""
        for wanted in self.wanted:
            if wanted == path:
                self.fields[path] = Field(self.at, code, count)
            elif wanted.startswith(f"{path}[") and int(wanted[len(path) + 1 : -1]) < count:
                self.fields[wanted] = Field(self.at + int(wanted[len(path) + 1 : -1]) * int(code[2:]), code, 1)


def _merged(spans: list[tuple[int, int]], raw: bytes) -> tuple[tuple[int, bytes], ...]:
    """The stretches (offset, bytes), with adjacent ones merged."""
    out: list[list[int]] = []
    for start, size in spans:
        if out and out[-1][0] + out[-1][1] == start:
            out[-1][1] += size
        elif size:
            out.append([start, size])
    return tuple((start, raw[start : start + size]) for start, size in out)
