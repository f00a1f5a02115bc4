"""A rosbag2 recording (MCAP) as the replay rig wants it: depth, force, taxels and layout, from our topics or from remapped ones."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from geometry_msgs.msg import WrenchStamped
from mcap.records import Channel, Message, Schema
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState
from skin_testbed_msgs.msg import TaxelArray, TaxelLayout

from skin_models.layout import Layout
from skin_models.ros.taxel_output import layout_of
from skin_models.words import counted
from skin_testbed_driver.bag_reading import records
from skin_testbed_driver.rig import RigError
from skin_testbed_driver.rigs.replay import Recorded, Track
from skin_testbed_driver.ros import JOINT

_TYPES = {"encoder": JointState, "force": WrenchStamped, "taxels": TaxelArray, "taxel_layout": TaxelLayout}


def read_bag(path: str, namespace: str = "") -> tuple[Recorded, Layout | None]:
    """The recording in a rosbag2 directory or .mcap file: its topics in `namespace`, else those in the outermost one.

    Raises `RigError` when it lacks `encoder` or `force`, has a topic of another type alone, or holds several rigs of which none was named.
    Of a file that is cut off or damaged, what can be read is there; the warnings say how much that is.
    """
    faults: list[str] = []
    foreign: dict[str, str] = {}
    heard = _heard(path, faults, foreign)
    for topic, said in foreign.items():
        if not heard[_role(topic)]:
            raise RigError(said)
    chosen, notes = _chosen(heard, namespace)
    notes += tuple(f"{said}: it was passed over" for said in foreign.values())
    found = {role: _samples(role, heard[role][chosen[role]]) for role in ("encoder", "force", "taxels") if role in chosen}
    for role in ("encoder", "force"):
        if not found.get(role):
            why = f" ({'; '.join(faults)})" if faults else ""
            where = f" in the namespace /{namespace.strip('/')}" if namespace else ""
            raise RigError(f"{path} holds no topic {role}{where}: nothing to replay{why}")
    layout = layout_of(heard["taxel_layout"][chosen["taxel_layout"]][-1]) if "taxel_layout" in chosen else None
    start = found["encoder"][0][0]
    tracks = {role: _track(samples, start) for role, samples in found.items() if samples}
    return Recorded(*tracks.values(), warnings=tuple(f"{fault}: {_read(tracks)}" for fault in faults) + notes), layout


def _heard(path: str, faults: list[str], foreign: dict[str, str]) -> dict[str, dict[str, list[Any]]]:
    """All messages by role and topic."""
    heard: dict[str, dict[str, list[Any]]] = {role: {} for role in _TYPES}
    for role, topic, message in _messages(path, faults, foreign):
        heard[role].setdefault(topic, []).append(message)
    return heard


def _chosen(heard: dict[str, dict[str, list[Any]]], namespace: str) -> tuple[dict[str, str], tuple[str, ...]]:
    """The topic of every role, as `fit` chooses: a simulated skin that was recorded beside the rig is not the rig. And warnings."""
    chosen, notes = {}, []
    for role, topics in heard.items():
        wanted = f"/{namespace.strip('/')}/{role}"
        there = [t for t in topics if t == wanted] if namespace else list(topics)
        outer = [t for t in there if t.count("/") == min(t.count("/") for t in there)]
        if len(outer) > 1:
            one = outer[0].rpartition("/")[0].strip("/")
            how = f"name the namespace of one, as in recording_namespace:={one}, or --namespace {one}"
            raise RigError(f"more than one topic could be {role}: {', '.join(sorted(outer))}; {how}")
        if outer:
            chosen[role] = outer[0]
        if len(there) > 1:
            notes.append(f"{role} is read from {outer[0]}, not from {', '.join(sorted(t for t in there if t != outer[0]))}")
    return chosen, tuple(notes)


def _samples(role: str, messages: list[Any]) -> list[tuple[int, Any]]:
    """Stamps (ns) and values: depth (m), compression (N), taxels (N)."""
    if role == "encoder":
        return [(_nanoseconds(m), m.position[m.name.index(JOINT)]) for m in messages if JOINT in m.name and len(m.position) == len(m.name)]
    if role == "force":
        return [(_nanoseconds(m), -m.wrench.force.z) for m in messages]
    return [(_nanoseconds(m), np.array(m.force)) for m in messages]


def _read(tracks: dict[str, Track]) -> str:
    """A clause that says how much of an incomplete recording was read."""
    counts = [f"{counted(track.t.size, 'sample')} of {role}" for role, track in tracks.items()]
    lacking = "" if "taxels" in tracks else ", and no taxels,"
    return f"{', '.join(counts)}{lacking} up to {tracks['encoder'].t[-1]:.2f} s were read; what is lost cannot be told"


def _messages(path: str, faults: list[str], foreign: dict[str, str]) -> Iterator[tuple[str, str, Any]]:
    """Messages of the topics that matter, each with its role (the last part of the topic's name) and the whole name of its topic.

    What a damaged file has lost is added to `faults`. Topics that have the name of a role but another type are added to `foreign`, each
    with a sentence about it: a bag may be anybody's.
    """
    for file in _files(path):
        schemas, channels = {}, {}
        for record in records(file, faults):
            if isinstance(record, Schema):
                schemas[record.id] = record.name
            elif isinstance(record, Channel):
                role = _role(record.topic)
                if role in _TYPES and (said := _foreign(record.topic, role, schemas.get(record.schema_id, "unknown"))):
                    foreign[record.topic] = said
                elif role in _TYPES:
                    channels[record.id] = role, record.topic, _TYPES[role]
            elif isinstance(record, Message) and record.channel_id in channels:
                role, topic, kind = channels[record.channel_id]
                yield role, topic, deserialize_message(record.data, kind)


def _files(path: str) -> list[Path]:
    if Path(path).is_dir() and not (files := sorted(Path(path).glob("*.mcap"))) and any(Path(path).glob("*.db3*")):
        raise RigError(f"{path} is a bag in sqlite3, and MCAP is replayed: make one of it with `ros2 bag convert`")
    if not Path(path).is_dir():
        files = [Path(path)]
    if not files or not files[0].is_file():
        raise RigError(f"there is no recording at {path}")
    return files


def _role(topic: str) -> str:
    return topic.rsplit("/", 1)[-1]


def _foreign(topic: str, role: str, name: str) -> str:
    """A sentence about a topic of another type than its role has; empty where the type is right."""
    kind = _TYPES[role]
    wanted = f"{kind.__module__.split('.')[0]}/msg/{kind.__name__}"
    return "" if name == wanted else f"topic {topic} has type {name}, and {role} is replayed from {wanted}"


def _nanoseconds(message: Any) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def _track(samples: list[tuple[int, Any]], start: int) -> Track:
    # Seconds since the start: a float holds those to the nanosecond, but not seconds since 1970.
    t, values = np.array([1e-9 * (s[0] - start) for s in samples]), np.array([s[1] for s in samples])
    grows = np.concatenate([[True], np.diff(np.maximum.accumulate(t)) > 0.0])
    return Track(t[grows], values[grows])
