"""rosbag2 sqlite3 files: what is in them, and the messages of the topics that are wanted, a few thousand at a time."""

import sqlite3
from collections.abc import Callable
from pathlib import Path

import numpy as np

from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.mcap_file import Channel
from skin_ident.recordings.mcap_read import Add
from skin_ident.recordings.places import Places

BATCH = 4096


def open_sqlite(path: Path) -> sqlite3.Connection:
    """A connection that changes nothing. Raises `RecordingError`."""
    if path.stat().st_size == 0:
        raise RecordingError(f"{path} is empty")
    return sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro&immutable=1", uri=True)


def survey_sqlite(path: Path) -> tuple[dict[int, Channel], dict[int, int]]:
    """Topics and message counts by id. Raises `RecordingError` for a file that is none."""
    db = open_sqlite(path)
    try:
        definitions = _definitions(db)
        topics = db.execute("SELECT id, name, type, serialization_format FROM topics").fetchall()
        counts = dict(db.execute("SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id"))
    except sqlite3.DatabaseError as error:
        raise RecordingError(f"{path} cannot be read as a sqlite3 bag: {error}") from error
    finally:
        db.close()
    return {number: Channel(name, kind, *definitions.get(kind, ("", "")), coding) for number, name, kind, coding in topics}, counts


def _definitions(db: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """Definition and its encoding by type; bags from before Jazzy hold none."""
    tables = {row[0] for row in db.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if "message_definitions" not in tables:
        return {}
    rows = db.execute("SELECT topic_type, encoded_message_definition, encoding FROM message_definitions")
    return {kind: (text, encoding) for kind, text, encoding in rows}


def read_sqlite(path: Path, takers: dict[int, Add], unpack: Callable[[bytes], bytes] | None = None) -> tuple[str, ...]:
    """Hand the messages of the topics in `takers` over; `unpack` undoes a compression of single messages. Returns warnings."""
    db, broken = open_sqlite(path), ""
    try:
        for number, add in takers.items():
            rows = db.execute("SELECT timestamp, data FROM messages WHERE topic_id = ? ORDER BY timestamp, id", (number,))
            while batch := rows.fetchmany(BATCH):
                hand_over(batch, add, unpack)
    except sqlite3.DatabaseError as error:
        broken = f"{path.name} is damaged ({error}): what could be read was used"
    finally:
        db.close()
    return (broken,) if broken else ()


def hand_over(batch: list[tuple[int, bytes]], add: Add, unpack: Callable[[bytes], bytes] | None) -> None:
    """Join a batch of (log time, message) and hand it over."""
    messages = [data if unpack is None else unpack(data) for _, data in batch]
    sizes = np.fromiter(map(len, messages), np.int64, len(messages))
    add(Places(b"".join(messages), np.cumsum(sizes) - sizes), sizes, np.fromiter((stamp for stamp, _ in batch), np.int64, len(batch)))
