"""A rosbag2 recording (MCAP) as the replay rig wants it: depth, force, taxels and layout, from our topics or from remapped ones."""

import importlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mcap.exceptions import McapError
from mcap.stream_reader import StreamReader
from rclpy.serialization import deserialize_message

from skin_models.layout import Layout
from skin_models.ros.taxel_output import layout_of
from skin_testbed_driver.rig import RigError
from skin_testbed_driver.rigs.replay import Recorded, Track
from skin_testbed_driver.ros import JOINT


def read_bag(path: str) -> tuple[Recorded, Layout | None]:
    """The recording in a rosbag2 directory or .mcap file. Raises `RigError` when it lacks `encoder` or `force`."""
    found: dict[str, list[tuple[int, Any]]] = {"encoder": [], "force": [], "taxels": []}
    layout = None
    for role, message in _messages(path):
        if role == "taxel_layout":
            layout = layout_of(message)
        elif role == "encoder" and JOINT in message.name:
            found[role].append((_nanoseconds(message), message.position[message.name.index(JOINT)]))
        elif role == "force":
            found[role].append((_nanoseconds(message), -message.wrench.force.z))
        elif role == "taxels":
            found[role].append((_nanoseconds(message), np.array(message.force)))
    for role in ("encoder", "force"):
        if not found[role]:
            raise RigError(f"{path} holds no topic {role}: nothing to replay")
    start = found["encoder"][0][0]
    tracks = [_track(found[role], start) for role in ("encoder", "force", "taxels") if found[role]]
    return Recorded(*tracks), layout


def _messages(path: str) -> Iterator[tuple[str, Any]]:
    """Messages of the topics that matter, each with the last part of its name. A truncated file gives what it holds."""
    schemas, channels = {}, {}
    for file in _files(path):
        try:
            with file.open("rb") as stream:
                for record in StreamReader(stream).records:
                    kind = type(record).__name__
                    if kind == "Schema":
                        schemas[record.id] = record.name
                    elif kind == "Channel":
                        channels[record.id] = (record.topic.rsplit("/", 1)[-1], schemas[record.schema_id])
                    elif kind == "Message" and channels[record.channel_id][0] in ("encoder", "force", "taxels", "taxel_layout"):
                        role, name = channels[record.channel_id]
                        yield role, deserialize_message(record.data, _class(name))
        except (McapError, OSError) as error:
            if not channels:
                raise RigError(f"{file} is no MCAP file that can be read: {error}") from error


def _files(path: str) -> list[Path]:
    files = sorted(Path(path).glob("*.mcap")) if Path(path).is_dir() else [Path(path)]
    if not files or not files[0].is_file():
        raise RigError(f"there is no recording at {path}")
    return files


def _class(name: str) -> type:
    package, kind, message = name.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), message)


def _nanoseconds(message: Any) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def _track(samples: list[tuple[int, Any]], start: int) -> Track:
    # Seconds since the start: a float holds those to the nanosecond, but not seconds since 1970.
    t, values = np.array([1e-9 * (s[0] - start) for s in samples]), np.array([s[1] for s in samples])
    grows = np.concatenate([[True], np.diff(np.maximum.accumulate(t)) > 0.0])
    return Track(t[grows], values[grows])
