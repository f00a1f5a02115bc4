"""What an MCAP file holds, and where; `mcap_read` then reads the wanted topics.

The summary at the end says what the file holds. Without one (the recorder was killed, or the file is cut off), or with one that is damaged,
the records are walked through from the front, and all that are complete are used; a chunk that is cut short gives the messages before the
cut.
Source: MCAP specification, mcap.dev/spec.
"""

import struct
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.mcap_chunk import LEAST, ChunkError, crc32, open_chunk, scan_messages, string

MAGIC = b"\x89MCAP0\r\n"
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, INDEX, CHUNK_INDEX, ATTACHMENT, STATISTICS, DATA_END = 2, 3, 4, 5, 6, 7, 8, 9, 11, 15
KNOWN = range(1, 16)  # opcodes of the specification
HEAD = struct.Struct("<BQ")


@dataclass(frozen=True)
class Channel:
    """One topic: name, type, its definition, the definition's format (ros2msg, ros2idl), and the message encoding."""

    topic: str
    kind: str
    definition: str
    encoding: str
    messages: str


@dataclass
class Survey:
    """What a file holds: channels and message counts by id; begin and length of every chunk with its indexes; attachments."""

    path: Path
    schemas: dict[int, tuple[str, str, str]] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    counts: dict[int, int] = field(default_factory=dict)
    chunks: list[tuple[int, int]] = field(default_factory=list)
    attachments: dict[str, bytes] = field(default_factory=dict)
    indexed: dict[int, int] = field(default_factory=dict)  # number of messages in the chunks' indexes, by channel
    loose: bool = False  # whether there are messages outside chunks
    chunk_count: int = 0
    cut_at: int | None = None  # byte at which the file is cut off or damaged
    goes_on: bool = False  # whether it is damaged there and goes on, unread, rather than cut off
    size: int = 0


def survey(path: Path) -> Survey:
    """What the file holds. Raises `RecordingError` for one that is no MCAP file."""
    with path.open("rb", buffering=0) as file:
        if file.read(8) != MAGIC:
            raise RecordingError(f"{path} is {'empty' if path.stat().st_size == 0 else 'not an MCAP file'}")
        found = Survey(path, size=path.stat().st_size)
        return found if _from_summary(file, found) else _from_front(file, Survey(path, size=found.size))


def _from_summary(file: BinaryIO, found: Survey) -> bool:
    """Read the summary; False where it is missing, incomplete or damaged."""
    if found.size < 45:
        return False
    file.seek(-37, 2)
    end = file.read(37)
    if end[-8:] != MAGIC or end[0] != FOOTER:
        return False
    start, _, crc = struct.unpack_from("<QQI", end, 9)
    if not 8 <= start < found.size - 37:
        return False
    file.seek(start)
    summary = file.read(found.size - 37 - start)
    if crc and crc32(end[:25], crc32(summary)) != crc:
        return False
    try:
        for op, at, size in records(summary):
            _note(found, op, summary[at : at + size])
        _find_attachments(file, found, summary)
    except struct.error:
        return False
    return bool(found.channels) and bool(found.counts) and len(found.chunks) == found.chunk_count and _possible(found)


def _possible(found: Survey) -> bool:
    """Whether all chunks lie within the file, and no more messages are announced than it has bytes."""
    inside = all(_within(found, at, length) for at, length in found.chunks)
    return inside and sum(found.counts.values()) <= found.size


def _within(found: Survey, at: int, length: int) -> bool:
    return at >= len(MAGIC) and length >= HEAD.size and at + length <= found.size


