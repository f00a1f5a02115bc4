"""Defects of recordings, one function each: they change a good session the way loggers, clocks, cables and people do."""

import sqlite3
import struct
from contextlib import closing
from dataclasses import dataclass, field

import numpy as np
from making import KINDS, START_NS, serialised, typestore
from mcap.writer import CompressionType, Writer

CHANNELS = ("encoder", "force", "taxels")


@dataclass
class Raw:
    """A session before it is written: stamps (ns) and values (R, N) per channel, and what happens to the file."""

    t: dict
    y: dict
    header: list = field(default_factory=lambda: ["t_s", "x_mm", "force_n"])
    cut: float = 1.0
    flip: int | None = None
    only_table: bool = False
    log: dict = field(default_factory=dict)


def raw(r):
    """A good one."""
    ns = START_NS + np.rint(r.t * 1e9).astype(np.int64)
    y = {"encoder": r.depth[None].copy(), "force": r.force[None].copy(), "taxels": r.taxels.copy()}
    return Raw({c: ns.copy() for c in CHANNELS}, y, log=dict.fromkeys(CHANNELS, ns + 1_000_000))


def _of(draw, session, *choices):
    return draw.choice(choices or CHANNELS), draw.integers(1, 40), draw.integers(5, max(6, session.t["force"].size - 60))


def _select(s, index, channels=CHANNELS):
    for c in channels:
        s.t[c], s.y[c], s.log[c] = s.t[c][index], s.y[c][:, index], np.sort(s.log[c][index])


def repeated_samples(draw, s):
    _, n, at = _of(draw, s)
    index = np.sort(np.concatenate([np.arange(s.t["force"].size), np.arange(at, at + n)]))
    _select(s, index)


def repeated_stamps(draw, s):
    _, n, at = _of(draw, s)
    for c in CHANNELS:
        s.t[c][at : at + min(n, 5)] = s.t[c][at]


def numbers_missing(draw, s):
    c, n, at = _of(draw, s)
    s.y[c][:, at : at + n] = np.nan


def scattered_missing(draw, s):
    c, n, _ = _of(draw, s)
    s.y[c][:, draw.integers(0, s.t[c].size, n)] = np.nan


def infinite(draw, s):
    c, _, at = _of(draw, s)
    s.y[c][:, at] = np.inf


def gap(draw, s):
    _, n, at = _of(draw, s)
    _select(s, np.r_[0:at, at + n : s.t["force"].size])


def lost_in_one_channel(draw, s):
    c, n, _ = _of(draw, s)
    keep = np.setdiff1d(np.arange(s.t[c].size), draw.integers(0, s.t[c].size, n))
    if s.only_table:
        s.y[c][:, np.setdiff1d(np.arange(s.t[c].size), keep)] = np.nan
    else:
        _select(s, keep, (c,))


def clock_steps(draw, s):
    _, _, at = _of(draw, s)
    by = int(draw.choice([-1, 1])) * int(draw.integers(1, 10_000)) * 1_000_000
    for c in CHANNELS:
        s.t[c][at:] += by


def clock_of_one_channel_steps(draw, s):
    c, _, at = _of(draw, s)
    if not s.only_table:
        s.t[c][at:] += int(draw.choice([-1, 1])) * int(draw.integers(200, 10_000)) * 1_000_000


def out_of_order(draw, s):
    _, n, _ = _of(draw, s)
    index = np.arange(s.t["force"].size)
    for i in draw.integers(1, index.size - 1, min(n, 10)):
        index[[i, i - 1]] = index[[i - 1, i]]
    _select(s, index)


def jitter(draw, s):
    shift = np.rint(draw.normal(size=s.t["force"].size) * 0.08 * 1e7).astype(np.int64)
    # the sample was truly taken then: the values move along
    for c in CHANNELS:
        moved = s.t[c] + shift
        s.y[c] = np.array([np.interp(moved, s.t[c], row) for row in s.y[c]])
        s.t[c] = moved


def spike(draw, s):
    c, _, at = _of(draw, s)
    row = draw.integers(len(s.y[c]))
    width = int(draw.integers(1, 4))
    s.y[c][row, at : at + width] += draw.choice([-1, 1]) * draw.uniform(0.5, 50) * np.nanmax(np.abs(s.y[c]))


def frozen(draw, s):
    c, n, at = _of(draw, s)
    s.y[c][:, at : at + n + 15] = s.y[c][:, at : at + 1]


def saturated(draw, s):
    c, _, _ = _of(draw, s, "force", "taxels")
    s.y[c] = np.minimum(s.y[c], draw.uniform(0.6, 0.9) * np.nanmax(s.y[c]))


def dead_taxel(draw, s):
    s.y["taxels"][1] = draw.choice([0.0, np.nan, 3.3])


def dead_force(draw, s):
    s.y["force"][:] = draw.choice([0.0, np.nan, 3.3])


