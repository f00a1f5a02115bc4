"""The storage files of a bag as one: its topics, and their messages, which are passed to takers."""

import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import yaml

from skin_ident.recordings.decode import Topic
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.mcap_file import Channel, Survey, survey
from skin_ident.recordings.mcap_read import Add, read_messages
from skin_ident.recordings.places import Places
from skin_ident.recordings.sqlite_file import hand_over, missing_bytes, read_sqlite, survey_sqlite

METADATA = "metadata.yaml"
SUFFIXES = (".mcap", ".db3")


def is_bag(path: Path) -> bool:
    """Whether `path` is a rosbag2 directory or a storage file."""
    return path.suffix.lower() in SUFFIXES if path.is_file() else (path / METADATA).is_file() and bool(_files(path)[0])


def _files(folder: Path) -> tuple[list[Path], str]:
    """The files that the metadata of a bag names, in their order (all storage files, where it names none that exists), and the compression
    mode."""
    try:
        content = yaml.safe_load((folder / METADATA).read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
        names = [Path(str(name)).name for name in content["relative_file_paths"]]
        mode = str(content.get("compression_mode") or "").lower()
    except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError, AttributeError):
        names, mode = [], ""
    named = [folder / name for name in names if (folder / name).is_file()]
    there = (p for p in folder.iterdir() if p.suffix.lower() in SUFFIXES or p.suffixes[-2:-1] in ([s] for s in SUFFIXES))
    return named or sorted(there), mode


@dataclass
class File:
    """One storage file: its channels and counts by id; `survey` for MCAP only."""

    path: Path
    channels: dict[int, Channel]
    counts: dict[int, int]
    survey: Survey | None = None


@dataclass
class Storage:
    """An open bag. Use it in a `with` block, because decompressed files are temporary."""

    path: Path
    files: list[File] = field(default_factory=list)
    mode: str = ""
    warnings: tuple[str, ...] = ()
    _stack: ExitStack = field(default_factory=ExitStack)

    def __enter__(self) -> "Storage":
        """Open every file and find its topics. Raises `RecordingError`."""
        files, self.mode = ([self.path], "") if self.path.is_file() else _files(self.path)
        try:
            self.files = [self._open(file) for file in files]
        except BaseException:
            self._stack.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        """Remove decompressed files."""
        self._stack.close()

    def _open(self, path: Path) -> File:
        if path.suffix.lower() == ".zstd":
            path = self._unpacked(path)
        try:
            if path.suffix.lower() == ".db3":
                return File(path, *survey_sqlite(path))
            found = survey(path)
        except OSError as error:
            raise RecordingError(f"cannot read {path}: {error.strerror}") from error
        return File(path, found.channels, found.counts, found)

    def _unpacked(self, path: Path) -> Path:
        import zstandard

        folder = Path(self._stack.enter_context(tempfile.TemporaryDirectory()))
        target = folder / path.stem
        try:
            with path.open("rb") as packed, target.open("wb") as plain:
                zstandard.ZstdDecompressor().copy_stream(packed, plain)
        except zstandard.ZstdError as error:
            raise RecordingError(f"{path} cannot be decompressed: {error}") from error
        return target

    @property
    def attachments(self) -> dict[str, bytes]:
        """Attached files by name."""
        return {name: data for file in self.files if file.survey for name, data in file.survey.attachments.items()}

    @property
    def topics(self) -> dict[str, Topic]:
        """Topics by name, counts summed over the files."""
        out: dict[str, Topic] = {}
        for file in self.files:
            for number, c in file.channels.items():
                count = file.counts.get(number, 0) + (out[c.topic].count if c.topic in out else 0)
                out[c.topic] = Topic(c.topic, c.kind, c.definition, c.encoding, count)
        return out

    @property
    def cut_off(self) -> bool:
        """Whether one of the files is cut off or damaged."""
        return any(missing_bytes(file.path) > 0 if file.survey is None else file.survey.cut_at is not None for file in self.files)

    def read(self, takers: dict[str, Add]) -> tuple[str, ...]:
        """Pass the messages of the named topics to their takers, file by file; returns warnings."""
        return tuple(w for file in self.files for w in self._read_file(file, takers))

    def _read_file(self, file: File, takers: dict[str, Add]) -> tuple[str, ...]:
        mine = {number: takers[c.topic] for number, c in file.channels.items() if c.topic in takers}
        if file.survey is not None:
            if self.mode == "message":
                mine = {number: _unpacking(add) for number, add in mine.items()}
            return read_messages(file.survey, mine)
        return read_sqlite(file.path, mine, _unpacker() if self.mode == "message" else None)


def _unpacker() -> Callable[[bytes], bytes]:
    import zstandard

    return zstandard.ZstdDecompressor().decompress


def _unpacking(add: Add) -> Add:
    """A taker for messages that are compressed one by one; it passes them decompressed to `add`."""
    unpack = _unpacker()

    def taken(places: Places, sizes: np.ndarray, logs: np.ndarray) -> None:
        hand_over([(log, places.raw(i, size)) for i, (size, log) in enumerate(zip(sizes, logs, strict=True))], add, unpack)

    return taken
