"""Reads rosbag2 sqlite3 files: their topics, and the messages of wanted topics, a few thousand at a time."""

import sqlite3
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing
from itertools import islice
from pathlib import Path

import numpy as np

from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.mcap_file import Channel
from skin_ident.recordings.mcap_read import Add
from skin_ident.recordings.places import Places

BATCH = 4096  # messages
WHOLE = "topic_id = ? AND typeof(timestamp) = 'integer' AND typeof(data) = 'blob'"  # a flipped bit can change the type of a cell


def open_sqlite(path: Path) -> sqlite3.Connection:
    """A read-only connection that can also read a file that is cut off, up to its end. Raises `RecordingError`."""
    if path.stat().st_size == 0:
        raise RecordingError(f"{path} is empty")
    # the write-ahead log beside the file holds what a killed recorder had not yet moved into it
    how = "mode=ro" if path.with_name(f"{path.name}-wal").exists() else "mode=ro&immutable=1"
    db = sqlite3.connect(f"{path.resolve().as_uri()}?{how}", uri=True)
    if missing_bytes(path):
        db.execute("PRAGMA writable_schema=ON")  # otherwise one missing page makes all pages unreadable
    return db


def missing_bytes(path: Path) -> int:
    """Number of bytes by which the file is shorter than its header says."""
    with path.open("rb") as file:
        head = file.read(100)
    page, count = int.from_bytes(head[16:18], "big"), int.from_bytes(head[28:32], "big")
    whole = head.startswith(b"SQLite format 3") and not path.with_name(f"{path.name}-wal").exists()
    return max(0, (65536 if page == 1 else page) * count - path.stat().st_size) if whole else 0


def survey_sqlite(path: Path) -> tuple[dict[int, Channel], dict[int, int]]:
    """Topics and message counts by id; for a file that is cut off, as far as they can be read. Raises `RecordingError` for any other
    file."""
    db = open_sqlite(path)
    try:
        definitions = _definitions(db)
        topics = db.execute("SELECT id, name, type, serialization_format FROM topics").fetchall()
        numbers = (row[0] for row in _reachable(db, "SELECT topic_id FROM messages NOT INDEXED WHERE typeof(topic_id) = 'integer'"))
        whole = "SELECT topic_id, COUNT(*) FROM messages WHERE typeof(topic_id) = 'integer' GROUP BY topic_id"
        counts = dict(Counter(numbers)) if missing_bytes(path) else dict(db.execute(whole))
    except sqlite3.DatabaseError as error:
        raise RecordingError(f"{path} cannot be read as a sqlite3 bag: {_plain(error)}") from error
    finally:
        db.close()
    return {number: Channel(name, kind, *definitions.get(kind, ("", "")), coding) for number, name, kind, coding in topics}, counts


def _plain(error: Exception) -> str:
    """An error that may quote damaged bytes, in one printable line."""
    return " ".join("".join(c if c.isprintable() else " " for c in str(error)).split())


def _reachable(db: sqlite3.Connection, query: str, values: tuple = ()) -> Iterator[tuple]:
    """Rows up to the first that cannot be read."""
    try:
        yield from db.execute(query, values)
    except sqlite3.DatabaseError:
        return


def _definitions(db: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """Definition and its encoding by type; bags from before Jazzy hold none."""
    tables = {row[0] for row in db.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if "message_definitions" not in tables:
        return {}
    rows = db.execute("SELECT topic_type, encoded_message_definition, encoding FROM message_definitions")
    return {kind: (text, encoding) for kind, text, encoding in rows}


def read_sqlite(path: Path, takers: dict[int, Add], unpack: Callable[[bytes], bytes] | None = None) -> tuple[str, ...]:
    """Pass the messages of the topics in `takers` to them; `unpack` decompresses single messages. Returns warnings."""
    missing = missing_bytes(path)
    if missing:
        _read_what_is_left(path, takers, unpack)
        return (f"{path.name} is cut off: {missing} bytes are missing at its end; what comes before was used",)
    db, broken = open_sqlite(path), ""
    try:
        for number, add in takers.items():
            rows = db.execute(f"SELECT timestamp, data FROM messages WHERE {WHOLE} ORDER BY timestamp, id", (number,))
            while batch := rows.fetchmany(BATCH):
                hand_over(batch, add, unpack)
    except sqlite3.DatabaseError as error:
        broken = f"{path.name} is damaged ({_plain(error)}): what could be read was used"
    finally:
        db.close()
    return (broken,) if broken else ()


def _read_what_is_left(path: Path, takers: dict[int, Add], unpack: Callable[[bytes], bytes] | None) -> None:
    """Read a file that is cut off without its index, which was at its end: messages come as written, and are sorted batch by batch."""
    query = f"SELECT timestamp, data FROM messages NOT INDEXED WHERE {WHOLE}"
    with closing(open_sqlite(path)) as db:
        for number, add in takers.items():
            rows = _reachable(db, query, (number,))
            while batch := list(islice(rows, BATCH)):
                hand_over(sorted(batch, key=lambda row: row[0]), add, unpack)


def hand_over(batch: list[tuple[int, bytes]], add: Add, unpack: Callable[[bytes], bytes] | None) -> None:
    """Join a batch of (log time, message) and pass it to a taker."""
    messages = [data if unpack is None else unpack(data) for _, data in batch]
    sizes = np.fromiter(map(len, messages), np.int64, len(messages))
    add(Places(b"".join(messages), np.cumsum(sizes) - sizes), sizes, np.fromiter((stamp for stamp, _ in batch), np.int64, len(batch)))