def wrong_sign(draw, s):
    c, _, _ = _of(draw, s, "force", "taxels")
    s.y[c] = -s.y[c]


def wrong_unit(draw, s):
    c, _, _ = _of(draw, s)
    s.y[c] = s.y[c] * (1000.0 if draw.integers(2) else 1e-3)


def file_cut_off(draw, s):
    s.cut = draw.uniform(0.0, 1.0)


def byte_flipped(draw, s):
    s.flip = int(draw.integers(0, 2**31))


def unit_left_out(draw, s):
    s.header[1 + draw.integers(2)] = ["x", "force"][draw.integers(2)]


def coarse_stamps(draw, s):
    for c in CHANNELS:
        s.t[c] = s.t[c] // 50_000_000 * 50_000_000


def empty_channel(draw, s):
    c, _, _ = _of(draw, s)
    if not s.only_table:
        _select(s, np.arange(0), (c,))


# In this order they are applied: the last two make the channels differ in length.
DEFECTS = [
    repeated_samples, repeated_stamps, numbers_missing, scattered_missing, infinite, gap, clock_steps, clock_of_one_channel_steps,
    out_of_order, jitter, spike, frozen, saturated, dead_taxel, dead_force, wrong_sign, wrong_unit, file_cut_off, byte_flipped,
    unit_left_out, coarse_stamps, lost_in_one_channel, empty_channel,
]  # fmt: skip


def write(s, path):
    """The session as a table or, by the suffixes .mcap and .db3, as a bag."""
    data = {".csv": _table, ".mcap": _mcap, ".db3": _sqlite}[path.suffix](s, path)
    data = bytearray(data[: int(s.cut * len(data))])
    if s.flip is not None and data:
        data[s.flip % len(data)] ^= 1 << (s.flip % 7)
    path.write_bytes(data)
    return path


def _table(s, path):
    n = min(s.t[c].size for c in CHANNELS)
    names = [*s.header, *(f"taxel_{i}_n" for i in range(len(s.y["taxels"])))]
    rows = np.vstack([(s.t["encoder"][:n] - START_NS) * 1e-9, 1e3 * s.y["encoder"][:, :n], s.y["force"][:, :n], s.y["taxels"][:, :n]])
    cells = (",".join("" if np.isnan(v) else f"{v:.9g}" for v in column) for column in rows.T)
    return "\n".join([",".join(names), *cells, ""]).encode()


def _mcap(s, path):
    store, templates = typestore(), _templates()
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=20_000, compression=CompressionType.LZ4)
        writer.start("ros2", "test")
        for c in CHANNELS:
            topic = f"/{c}"
            text = store.generate_msgdef(KINDS[topic], ros_version=2)[0].encode()
            line = writer.register_channel(topic, "cdr", writer.register_schema(KINDS[topic], "ros2msg", text))
            for log, data in _serialised(s, c, *templates[topic]):
                writer.add_message(line, log, data, START_NS)
        writer.finish()
    return path.read_bytes()


def _serialised(s, c, message, at):
    """Log time and bytes of every message of a channel."""
    for k, (stamp, values) in enumerate(zip(s.t[c].tolist(), s.y[c].T, strict=True)):
        data = bytearray(message)
        struct.pack_into("<iI", data, 4, stamp // 10**9, stamp % 10**9)
        data[at : at + 8 * values.size] = (-values if c == "force" else values).tobytes()
        yield int(s.log[c][k]), bytes(data)


TABLES = """
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL);
CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL, encoded_message_definition TEXT);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
"""


def _sqlite(s, path):
    path.unlink(missing_ok=True)
    store, templates, rows = typestore(), _templates(), []
    with closing(sqlite3.connect(path)) as db:
        db.executescript(TABLES)
        for number, c in enumerate(CHANNELS, 1):
            kind = KINDS[f"/{c}"]
            db.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr')", (number, f"/{c}", kind))
            text = store.generate_msgdef(kind, ros_version=2)[0]
            db.execute("INSERT INTO message_definitions VALUES (?, ?, 'ros2msg', ?)", (number, kind, text))
            rows += [(log, number, data) for log, data in _serialised(s, c, *templates[f"/{c}"])]
        rows.sort(key=lambda row: row[0])
        db.executemany("INSERT INTO messages (timestamp, topic_id, data) VALUES (?, ?, ?)", rows)
        db.commit()
    return path.read_bytes()


_TEMPLATES = {}


def _templates():
    """A message of every topic and where its numbers begin."""
    if not _TEMPLATES:
        from making import recording

        mark = 123.456
        r = recording(n=20, shares=(1.0, 0.4))
        r.depth[:], r.force[:], r.taxels[:] = mark, -mark, mark
        for topic, _, data in list(serialised(r))[:3]:
            _TEMPLATES[topic] = (data, data.index(struct.pack("<d", mark)))
    return _TEMPLATES
