"""One MCAP chunk: decompressed, checked, and its messages found."""

import struct
from binascii import crc32
from collections.abc import Callable, Iterator

import numpy as np

HEADER = struct.Struct("<QQQIi")  # message start, message end, uncompressed size, crc, length of the compression's name
HEAD = np.dtype([("op", "u1"), ("size", "<u8"), ("channel", "<u2")])
BEFORE = 31  # bytes of a message record before its data: opcode, size, channel, sequence, log time, publish time
SCHEMA, CHANNEL, MESSAGE = 3, 4, 5


class ChunkError(Exception):
    """Nothing of this chunk can be used."""


def string(body, at: int) -> tuple[str, int]:
    """A length-prefixed string and where the next item begins."""
    size = struct.unpack_from("<I", body, at)[0]
    return bytes(body[at + 4 : at + 4 + size]).decode("utf-8", "replace"), at + 4 + size


def open_chunk(body) -> tuple[bytes | memoryview, bool]:
    """The records in a chunk's body, and whether they are all there. Raises `ChunkError` where nothing can be had."""
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
    """The content of a chunk; as much of it as there is where it is cut short. Raises `ChunkError`."""
    try:
        if name == "":
            return packed
        if name == "zstd":
            return _zstd(packed, size)
        if name == "lz4":
            return _lz4(packed, size)
    except (RuntimeError, ValueError, EOFError, MemoryError) as error:
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


Found = tuple[int, np.ndarray, np.ndarray, np.ndarray]


def scan_messages(data, other: Callable[[int, memoryview], None] = lambda op, part: None) -> Iterator[Found]:
    """Walk through the records: channel, where its messages' data begin, their sizes, their log times (ns). `other` gets the rest."""
    view, at, found = memoryview(data), 0, {}
    while at + 9 <= len(view):
        op, size = view[at], struct.unpack_from("<Q", view, at + 1)[0]
        if at + 9 + size > len(view):
            break
        if op == MESSAGE and size >= 22:
            channel, _, log = struct.unpack_from("<HIQ", view, at + 9)
            found.setdefault(channel, []).append((at + BEFORE, size - 22, log))
        elif op in (SCHEMA, CHANNEL):
            other(op, view[at + 9 : at + 9 + size])
        at += 9 + size
    for channel, rows in found.items():
        starts, sizes, logs = np.array(rows, np.int64).T
        yield channel, starts, sizes, logs


def indexed_messages(data, channel: int, entries: np.ndarray) -> Found | None:
    """The same for one channel from its message index, entries (n, 2) of log time and offset; None where the index does not fit."""
    if len(entries) > 1 and not np.all(entries[1:, 1] > entries[:-1, 1]):
        entries = entries[np.argsort(entries[:, 1], kind="stable")]
    offsets, logs = entries[:, 1].astype(np.int64), entries[:, 0].astype(np.int64)
    if not offsets.size:
        return channel, offsets, offsets, logs
    if offsets[0] < 0 or offsets[-1] + BEFORE > len(data):
        return None
    heads = taken(data, offsets, 11)  # opcode, size, channel
    first = heads[0].tobytes()
    if (heads == np.frombuffer(first, "V11")).all():
        sizes = np.full(offsets.size, struct.unpack_from("<Q", first, 1)[0] - 22)
        good = first[0] == MESSAGE and struct.unpack_from("<H", first, 9)[0] == channel
    else:
        heads = heads.view(HEAD)
        sizes = heads["size"].astype(np.int64) - 22
        good = np.all((heads["op"] == MESSAGE) & (heads["channel"] == channel))
    if not good or sizes.min() < 0 or np.any(offsets + BEFORE + sizes > len(data)):
        return None
    return channel, offsets + BEFORE, sizes, logs


def taken(buffer, starts: np.ndarray, size: int) -> np.ndarray:
    """`size` bytes from every start, as an array of raw items: a strided view where the starts are evenly spaced, else a copy."""
    if starts.size > 1:
        step = int(starts[1] - starts[0])
        if step > 0 and (np.diff(starts) == step).all():
            return np.ndarray((starts.size,), f"V{size}", buffer, int(starts[0]), strides=(step,))
    return np.ndarray((max(0, len(buffer) - size + 1),), f"V{size}", buffer, strides=(1,))[starts]
