"""Raw messages from a bag's storage files: MCAP (also truncated ones) and sqlite3."""

import sqlite3
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.timing import counted

MAGIC = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, MESSAGE, CHUNK, ATTACHMENT, DATA_END = 0x03, 0x04, 0x05, 0x06, 0x09, 0x0F


@dataclass
class RawTopic:
    """All messages of one topic: type and definition, log times (ns) and serialised bytes."""

    name: str
    type: str
    definition: str
    encoding: str  # of the definition: ros2msg, ros2idl or empty
    log_ns: list[int] = field(default_factory=list)
    messages: list[bytes] = field(default_factory=list)


@dataclass
class RawBag:
    """What one storage file holds."""

    topics: dict[str, RawTopic] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()


def read_mcap(path: Path, wanted: Callable[[str, str], bool]) -> RawBag:
    """Every message of the topics for which `wanted(name, type)` holds. A file that is cut off gives what it holds, with a warning."""
    data = path.read_bytes()
    if data[:8] != MAGIC:
        raise RecordingError(f"{path} is {'empty' if not data else 'not an MCAP file'}")
    scan = _Scan(wanted)
    done = scan.run(data, 8)
    if done is None:
        return scan.bag
    missing = len(data) - done
    note = f"{path.name} is cut off or damaged after {counted(sum(len(t.messages) for t in scan.bag.topics.values()), 'message')}"
    scan.bag.warnings = (f"{note}: what comes before was used, the last {missing} bytes are lost",)
    return scan.bag


class _Scan:
    """Walks through the records from the front; needs no index, so a missing one does not matter."""

    def __init__(self, wanted: Callable[[str, str], bool]) -> None:
        self.wanted, self.bag = wanted, RawBag()
        self.schemas: dict[int, tuple[str, str, str]] = {}
        self.channels: dict[int, RawTopic | None] = {}

    def run(self, data: bytes | memoryview, start: int) -> int | None:
        """None when the end was reached in order, else the offset up to which the records are whole."""
        view, at = memoryview(data), start
        while at < len(view):
            if at + 9 > len(view):
                return at
            op, size = view[at], struct.unpack_from("<Q", view, at + 1)[0]
            if at + 9 + size > len(view):
                return at
            if op == DATA_END:
                return None
            try:
                self.record(op, view[at + 9 : at + 9 + size])
            except (struct.error, ValueError, RuntimeError, IndexError, EOFError):
                return at
            at += 9 + size
        return at if start == 8 else None  # a file ends with a footer, a chunk does not

    def record(self, op: int, body: memoryview) -> None:
        if op == MESSAGE:
            channel, _, log_ns = struct.unpack_from("<HIQ", body)
            topic = self.channels.get(channel)
            if topic is not None:
                topic.log_ns.append(log_ns)
                topic.messages.append(bytes(body[22:]))
        elif op == CHUNK:
            name, at = _string(body, 28)
            size = struct.unpack_from("<Q", body, at)[0]
            whole = _decompress(name, body[at + 8 : at + 8 + size], struct.unpack_from("<Q", body, 16)[0])
            if self.run(whole, 0) is not None:
                raise ValueError("a chunk ends within a record")
        elif op == SCHEMA:
            name, at = _string(body, 2)
            encoding, at = _string(body, at)
            self.schemas[struct.unpack_from("<H", body)[0]] = (name, encoding, _string(body, at)[0])
        elif op == CHANNEL:
            self.channel(body)
        elif op == ATTACHMENT:
            name, at = _string(body, 16)
            at = _string(body, at)[1]
            size = struct.unpack_from("<Q", body, at)[0]
            self.bag.attachments[name] = bytes(body[at + 8 : at + 8 + size])

    def channel(self, body: memoryview) -> None:
        number, schema = struct.unpack_from("<HH", body)
        name, _ = _string(body, 4)
        kind, encoding, definition = self.schemas.get(schema, ("", "", ""))
        if number in self.channels:
            return
        wanted = self.wanted(name, kind)
        self.channels[number] = self.bag.topics.setdefault(name, RawTopic(name, kind, definition, encoding)) if wanted else None


def _string(body: memoryview, at: int) -> tuple[str, int]:
    size = struct.unpack_from("<I", body, at)[0]
    return bytes(body[at + 4 : at + 4 + size]).decode(), at + 4 + size


def _decompress(name: str, data: memoryview, size: int) -> bytes | memoryview:
    if name == "":
        return data
    if name == "zstd":
        import zstandard

        return zstandard.ZstdDecompressor().decompress(bytes(data), max_output_size=size)
    if name == "lz4":
        import lz4.frame

        return lz4.frame.decompress(bytes(data))
    raise RecordingError(f"chunks compressed with {name!r} cannot be read; known are zstd and lz4")


def read_sqlite(path: Path, wanted: Callable[[str, str], bool]) -> RawBag:
    """The same from a rosbag2 sqlite3 file. Raises `RecordingError` for a file that is none."""
    bag = RawBag()
    try:
        with sqlite3.connect(f"file:{path}?mode=ro&immutable=1", uri=True) as db:
            definitions = _definitions(db)
            for number, name, kind in db.execute("SELECT id, name, type FROM topics"):
                if wanted(name, kind):
                    definition, encoding = definitions.get(kind, ("", ""))
                    topic = bag.topics.setdefault(name, RawTopic(name, kind, definition, encoding))
                    for log_ns, data in _rows(db, number):
                        topic.log_ns.append(log_ns)
                        topic.messages.append(data)
    except sqlite3.DatabaseError as error:
        if any(topic.messages for topic in bag.topics.values()):
            bag.warnings = (f"{path.name} is damaged ({error}): what could be read was used",)
            return bag
        raise RecordingError(f"{path} cannot be read as a sqlite3 bag: {error}") from error
    return bag


def _rows(db: sqlite3.Connection, topic: int) -> Iterator[tuple[int, bytes]]:
    return db.execute("SELECT timestamp, data FROM messages WHERE topic_id = ? ORDER BY id", (topic,))


def _definitions(db: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """Definition and encoding by type; older bags hold none."""
    tables = {row[0] for row in db.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if "message_definitions" not in tables:
        return {}
    rows = db.execute("SELECT topic_type, encoded_message_definition, encoding FROM message_definitions")
    return {kind: (text, encoding) for kind, text, encoding in rows}
