"""A rosbag2 directory with one MCAP file, written so that a crash costs at most the last moments.

A chunk ends, and is in the hands of the operating system, as soon as its first message is `HELD` old: `write` sees to that before it
returns, and `flush_if_due` where no more messages come. So `kill -9` takes no more than the last `HELD` of what was given to `write`,
however busy the machine is; a streaming reader gets everything before. metadata.yaml is there from the first topic on, and final after
`close`.
"""

import errno
import math
import os
import shutil
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from mcap.writer import CompressionType, Writer

from skin_models.errors import SkinError

HELD = 0.2  # s, for which a message may be held back, to be compressed together with others
_METADATA_VERSION = 9  # of rosbag2 in Jazzy
# rosbag2 reads lz4 and zstd; at these sizes both are quick, and zstd gets by with half the disk.
_COMPRESSION = CompressionType.ZSTD


class BagError(SkinError):
    """The recording cannot be begun or continued."""


@dataclass(frozen=True)
class TopicInfo:
    """What a bag says of a topic. `qos` is a list of mappings in rosbag2's form, `type_hash` REP-2016's RIHS01 string or empty."""

    name: str
    type: str
    definition: str
    qos: tuple[dict[str, Any], ...] = ()
    type_hash: str = ""


class _Stream:
    """Holds what the MCAP writer writes until `flush` puts all of it on disk, or nothing of it."""

    def __init__(self, path: Path) -> None:
        """Create the file, which must not exist."""
        self._file = path.open("xb", buffering=0)
        self._parts: list[bytes] = []
        self._end = self._safe = 0

    def write(self, data: bytes) -> int:
        """Hold `data`."""
        self._parts.append(data)
        self._end += len(data)
        return len(data)

    def tell(self) -> int:
        """Where the next byte will be."""
        return self._end

    def flush(self) -> None:
        """Raises `OSError`, and leaves the file as it was at the last flush."""
        data = memoryview(b"".join(self._parts))
        try:
            while data:
                data = data[self._file.write(data) :]
        except OSError:
            self._file.truncate(self._safe)  # half a record would end a reader with an error
            raise
        self._parts.clear()
        self._safe = self._end
        if not os.fstat(self._file.fileno()).st_nlink:
            raise OSError(errno.ENOENT, "the file was deleted while it was being recorded")

    def close(self) -> None:
        """Close the file; what is held is lost."""
        self._file.close()


