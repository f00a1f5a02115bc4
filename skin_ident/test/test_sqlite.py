"""sqlite3 bags that a crash left behind give what they hold."""

import sqlite3
from contextlib import closing

import numpy as np
import pytest
from making import recording, write_bag

from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.load import load

R = recording(n=300, shares=(1.0, 0.4))


@pytest.mark.parametrize("share", [0.1, 0.5, 0.77, 0.98])
def test_truncated_sqlite_gives_what_it_holds(tmp_path, share):
    r = recording(n=1500, sigma=0.0)
    file = next(write_bag(tmp_path / "a", r, "sqlite3").glob("*.db3"))
    file.write_bytes(file.read_bytes()[: int(share * file.stat().st_size)])
    (read,) = load(tmp_path / "a")
    assert 0.5 * share * len(r) < len(read) <= len(r) and "cut off" in read.warnings[0]
    assert np.max(np.abs(read.force - r.force[: len(read)])) < 0.02  # a few samples before the cut may be interpolated


def test_truncated_sqlite_without_a_whole_page_is_refused(tmp_path):
    file = next(write_bag(tmp_path / "a", R, "sqlite3").glob("*.db3"))
    file.write_bytes(file.read_bytes()[:1000])
    with pytest.raises(RecordingError, match="cannot be read"):
        load(tmp_path / "a")


def test_cells_of_another_type_are_left_out(tmp_path):
    """A flipped bit in the head of a row makes text of a number."""
    file = next(write_bag(tmp_path / "a", R, "sqlite3").glob("*.db3"))
    with closing(sqlite3.connect(file)) as db:
        db.execute("UPDATE messages SET timestamp = CAST(x'17ff0a' AS BLOB) WHERE id = 100")
        db.execute("UPDATE messages SET topic_id = CAST(x'17ff0a' AS BLOB) WHERE id = 200")
        db.execute("UPDATE messages SET data = 7 WHERE id = 300")
        db.commit()
    (read,) = load(tmp_path / "a")
    assert len(read) == len(R) and "3 missing" in " ".join(read.warnings) and np.max(np.abs(read.force - R.force)) < 0.3


def test_what_a_killed_recorder_left_in_the_log_is_read(tmp_path):
    file = next(write_bag(tmp_path / "a", R, "sqlite3").glob("*.db3"))
    killed = tmp_path / "b.db3"
    with closing(sqlite3.connect(file)) as db:
        rows = db.execute("SELECT id, topic_id, timestamp, data FROM messages WHERE id > 400").fetchall()
        db.execute("DELETE FROM messages WHERE id > 400")
        db.execute("PRAGMA user_version=1")
        db.commit()
        db.execute("PRAGMA journal_mode=WAL")
        db.executemany("INSERT INTO messages (id, topic_id, timestamp, data) VALUES (?, ?, ?, ?)", rows)
        db.commit()
        for suffix in ("", "-wal"):
            killed.with_name(f"b.db3{suffix}").write_bytes(file.with_name(f"{file.name}{suffix}").read_bytes())
    read = load(killed)[0]
    assert np.array_equal(read.depth, R.depth) and np.array_equal(read.taxels, R.taxels)
