"""Serialised messages to arrays: what a force, encoder or taxel topic holds, whichever of the known types it has."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.storage import RawTopic
from skin_ident.recordings.timing import counted

FORCE_TYPES = ("geometry_msgs/msg/WrenchStamped", "geometry_msgs/msg/Wrench", "std_msgs/msg/Float64", "std_msgs/msg/Float32")
DEPTH_TYPES = ("sensor_msgs/msg/JointState", "std_msgs/msg/Float64", "std_msgs/msg/Float32")
TAXEL_TYPES = ("skin_testbed_msgs/msg/TaxelArray", "std_msgs/msg/Float64MultiArray", "std_msgs/msg/Float32MultiArray")
LAYOUT_TYPE = "skin_testbed_msgs/msg/TaxelLayout"
JOINT = "indentation"

# For bags that bring no definitions along (sqlite3 bags before Jazzy).
_OURS = {
    TAXEL_TYPES[0]: "std_msgs/Header header\nfloat64[] force\nfloat64[] voltage\nuint8[] status\n",
    LAYOUT_TYPE: "std_msgs/Header header\nstring[] names\ngeometry_msgs/Point[] positions\n"
    "geometry_msgs/Vector3[] normals\nfloat64[] area\n",
}


@dataclass(frozen=True)
class Decoded:
    """One topic as arrays: stamps (N,) ns (log time where the type has no header), rows (R, N), unit, names of the rows."""

    topic: str
    stamp_ns: np.ndarray
    stamped: bool
    rows: np.ndarray
    unit: str
    names: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


def decode(topic: RawTopic, joint: str = "") -> Decoded:
    """The samples of a force, encoder or taxel topic. Raises `RecordingError` for a type that is none of these."""
    readers: dict[str, Callable[[Any], Any]] = {
        "WrenchStamped": lambda m: [-m.wrench.force.z],
        "Wrench": lambda m: [-m.force.z],
        "Float64": lambda m: [m.data],
        "Float32": lambda m: [m.data],
        "Float64MultiArray": lambda m: m.data,
        "Float32MultiArray": lambda m: m.data,
        "TaxelArray": lambda m: m.force,
    }
    name = topic.type.rpartition("/")[2]
    messages, lost = _deserialised(topic)
    if name == "JointState":
        index, label = _joint(topic, messages, joint)
        readers["JointState"] = lambda m: m.position[index : index + 1]
    if name not in readers and name != "JointState":
        raise RecordingError(f"topic {topic.name} has type {topic.type}, which is neither force, encoder nor taxels")
    rows, keep, warnings = _even_width(topic, [readers[name](m) for m in messages])
    unit, names = ("m", (label,)) if name == "JointState" else ("", ())
    if name == "TaxelArray" and not np.isfinite(rows).any() and any(len(m.voltage) for m in messages):
        (rows, keep, warnings), unit = _even_width(topic, [m.voltage for m in messages]), "V"
    stamps, stamped = _stamps(topic, messages)
    return Decoded(topic.name, stamps[keep], stamped, rows, unit, names, (*lost, *warnings))


def layout(topic: RawTopic) -> tuple[tuple[str, ...], tuple[tuple[float, float], ...]]:
    """Names and positions (mm) of the taxels from the last layout message."""
    messages, _ = _deserialised(topic)
    if not messages:
        return (), ()
    return tuple(messages[-1].names), tuple((1e3 * p.x, 1e3 * p.y) for p in messages[-1].positions)


def _deserialised(topic: RawTopic) -> tuple[list[Any], tuple[str, ...]]:
    store = _typestore(topic.type, topic.definition, topic.encoding)
    messages, log_ns = [], []
    for stamp, raw in zip(topic.log_ns, topic.messages, strict=True):
        try:
            messages.append(store.deserialize_cdr(raw, topic.type))
            log_ns.append(stamp)
        except Exception:  # the decoder is generated code: damaged bytes can end in any exception
            continue
    lost = len(topic.messages) - len(messages)
    topic.log_ns = log_ns
    return messages, (f"{topic.name}: {counted(lost, 'message')} could not be decoded",) if lost else ()


@cache
def _typestore(kind: str, definition: str, encoding: str) -> Any:
    store = get_typestore(Stores.ROS2_JAZZY)
    text = definition or _OURS.get(kind, "")
    try:
        types = get_types_from_idl(text) if encoding.endswith("idl") else get_types_from_msg(text, kind)
        store.register({name: fields for name, fields in types.items() if name not in store.fielddefs})
    except Exception as error:
        raise RecordingError(f"the definition of {kind} in the bag cannot be understood: {' '.join(str(error).split())}") from error
    if kind not in store.fielddefs:
        raise RecordingError(f"the bag brings no definition of {kind}")
    return store


def _joint(topic: RawTopic, messages: list[Any], wanted: str) -> tuple[int, str]:
    names = list(messages[0].name) if messages else []
    choice = wanted or (JOINT if JOINT in names else names[0] if len(names) == 1 else "")
    if choice not in names:
        held = ", ".join(names) or "none"
        raise RecordingError(f"{topic.name} has the joints {held}: say which with --topics encoder={topic.name}:JOINT")
    return names.index(choice), choice


def _even_width(topic: RawTopic, rows: list[Any]) -> tuple[np.ndarray, np.ndarray, tuple[str, ...]]:
    """Rows (R, N) of the messages that have the usual length, which those are, and a warning about the others."""
    widths = np.array([len(row) for row in rows], int)
    if not widths.size:
        raise RecordingError(f"topic {topic.name} holds no message")
    usual = int(np.bincount(widths).argmax())
    keep = widths == usual
    if keep.mean() < 0.9:
        raise RecordingError(f"{topic.name}: the number of values changes from message to message")
    values = np.array([row for row, k in zip(rows, keep, strict=True) if k], float).reshape(-1, usual).T
    odd = int((~keep).sum())
    return values, keep, (f"{topic.name}: {counted(odd, 'message')} of another length than {usual} dropped",) if odd else ()


def _stamps(topic: RawTopic, messages: list[Any]) -> tuple[np.ndarray, bool]:
    log_ns = np.array(topic.log_ns, np.int64)
    if not messages or not hasattr(messages[0], "header"):
        return log_ns, False
    stamps = np.array([m.header.stamp.sec * 1_000_000_000 + m.header.stamp.nanosec for m in messages], np.int64)
    return (stamps, True) if np.any(stamps) else (log_ns, False)