class BagWriter:
    """Writes messages that are serialised already. One thread at a time. Every method raises `BagError` when the disk refuses."""

    def __init__(self, directory: str | os.PathLike, kept: str = "what was written before stays readable") -> None:
        """Create `directory`, which must not exist. `kept` says what is left of it when the disk refuses to take more."""
        self._kept = kept
        self.directory = Path(directory)
        if self.directory.exists():
            raise BagError(f"{self.directory} exists already: choose another name, a recording is never overwritten")
        try:
            self.directory.mkdir(parents=True)
            self._path = self.directory / f"{self.directory.name}_0.mcap"
            self._stream = _Stream(self._path)
        except OSError as error:
            raise BagError(f"cannot begin a recording in {self.directory}: {error.strerror}") from error
        self._writer = Writer(self._stream, compression=_COMPRESSION, enable_data_crcs=False)
        self._schemas: dict[str, int] = {}
        self._topics: list[TopicInfo] = []
        self.counts: list[int] = []
        self._first, self._last = 2**63 - 1, 0
        self._stale = True  # a topic that metadata.yaml does not have yet
        self._due = math.inf  # s, monotonic: when the first message that is not on disk has been held for `HELD`
        self._guarded(self._writer.start, profile="ros2", library="skin_testbed_driver recorder")
        self.flush()

    def add_topic(self, topic: TopicInfo) -> int:
        """Announce a topic; gives its index for `write`."""
        if topic.type not in self._schemas:
            encoding = "ros2msg" if topic.definition else ""
            definition = topic.definition.encode()
            self._schemas[topic.type] = self._guarded(self._writer.register_schema, topic.type, encoding, definition)
        profiles = _yaml(list(topic.qos)) if topic.qos else ""
        metadata = {"offered_qos_profiles": profiles, "topic_type_hash": topic.type_hash}
        # Channels are numbered from 1, in the order of their registration.
        self._guarded(self._writer.register_channel, topic.name, "cdr", self._schemas[topic.type], metadata)
        self._topics.append(topic)
        self.counts.append(0)
        self._stale = True
        return len(self._topics) - 1

    def write(self, topic: int, data: bytes, log_time: int, publish_time: int) -> None:
        """One message; times in ns. `topic` is what `add_topic` gave."""
        self.counts[topic] += 1
        self._first, self._last = min(self._first, log_time), max(self._last, log_time)
        self._guarded(self._writer.add_message, topic + 1, log_time, data, publish_time, self.counts[topic])
        self._hold()

    def heard(self) -> set[str]:
        """The topics of which there are messages."""
        return {topic.name for topic, count in zip(self._topics, self.counts, strict=True) if count}

    def attach(self, name: str, media_type: str, data: bytes, when: int) -> None:
        """Put a file inside the recording, and a copy beside it; `when` in ns."""
        self._guarded(self._writer.add_attachment, when, when, name, media_type, data)
        self._hold()
        self._guarded((self.directory / name).write_bytes, data)

    def note(self, name: str, entries: dict[str, str]) -> None:
        """Put named texts inside the recording."""
        self._guarded(self._writer.add_metadata, name, entries)
        self._hold()

    def _hold(self) -> None:
        """Something was given: hold it back for a while, unless something has been held for that long already."""
        now = time.monotonic()
        if now >= self._due:
            self.flush()
        elif self._due == math.inf:
            self._due = now + HELD

    def flush_if_due(self) -> None:
        """As `flush`, if something has been held back for `HELD` (s)."""
        if time.monotonic() >= self._due or self._stale:
            self.flush()

    def flush(self) -> None:
        """Make everything so far survive the end of this process."""
        self._due = math.inf
        self._guarded(self._writer.flush)
        if self._stale:
            self._guarded(self._write_metadata)

    def close(self) -> None:
        """Finish the file and its metadata."""
        try:
            self.note("rosbag2", {"serialized_metadata": _yaml(self._information())})
            self._guarded(self._writer.finish)
            self._guarded(self._stream.flush)
            self._guarded(self._write_metadata)
        finally:
            self._stream.close()

    def remove(self) -> None:
        """Leave nothing of a closed recording, so that the next one may have its name."""
        self._guarded(shutil.rmtree, self.directory)

    def _guarded(self, action, *args, **kwargs):
        try:
            return action(*args, **kwargs)
        except OSError as error:
            words = "the disk is full" if error.errno == errno.ENOSPC else (error.strerror or str(error))
            kept = "" if error.errno == errno.ENOENT else f"; {self._kept}"
            raise BagError(f"recording to {self.directory} ended: {words}{kept}") from error

    def _write_metadata(self) -> None:
        content = _yaml({"rosbag2_bagfile_information": self._information()})
        partial = self.directory / "metadata.yaml.partial"
        partial.write_text(content, encoding="utf-8")
        partial.replace(self.directory / "metadata.yaml")
        self._stale = False

    def _information(self) -> dict[str, Any]:
        count = sum(self.counts)
        start, end = (self._first, self._last) if count else (0, 0)

        def span() -> dict[str, Any]:  # made twice: YAML writes what it meets again as a reference
            return {
                "starting_time": {"nanoseconds_since_epoch": start},
                "duration": {"nanoseconds": end - start},
                "message_count": count,
            }

        return {
            "version": _METADATA_VERSION,
            "storage_identifier": "mcap",
            "relative_file_paths": [self._path.name],
            **span(),
            "topics_with_message_count": [_topic_entry(t, n) for t, n in zip(self._topics, self.counts, strict=True)],
            "compression_format": "",
            "compression_mode": "",
            "files": [{"path": self._path.name, **span()}],
            "custom_data": None,
            "ros_distro": "jazzy",
        }


def _topic_entry(topic: TopicInfo, count: int) -> dict[str, Any]:
    metadata = {
        "name": topic.name,
        "type": topic.type,
        "serialization_format": "cdr",
        "offered_qos_profiles": [dict(q) for q in topic.qos],
        "type_description_hash": topic.type_hash,
    }
    return {"topic_metadata": metadata, "message_count": count}


def _yaml(content: Any) -> str:
    return yaml.dump(content, Dumper=getattr(yaml, "CSafeDumper", yaml.SafeDumper), sort_keys=False)