def records(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Every complete record: opcode, where its content begins, its size."""
    at = 0
    while at + 9 <= len(data):
        op, size = HEAD.unpack_from(data, at)
        if at + 9 + size > len(data):
            return
        yield op, at + 9, size
        at += 9 + size


def _note(found: Survey, op: int, body: bytes) -> None:
    if op == SCHEMA:
        name, at = string(body, 2)
        encoding, at = string(body, at)
        found.schemas[struct.unpack_from("<H", body)[0]] = (name, encoding, string(body, at)[0])
    elif op == CHANNEL:
        number, schema = struct.unpack_from("<HH", body)
        topic, at = string(body, 4)
        kind, encoding, definition = found.schemas.get(schema, ("", "", ""))
        found.channels[number] = Channel(topic, kind, definition, encoding, string(body, at)[0])
    elif op == CHUNK_INDEX:
        _note_chunk_index(found, body)
    elif op == STATISTICS:
        found.chunk_count = struct.unpack_from("<I", body, 22)[0]
        found.loose = found.chunk_count == 0
        size = struct.unpack_from("<I", body, 42)[0]
        found.counts = dict(struct.iter_unpack("<HQ", body[46 : 46 + size]))


def _note_chunk_index(found: Survey, body: bytes) -> None:
    offset, length = struct.unpack_from("<QQ", body, 16)
    map_size = struct.unpack_from("<I", body, 32)[0]
    index_length = struct.unpack_from("<Q", body, 36 + map_size)[0]
    found.chunks.append((offset, length + index_length))
    begins = sorted((at, channel) for channel, at in struct.iter_unpack("<HQ", body[36 : 36 + map_size]))
    ends = [*(at for at, _ in begins[1:]), offset + length + index_length]
    for (at, channel), end in zip(begins, ends, strict=False):  # a chunk without indexes begins none of them
        found.indexed[channel] = found.indexed.get(channel, 0) + (end - at - 15) // 16


def _find_attachments(file: BinaryIO, found: Survey, summary: bytes) -> None:
    for op, at, _ in records(summary):
        if op == 0x0A:
            offset, length = struct.unpack_from("<QQ", summary, at)
            if not _within(found, offset, length):
                raise struct.error("an attachment beyond the end of the file")
            file.seek(offset + 9)
            _attach(found, file.read(length - 9))


def _attach(found: Survey, body: bytes) -> None:
    name, at = string(body, 16)
    at = string(body, at)[1]
    size = struct.unpack_from("<Q", body, at)[0]
    found.attachments[name] = body[at + 8 : at + 8 + size]


def _from_front(file: BinaryIO, found: Survey) -> Survey:
    """Walk through a file without a summary; every chunk is decompressed to find its channels. Damaged records are passed over."""
    at = 8
    while True:
        file.seek(at)
        head = file.read(9)
        if len(head) < 9:
            found.cut_at = at
            return found
        op, size = HEAD.unpack(head)
        if op in (DATA_END, FOOTER):
            found.cut_at = None if found.channels else found.cut_at  # damaged chunks are counted when they are read
            return found
        there = min(size, found.size - at - 9)
        whole = there == size
        if op == CHUNK:
            if not _note_chunk(found, file.read(there)):
                found.cut_at = at
            found.chunks.append((at, 9 + there + _indexes(file, found, at + 9 + there)))
        elif not whole:
            found.cut_at = at
        elif op in (SCHEMA, CHANNEL):
            _note_whole(found, op, file.read(size))
        elif op == MESSAGE and size >= LEAST:
            found.loose = True
            number = struct.unpack("<H", file.read(2))[0]
            found.counts[number] = found.counts.get(number, 0) + 1
        elif op == ATTACHMENT:
            with suppress(struct.error):
                _attach(found, file.read(size))
        if not whole:
            found.goes_on = op not in KNOWN or _has_end(file, found)
            return found
        at += 9 + size


def _has_end(file: BinaryIO, found: Survey) -> bool:
    """Whether the file ends with the magic bytes, as a complete one does."""
    file.seek(max(0, found.size - len(MAGIC)))
    return file.read(len(MAGIC)) == MAGIC


def _indexes(file: BinaryIO, found: Survey, at: int) -> int:
    """Bytes of message indexes that follow a chunk."""
    begin = at
    while at + 9 <= found.size:
        file.seek(at)
        op, size = HEAD.unpack(file.read(9))
        if op != INDEX or at + 9 + size > found.size:
            break
        at += 9 + size
    return at - begin


def _note_chunk(found: Survey, body: bytes) -> bool:
    """Channels and counts within a chunk; False where it is damaged or cut short."""
    try:
        chunk, whole = open_chunk(body)
    except ChunkError:
        return False
    for number, places, _, _ in scan_messages(chunk, lambda op, part: _note_whole(found, op, bytes(part))):
        found.counts[number] = found.counts.get(number, 0) + len(places)
    return whole


def _note_whole(found: Survey, op: int, body: bytes) -> None:
    """As `_note`, and nothing where the record is damaged."""
    with suppress(struct.error):
        _note(found, op, body)
