"""Reads the messages of an MCAP file a few chunks at a time, which bounds the memory; some are decoded while the next are read."""

import struct
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import BinaryIO

import numpy as np

from skin_ident.recordings.mcap_chunk import ChunkError, Found, indexed_messages, open_chunk, scan_messages
from skin_ident.recordings.mcap_file import DATA_END, INDEX, Survey, records
from skin_ident.recordings.places import Places
from skin_ident.recordings.runs import Run
from skin_models.words import counted

Add = Callable[[Places, np.ndarray, np.ndarray], None]  # where, sizes, log times (ns)

AHEAD = 2  # groups of chunks that are read ahead
AT_ONCE = 3 << 20  # most bytes of a group in the file
MOST = 3  # most chunks of a group, so that it fits into the cache when decompressed
ENTRIES = struct.Struct("<BQHI")  # opcode, size, channel and bytes of the entries of a message index
OFFSET = struct.Struct("<Q")


def read_messages(found: Survey, takers: dict[int, Add]) -> tuple[str, ...]:
    """Pass the messages of the channels in `takers` to them, a few chunks at a time; returns warnings about damaged or missing messages.

    A taker with a method `add_runs`, such as `gather.Gatherer`, gets records that are evenly spaced in all these chunks at once.
    """
    damaged, handed = 0, dict.fromkeys(takers, 0)
    complete = all(found.indexed.get(channel, 0) == found.counts.get(channel, 0) for channel in takers)
    for group in _opened(found.path, found.chunks):
        whole = [(body, data) for body, data in group if data is not None]
        damaged += len(group) - len(whole)
        rest = _in_runs(whole, takers, handed) if complete else takers
        for body, data in whole if rest else ():
            _hand(_messages(body, data, rest, complete), rest, handed)
    if found.loose:
        with found.path.open("rb", buffering=0) as file:
            _hand((f for f in _loose(file, found) if f[0] in takers), takers, handed)
    return _warnings(found, damaged, handed)


def _hand(messages: Iterable[Found], takers: dict[int, Add], handed: dict[int, int]) -> None:
    for channel, places, sizes, logs in messages:
        takers[channel](places, sizes, logs)
        handed[channel] += len(places)


def _in_runs(chunks: list[tuple[memoryview, object]], takers: dict[int, Add], handed: dict[int, int]) -> dict[int, Add]:
    """Pass on the messages that are evenly spaced in all of the chunks. Returns the takers whose messages are not."""
    runs = [runs_of(body, data) for body, data in chunks]
    if None in runs:
        return takers
    rest = {}
    for channel, taker in takers.items():
        mine = [r[channel] for r in runs if channel in r]
        if hasattr(taker, "add_runs") and None not in mine and taker.add_runs(channel, mine):
            handed[channel] += sum(run.count for run in mine)
        else:
            rest[channel] = taker
    return rest


def _warnings(found: Survey, damaged: int, handed: dict[int, int]) -> tuple[str, ...]:
    notes = []
    missing = {found.channels[c].topic: found.counts.get(c, 0) - n for c, n in handed.items() if n < found.counts.get(c, 0)}
    lost = "; ".join(f"{counted(n, 'message')} of {topic} lost" for topic, n in missing.items())
    if damaged:
        notes.append(f"{found.path.name}: {counted(damaged, 'damaged chunk')} left out" + (f": {lost}" if lost else ""))
    elif lost:
        notes.append(f"{found.path.name}: {lost}")
    if found.cut_at is not None and found.goes_on:
        rest = found.size - found.cut_at
        notes.append(f"{found.path.name} is damaged at byte {found.cut_at}: the {rest} bytes from there on are not read")
    elif found.cut_at is not None:
        rest = found.size - found.cut_at
        lost = f"the last {rest} bytes hold no whole record; what comes before was used" if rest else "all that is there was used"
        notes.append(f"{found.path.name} is cut off: {lost}")
    return tuple(notes)


