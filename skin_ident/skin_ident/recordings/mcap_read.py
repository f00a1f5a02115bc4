"""The messages of an MCAP file, one chunk at a time, with little more memory than a few chunks: one is decoded while the next are read."""

import struct
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import BinaryIO

import numpy as np

from skin_ident.recordings.mcap_chunk import ChunkError, Found, indexed_messages, open_chunk, scan_messages
from skin_ident.recordings.mcap_file import DATA_END, HEAD, INDEX, Survey, records
from skin_ident.recordings.places import Places
from skin_ident.recordings.timing import counted

Add = Callable[[Places, np.ndarray, np.ndarray], None]  # where, sizes, log times (ns)

AHEAD = 2  # groups of chunks
AT_ONCE = 2 << 20  # bytes of a group, as they lie in the file
MOST = 3  # chunks of a group: unpacked, it should still fit into the cache


def read_messages(found: Survey, takers: dict[int, Add]) -> tuple[str, ...]:
    """Hand the messages of the channels in `takers` over, chunk by chunk; returns warnings about what is damaged or missing."""
    damaged, handed = 0, dict.fromkeys(takers, 0)
    with found.path.open("rb", buffering=0) as file:
        for body, data in _opened(file, found.chunks):
            if data is None:
                damaged += 1
                continue
            for channel, places, sizes, logs in _messages(found, body, data, takers):
                takers[channel](places, sizes, logs)
                handed[channel] += len(places)
        if found.loose:
            for channel, places, sizes, logs in _loose(file, found):
                if channel in takers:
                    takers[channel](places, sizes, logs)
                    handed[channel] += len(places)
    return _warnings(found, damaged, handed)


def _warnings(found: Survey, damaged: int, handed: dict[int, int]) -> tuple[str, ...]:
    notes = []
    missing = {found.channels[c].topic: found.counts.get(c, 0) - n for c, n in handed.items() if n < found.counts.get(c, 0)}
    lost = "; ".join(f"{counted(n, 'message')} of {topic} lost" for topic, n in missing.items())
    if damaged:
        notes.append(f"{found.path.name}: {counted(damaged, 'damaged chunk')} left out" + (f": {lost}" if lost else ""))
    elif lost:
        notes.append(f"{found.path.name}: {lost}")
    if found.cut_at is not None:
        rest = found.size - found.cut_at
        notes.append(f"{found.path.name} is cut off: the last {rest} bytes hold no whole record; what comes before was used")
    return tuple(notes)


def _opened(file: BinaryIO, chunks: list[tuple[int, int]]) -> Iterator[tuple[memoryview, object]]:
    """Chunk after chunk: its bytes with what follows, and its records or None where it is damaged. A few are fetched ahead."""
    groups = _grouped(chunks)
    size = max((sum(length for _, length in group) for group in groups), default=0)
    buffers = [bytearray(size) for _ in range(AHEAD + 1)]  # used again and again: fresh memory costs more than reading

    def fetch(i: int) -> list[tuple[memoryview, object]]:
        left, out = memoryview(buffers[i % len(buffers)]), []
        for offset, length in groups[i]:
            out.append(_fetched(file, offset, left[:length]))
            left = left[length:]
        return out

    with ThreadPoolExecutor(1) as reader:
        ahead = deque(reader.submit(fetch, i) for i in range(min(AHEAD, len(groups))))
        for i in range(len(groups)):
            yield from ahead.popleft().result()
            if i + AHEAD < len(groups):
                ahead.append(reader.submit(fetch, i + AHEAD))


def _grouped(chunks: list[tuple[int, int]]) -> list[list[tuple[int, int]]]:
    """A few neighbouring chunks together: handing each over by itself costs as much as reading it."""
    groups: list[list[tuple[int, int]]] = []
    size = AT_ONCE
    for chunk in chunks:
        if size + chunk[1] > AT_ONCE or len(groups[-1]) == MOST:
            groups.append([])
            size = 0
        groups[-1].append(chunk)
        size += chunk[1]
    return groups


def _fetched(file: BinaryIO, offset: int, body: memoryview) -> tuple[memoryview, object]:
    file.seek(offset)
    got = file.readinto(body)
    try:
        return body[:got], open_chunk(body[9:got])[0]
    except ChunkError:
        return body[:got], None


def _messages(survey: Survey, body, data, takers) -> Iterator[Found]:
    """The wanted channels' messages: by the indexes after the chunk where they fit, else by walking through the records."""
    complete = all(survey.indexed.get(channel, 0) == survey.counts.get(channel, 0) for channel in takers)
    indexes = _indexes(body) if complete else {}
    found = [indexed_messages(data, channel, entries) for channel, entries in indexes.items() if channel in takers]
    if not indexes or any(f is None for f in found):
        found = [f for f in scan_messages(data) if f[0] in takers]
    return iter(found)


def _indexes(body) -> dict[int, np.ndarray]:
    """Entries (n, 2) of log time and offset by channel, from the records behind the chunk."""
    at = 9 + struct.unpack_from("<Q", body, 1)[0]
    out = {}
    while at + 9 <= len(body):
        op, size = HEAD.unpack_from(body, at)
        if op != INDEX or at + 9 + size > len(body):
            break
        channel, length = struct.unpack_from("<HI", body, at + 9)
        out[channel] = np.frombuffer(body, "<u8", length // 8, at + 15).reshape(-1, 2)
        at += 9 + size
    return out


def _loose(file: BinaryIO, found: Survey, piece: int = 1 << 20) -> Iterator[Found]:
    """Messages outside chunks, a piece of the file at a time."""
    at, ended = 8, False
    while at < found.size and not ended:
        file.seek(at)
        data = file.read(piece)
        whole, ended = _whole_records(data)
        if whole == 0 and len(data) < piece:
            return
        piece = piece if whole else 2 * piece
        yield from scan_messages(data[:whole])
        at += whole


def _whole_records(data: bytes) -> tuple[int, bool]:
    """Up to where the records are whole, and whether the data section ends there."""
    whole = 0
    for op, start, size in records(data):
        whole = start + size
        if op == DATA_END:
            return whole, True
    return whole, False
