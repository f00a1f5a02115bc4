"""One call for every kind of recording: `load(paths)`."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from skin_ident.recordings.bag import read_bag
from skin_ident.recordings.declared import FILE_NAME, declared_beside
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.spread_table import is_spread_scan, read_spread_scan
from skin_ident.recordings.storage import METADATA, is_bag
from skin_ident.recordings.storage import SUFFIXES as BAGS
from skin_ident.recordings.table import read_table
from skin_models.errors import TableError
from skin_models.tables.text import SUFFIXES as TABLES
from skin_models.tables.text import read_text

RECORDED = (*BAGS, *TABLES)  # suffixes of files that may be recordings


def load(
    paths: Iterable[str | Path] | str | Path, topics: Mapping[str, str] | None = None, log_time: bool = False, keep: bool = False
) -> list[Any]:
    """Every recording in files and folders: `Recording` for sessions, `SpreadScan` for static spread scans.

    A folder stands for all recordings in it, in the order of names. `topics` maps force, encoder and taxels to topic names of bags;
    `log_time` takes the times at which messages were recorded instead of their stamps; `keep` leaves uneven stamps as they are
    instead of resampling. Raises `RecordingError` naming the file and what is wrong with it.
    """
    paths = [paths] if isinstance(paths, (str, Path)) else list(paths)
    files = [file for path in paths for file in find(path)]
    return [load_one(file, topics, log_time, keep) for file in files]


def find(path: str | Path) -> list[Path]:
    """The recordings at a path: itself, or all in a folder. Raises `RecordingError` where there is none."""
    if path == "":
        raise RecordingError("the name of a recording is empty")
    path = Path(path)
    try:
        return _found(path)
    except OSError as error:
        raise RecordingError(f"cannot look into {path}: {error.strerror}") from error


def _found(path: Path) -> list[Path]:
    if not path.exists():
        raise RecordingError(f"{path} {'is a link to nothing' if path.is_symlink() else 'does not exist'}")
    if path.is_file() or (path.is_dir() and is_bag(path)):
        return [path]
    if not path.is_dir():
        raise RecordingError(f"{path} is neither a file nor a folder")
    found = _within(path)
    if not found and (path / METADATA).is_file():
        raise RecordingError(f"{path} holds the {METADATA} of a recording, but its recording file ({' or '.join(BAGS)}) is missing")
    if not found:
        raise RecordingError(f"{path} holds no recording: no rosbag2 directory, .mcap, or table ({', '.join(TABLES)})")
    return found


def _within(folder: Path) -> list[Path]:
    found = []
    for entry in sorted(folder.iterdir()):
        if entry.name.startswith("."):
            continue
        if entry.is_dir():
            found += [entry] if is_bag(entry) else _within(entry)
        elif entry.suffix.lower() in RECORDED and not _is_prose(entry):
            found.append(entry)
    return found


def _is_prose(file: Path) -> bool:
    """Whether a text file is no table but prose, such as a README.txt beside the recordings: its second line holds no number."""
    if file.suffix.lower() not in (".txt", ".dat"):
        return False
    with file.open(encoding="utf-8", errors="replace") as lines:
        second = [line for _, line in zip(range(20), lines, strict=False) if line.strip() and not line.startswith("#")][1:2]
    return not any(cell.strip().lstrip("+-.")[:1].isdigit() for line in second for cell in line.split(max("\t,;", key=line.count)))


def load_one(path: Path, topics: Mapping[str, str] | None = None, log_time: bool = False, keep: bool = False) -> Any:
    """One recording, as `load` gives it. Raises `RecordingError`."""
    try:
        return _loaded(path, topics, log_time, keep)
    except TableError as error:
        raise RecordingError(str(error)) from error
    except OSError as error:
        raise RecordingError(f"cannot read {path}: {error.strerror}") from error


def _loaded(path: Path, topics: Mapping[str, str] | None, log_time: bool, keep: bool) -> Any:
    if not path.exists():
        raise RecordingError(f"{path} {'is a link to nothing' if path.is_symlink() else 'does not exist'}")
    if path.name in ("", ".."):  # a folder as seen from within: its name and what lies beside it are wanted
        path = path.resolve()
    declared = declared_beside(path)
    if is_bag(path):
        return read_bag(path, declared, topics, log_time, keep)
    if path.name == FILE_NAME or path.suffix.lower() not in TABLES:
        raise RecordingError(f"{path} is no recording: a rosbag2 directory, an .mcap file or a table is expected")
    text = read_text(path)
    return read_spread_scan(path, declared) if is_spread_scan(text) else read_table(path, declared, keep, text)