def _opened(path: Path, chunks: list[tuple[int, int]]) -> Iterator[list[tuple[memoryview, object]]]:
    """Groups of chunks: for each chunk its bytes with the indexes behind it, and its records, or None where it is damaged. Some groups are
    read ahead."""
    groups = _grouped(chunks)
    size = max((_size(group) for group in groups), default=0)
    buffers = np.empty((AHEAD + 1, size), np.uint8)  # reused, because new memory costs more than reading
    with path.open("rb", buffering=0) as file, ThreadPoolExecutor(1) as reader:

        def fetch(i: int) -> list[tuple[memoryview, object]]:
            return _fetched(file, groups[i], buffers[i % len(buffers)])

        ahead = deque(reader.submit(fetch, i) for i in range(min(AHEAD, len(groups))))
        for i in range(len(groups)):
            yield ahead.popleft().result()
            if i + AHEAD < len(groups):
                ahead.append(reader.submit(fetch, i + AHEAD))


def _grouped(chunks: list[tuple[int, int]]) -> list[list[tuple[int, int]]]:
    """Adjacent chunks of the file in small groups, because passing on each chunk by itself costs as much as reading it."""
    groups: list[list[tuple[int, int]]] = []
    for chunk in chunks:
        last = groups[-1] if groups else []
        if not last or sum(last[-1]) != chunk[0] or len(last) == MOST or _size([*last, chunk]) > AT_ONCE:
            groups.append([])
        groups[-1].append(chunk)
    return groups


def _size(group: list[tuple[int, int]]) -> int:
    return sum(length for _, length in group)


def _fetched(file: BinaryIO, group: list[tuple[int, int]], buffer: np.ndarray) -> list[tuple[memoryview, object]]:
    file.seek(group[0][0])
    left, out = memoryview(buffer)[: file.readinto(memoryview(buffer)[: _size(group)])], []
    for _, length in group:
        body, left = left[:length], left[length:]
        try:
            out.append((body, open_chunk(body[9:])[0]))
        except ChunkError:
            out.append((body, None))
    return out


def _messages(body, data, takers: dict[int, Add], complete: bool) -> Iterator[Found]:
    """The wanted channels' messages: by the indexes after the chunk where they fit, else by walking through the records."""
    indexes = _indexes(body) if complete else {}
    found = [indexed_messages(data, channel, entries) for channel, entries in indexes.items() if channel in takers]
    if not indexes or any(f is None for f in found):
        found = [f for f in scan_messages(data) if f[0] in takers]
    return iter(found)


def runs_of(body, data) -> dict[int, Run | None] | None:
    """The records of a chunk by channel, as evenly spaced runs by the first, second and last entry of the channel's index; None for a
    channel whose entries do not agree with even spacing.

    None altogether where the index is missing or incomplete.
    """
    at, out = 9 + struct.unpack_from("<Q", body, 1)[0], {}
    while at + 15 <= len(body):
        op, size, channel, length = ENTRIES.unpack_from(body, at)
        if op != INDEX or at + 9 + size > len(body) or length + 6 != size:
            return None
        count = length // 16
        if count:
            (first,), (last,) = OFFSET.unpack_from(body, at + 23), OFFSET.unpack_from(body, at + 7 + length)
            step = OFFSET.unpack_from(body, at + 39)[0] - first if count > 1 else 1
            out[channel] = Run(data, first, step, count) if step > 0 and first + (count - 1) * step == last else None
        at += 9 + size
    return out if out and at == len(body) else None


def _indexes(body) -> dict[int, np.ndarray]:
    """Entries (n, 2) of log time and offset by channel, from the records behind the chunk; empty where one of them is damaged."""
    at, out = 9 + struct.unpack_from("<Q", body, 1)[0], {}
    while at + 15 <= len(body):
        op, size, channel, length = ENTRIES.unpack_from(body, at)
        if op != INDEX or at + 9 + size > len(body) or length + 6 != size or length % 16:
            return {}
        out[channel] = np.frombuffer(body, "<u8", length // 8, at + 15).reshape(-1, 2)
        at += 9 + size
    return out if at == len(body) else {}


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
    """Number of bytes up to the end of the last complete record, and whether the data section ends there."""
    whole = 0
    for op, start, size in records(data):
        whole = start + size
        if op == DATA_END:
            return whole, True
    return whole, False
