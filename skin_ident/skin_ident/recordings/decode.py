"""How force, encoder and taxel topics are decoded: which numbers of which message type, and their unit."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.gather import Gatherer
from skin_models.words import counted

FORCE_TYPES = ("geometry_msgs/msg/WrenchStamped", "geometry_msgs/msg/Wrench", "std_msgs/msg/Float64", "std_msgs/msg/Float32")
DEPTH_TYPES = ("sensor_msgs/msg/JointState", "std_msgs/msg/Float64", "std_msgs/msg/Float32")
TAXEL_TYPES = ("skin_testbed_msgs/msg/TaxelArray", "std_msgs/msg/Float64MultiArray", "std_msgs/msg/Float32MultiArray")
LAYOUT_TYPE = "skin_testbed_msgs/msg/TaxelLayout"
JOINT = "indentation"
VALUES = {
    "WrenchStamped": ("wrench.force.z",),
    "Wrench": ("force.z",),
    "Float64": ("data",),
    "Float32": ("data",),
    "TaxelArray": ("force", "voltage"),
    "Float64MultiArray": ("data",),
    "Float32MultiArray": ("data",),
}

# For bags without message definitions (sqlite3 bags before Jazzy).
_OURS = {
    TAXEL_TYPES[0]: "std_msgs/Header header\nfloat64[] force\nfloat64[] voltage\nuint8[] status\n",
    LAYOUT_TYPE: "std_msgs/Header header\nstring[] names\ngeometry_msgs/Point[] positions\n"
    "geometry_msgs/Vector3[] normals\nfloat64[] area\n",
}


@dataclass(frozen=True)
class Topic:
    """One topic of a bag: name, type, its definition and the definition's format, number of messages."""

    name: str
    kind: str
    definition: str
    encoding: str
    count: int

    @property
    def short(self) -> str:
        """The type without its package."""
        return self.kind.rpartition("/")[2]


@dataclass(frozen=True)
class Decoded:
    """One topic as arrays: stamps (N,) ns (log time where the type has no header), log times (N,) ns, rows (R, N), unit."""

    topic: str
    stamp_ns: np.ndarray
    log_ns: np.ndarray
    stamped: bool
    rows: np.ndarray
    unit: str
    warnings: tuple[str, ...]


@dataclass
class Reader:
    """Reads single messages of one topic with rosbags' decoder; see `gather.Reader`. `wanted` is the joint to read, or the preferred field
    where several hold values."""

    topic: Topic
    wanted: str = ""
    chosen: str = ""

    def __post_init__(self) -> None:
        self.store, self.kind = typestore(self.topic), self.topic.kind
        self.definitions = self.store.fielddefs

    def path(self, raw: bytes) -> str:
        """The path of the field to read, a joint by its index. Raises `RecordingError` where the joint is not clear."""
        message = self.store.deserialize_cdr(raw, self.kind)
        if self.topic.short == "JointState":
            return f"position[{list(message.name).index(self._joint(message))}]"
        filled = [p for p in sorted(VALUES[self.topic.short], key=lambda p: p != self.wanted) if _at(message, p).size]
        numeric = [p for p in filled if np.isfinite(_at(message, p)).any()]
        self.chosen = (numeric or filled or list(VALUES[self.topic.short]))[0]
        return self.chosen

    def read(self, raw: bytes) -> tuple[np.ndarray, int]:
        """Values and stamp of one message."""
        message = self.store.deserialize_cdr(raw, self.kind)
        stamp = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec if hasattr(message, "header") else 0
        if self.topic.short == "JointState":
            return _at(message, "position")[[list(message.name).index(self._joint(message))]], stamp
        return _at(message, self.chosen), stamp

    def _joint(self, message: Any) -> str:
        names = list(message.name)
        self.wanted = self.wanted or (JOINT if JOINT in names else names[0] if len(names) == 1 else "")
        if self.wanted not in names:
            name, held = self.topic.name, ", ".join(names) or "none"
            raise RecordingError(f"{name} has the joints {held}: say which with --topics encoder={name}:JOINT")
        return self.wanted


def gatherer(topic: Topic, wanted: str = "") -> Gatherer:
    """What collects the messages of a force, encoder or taxel topic. Raises `RecordingError`."""
    return Gatherer(Reader(topic, wanted), topic.count)


def _at(message: Any, path: str) -> np.ndarray:
    for name in path.split("."):
        message = getattr(message, name)
    return np.atleast_1d(np.asarray(message, float))


def messages(topic: Topic, raws: list[bytes]) -> list[Any]:
    """Messages decoded by rosbags; damaged ones are left out."""
    store, out = typestore(topic), []
    for raw in raws:
        try:
            out.append(store.deserialize_cdr(raw, topic.kind))
        except Exception:  # generated code meets damaged bytes
            continue
    return out


def decoded(topic: Topic, g: Gatherer, log_time: bool = False) -> Decoded:
    """The samples of a topic, forces positive in compression. Raises `RecordingError` where none could be read."""
    if g.rows is None or not g.size:
        raise RecordingError(f"topic {topic.name} holds no message that can be decoded")
    rows = g.rows[: g.size].T
    warnings = [f"{topic.name}: {counted(g.lost, 'message')} could not be decoded"] if g.lost else []
    warnings += [f"{topic.name}: {counted(g.odd, 'message')} with another number of values than {len(rows)} dropped"] if g.odd else []
    if topic.short.startswith("Wrench"):
        np.negative(rows, out=rows)
    stamps = g.stamp_ns[: g.size]
    stamped = bool(stamps.any()) and not log_time
    logs, unit = g.log_ns[: g.size], "V" if g.chosen == "voltage" else ""
    return Decoded(topic.name, stamps if stamped else logs, logs, stamped, rows, unit, tuple(warnings))


def layout(topic: Topic, raws: list[bytes]) -> tuple[tuple[str, ...], tuple[tuple[float, float], ...]]:
    """Names and positions (mm) of the taxels from the last layout message."""
    found = messages(topic, raws)
    if not found:
        return (), ()
    return tuple(found[-1].names), tuple((1e3 * p.x, 1e3 * p.y) for p in found[-1].positions)


def typestore(topic: Topic) -> Any:
    """rosbags' decoder for a topic's type. Raises `RecordingError` where its definition cannot be understood."""
    return _typestore(topic.kind, topic.definition, topic.encoding)


@cache
def _typestore(kind: str, definition: str, encoding: str) -> Any:
    store = get_typestore(Stores.ROS2_JAZZY)
    text = definition or _OURS.get(kind, "")
    try:
        types = (get_types_from_idl(text) if encoding.endswith("idl") else get_types_from_msg(text, kind)) if text else {}
        store.register({name: fields for name, fields in types.items() if name not in store.fielddefs})
    except Exception as error:
        raise RecordingError(f"the definition of {kind} in the bag cannot be understood: {' '.join(str(error).split())}") from error
    if kind not in store.fielddefs:
        raise RecordingError(f"the bag brings no definition of {kind}")
    return store
