"""Ten minutes at 1 kHz: force, encoder and 64 taxels, 1.8 million messages, as a bare .mcap. Used by bench_reading.py."""

import struct
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

TAXEL_ARRAY = "std_msgs/Header header\nfloat64[] force\nfloat64[] voltage\nuint8[] status\n"
KINDS = {
    "/encoder": "sensor_msgs/msg/JointState",
    "/force": "geometry_msgs/msg/WrenchStamped",
    "/taxels": "skin_testbed_msgs/msg/TaxelArray",
}
CHUNK = 768 * 1024  # rosbag2's own


def make(path: Path, compression: str, seconds: float = 600.0, rate: float = 1000.0, taxels: int = 64) -> Path:
    """Write the bag. The numbers carry the noise and the steps of a 12-bit converter, so that they compress as real ones do."""
    n = int(seconds * rate)
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(TAXEL_ARRAY, KINDS["/taxels"]))
    templates = {topic: _template(store, topic, taxels) for topic in KINDS}
    rng = np.random.default_rng(0)
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=CHUNK, compression=CompressionType[compression])
        writer.start("ros2", "bench")
        lines = {}
        for topic, kind in KINDS.items():
            schema = writer.register_schema(kind, "ros2msg", store.generate_msgdef(kind, ros_version=2)[0].encode())
            lines[topic] = writer.register_channel(topic, "cdr", schema)
        for start in range(0, n, 10_000):
            for stamp, topic, data in _block(templates, rng, start, min(10_000, n - start), rate, taxels):
                writer.add_message(lines[topic], stamp, data, stamp)
        writer.finish()
    return path


def _template(store, topic: str, taxels: int) -> tuple[bytearray, int]:
    """A message and where its numbers begin."""
    t, mark = store.types, 123.456
    header = t["std_msgs/msg/Header"](t["builtin_interfaces/msg/Time"](0, 0), "skin")
    vector, none = t["geometry_msgs/msg/Vector3"], np.array([])
    message = {
        "/encoder": lambda: t[KINDS["/encoder"]](header, ["indentation"], np.array([mark]), none, none),
        "/force": lambda: t[KINDS["/force"]](header, t["geometry_msgs/msg/Wrench"](vector(0, 0, mark), vector(0, 0, 0))),
        "/taxels": lambda: t[KINDS["/taxels"]](header, np.full(taxels, mark), none, np.zeros(taxels, np.uint8)),
    }[topic]()
    raw = bytearray(store.serialize_cdr(message, KINDS[topic]))
    return raw, raw.index(struct.pack("<d", mark))


def _block(templates, rng, start: int, count: int, rate: float, taxels: int):
    t = (start + np.arange(count)) / rate
    depth = 5e-4 + 3e-4 * np.sin(2 * np.pi * 0.25 * t)
    shares = np.exp(-np.arange(taxels) / 12.0)
    values = {
        "/encoder": np.rint((depth + 2e-7 * rng.normal(size=count)) / 1e-7)[:, None] * 1e-7,
        "/force": -np.rint((1.2e4 * depth + 0.03 * rng.normal(size=count)) / 0.0678)[:, None] * 0.0678,
        "/taxels": np.rint((np.outer(9.6e3 * depth, shares) + 0.03 * rng.normal(size=(count, taxels))) / 0.107) * 0.107,
    }
    for i in range(count):
        stamp = 1_700_000_000_000_000_000 + round((start + i) * 1e9 / rate)
        for topic, rows in values.items():
            raw, at = templates[topic]
            struct.pack_into("<iI", raw, 4, stamp // 10**9, stamp % 10**9)
            raw[at : at + 8 * rows.shape[1]] = rows[i].tobytes()
            yield stamp, topic, bytes(raw)
