"""Decompresses and checks one MCAP chunk, and finds its messages."""

import struct
from collections.abc import Callable, Iterator

import numpy as np

from skin_ident.recordings.places import Places

try:
    from zlib_ng.zlib_ng import crc32  # eight times as quick as the interpreter's own, where it is installed
except ImportError:
    from binascii import crc32

HEADER = struct.Struct("<QQQIi")  # message start, message end, uncompressed size, crc, length of the compression's name
BEFORE = 31  # bytes of a message record before its data: opcode, size, channel, sequence, log time, publish time
LEAST = 22  # bytes of the content of a message record before its data
SCHEMA, CHANNEL, MESSAGE = 3, 4, 5


class ChunkError(Exception):
    """No part of a chunk can be used."""


def string(body, at: int) -> tuple[str, int]:
    """A length-prefixed string and where the next item begins."""
    size = struct.unpack_from("<I", body, at)[0]
    return bytes(body[at + 4 : at + 4 + size]).decode("utf-8", "replace"), at + 4 + size


def open_chunk(body) -> tuple[bytes | memoryview, bool]:
    """The records in a chunk's body, and whether they are complete. Raises `ChunkError` where none can be read."""
    try:
        _, _, size, crc, _ = HEADER.unpack_from(body)
        name, at = string(body, 28)
        packed_size = struct.unpack_from("<Q", body, at)[0]
    except struct.error as error:
        raise ChunkError from error
    packed = memoryview(body)[at + 8 : at + 8 + packed_size]
    data = decompress(name, packed, size)
    whole = len(data) == size and len(packed) == packed_size
    if whole and crc and crc32(data) != crc:
        raise ChunkError
    return data, whole


def decompress(name: str, packed: memoryview, size: int) -> bytes | memoryview:
    """The content of a chunk, or its beginning where the chunk is cut short. Raises `ChunkError`."""
    try:
        if name == "":
            return packed
        if name == "zstd":
            return _zstd(packed, size)
        if name == "lz4":
            return _lz4(packed, size)
    except (RuntimeError, ValueError, EOFError, MemoryError, OverflowError) as error:
        raise ChunkError from error
    raise ChunkError(f"compressed with {name!r}; known are zstd and lz4")


def _zstd(packed: memoryview, size: int) -> bytes:
    import zstandard

    try:
        return zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
    except zstandard.ZstdError:
        return _as_far_as_it_goes(zstandard.ZstdDecompressor().decompressobj(), packed, zstandard.ZstdError)


def _lz4(packed: memoryview, size: int) -> bytes:
    import lz4.frame

    try:
        return lz4.frame.decompress(packed)
    except RuntimeError:
        return _as_far_as_it_goes(lz4.frame.LZ4FrameDecompressor(), packed, RuntimeError)


def _as_far_as_it_goes(stream, packed: memoryview, failure: type[Exception]) -> bytes:
    parts = []
    try:
        for at in range(0, len(packed), 4096):
            parts.append(stream.decompress(bytes(packed[at : at + 4096])))
    except (failure, EOFError):
        pass
    return b"".join(parts)


Found = tuple[int, Places, np.ndarray, np.ndarray]  # channel, where, sizes, log times (ns)


def scan_messages(data, other: Callable[[int, memoryview], None] = lambda op, part: None) -> Iterator[Found]:
    """Walk through the records and yield the places, sizes and log times (ns) of every channel's messages. `other` gets schema and channel
    records."""
    view, at, found = memoryview(data), 0, {}
    while at + 9 <= len(view):
        op, size = view[at], struct.unpack_from("<Q", view, at + 1)[0]
        if at + 9 + size > len(view):
            break
        if op == MESSAGE and size >= LEAST:
            channel, _, log = struct.unpack_from("<HIQ", view, at + 9)
            found.setdefault(channel, []).append((at + BEFORE, size - LEAST, log))
        elif op in (SCHEMA, CHANNEL):
            other(op, view[at + 9 : at + 9 + size])
        at += 9 + size
    for channel, rows in found.items():
        starts, sizes, logs = np.array(rows, np.uint64).view(np.int64).T
        yield channel, Places(data, np.ascontiguousarray(starts)), sizes, logs


def indexed_messages(data, channel: int, entries: np.ndarray) -> Found | None:
    """The same for one channel from its message index, entries (n, 2) of log time and offset; None where the index does not fit."""
    logs, places = entries[:, 0].view(np.int64), Places(data, entries[:, 1])
    if not len(places):
        return channel, places, np.empty(0, np.int64), logs
    if not places.step:
        order = np.argsort(entries[:, 1], kind="stable")
        logs, places = logs[order], Places(data, entries[order, 1].astype(np.int64))
        if places.starts[-1] < 0:  # the largest: beyond what an int64 holds
            return None
    if places.last + BEFORE > len(data):
        return None
    sizes, end = _sizes(places, channel)
    if sizes is None or end + BEFORE > len(data):
        return None
    return channel, places.moved(BEFORE), sizes, logs


def _sizes(places: Places, channel: int) -> tuple[np.ndarray | None, int]:
    """Sizes (bytes) of the messages' data and where the last one ends; None where a record is no message of the channel."""
    first = places.raw(0, 11)  # opcode, size, channel
    if first[0] != MESSAGE or struct.unpack_from("<H", first, 9)[0] != channel:
        return None, 0
    if places.all_share(0, first):
        size = struct.unpack_from("<Q", first, 1)[0] - LEAST
        return (np.full(len(places), size), places.last + size) if 0 <= size < 1 << 40 else (None, 0)
    sizes = places.at(1, "<u8").astype(np.int64) - LEAST
    good = np.all((places.at(0, "u1") == MESSAGE) & (places.at(9, "<u2") == channel) & (sizes >= 0) & (sizes < 1 << 40))
    return (sizes, int((places.starts + sizes).max())) if good else (None, 0)
