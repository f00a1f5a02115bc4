"""What all command lines share: one clear sentence and status 2 for bad input, nothing half written, progress to stderr."""

import argparse
import ctypes
import json
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NoReturn

from skin_ident.recordings.bag import by_role
from skin_ident.recordings.errors import RecordingError
from skin_models.errors import SkinError
from skin_models.whole_file import whole_file

FINDINGS = "findings.json"
WRITTEN_OVER = ("model.yaml", "baseline.yaml", "report.html")  # what a diagnosis writes beside its findings, under names that others use
UNUSABLE = 2
INTERRUPTED = 130
M_TRIM_THRESHOLD, M_MMAP_MAX = -1, -4  # of mallopt(3)

_given: dict[Path, bool] = {}  # folders to write into, and those around them, outermost first; whether this command made them


def run(main: Callable[[Sequence[str] | None], int], arguments: Sequence[str] | None = None) -> int:
    """Call `main`; a `SkinError`, or what the system refuses, becomes one line on stderr and status 2, Ctrl-C status 130."""
    _given.clear()
    _keep_memory()
    try:
        status = main(arguments)
        sys.stdout.flush()  # here, where a full disk can still be told of
        return status
    except SkinError as error:
        _without_empty_folders()
        clear_line()
        print(f"error: {error}", file=sys.stderr)
        return UNUSABLE
    except KeyboardInterrupt:
        left = _without_empty_folders()
        clear_line()
        print(f"interrupted; {f'what was written until then is in {left[-1]}' if left else 'nothing was written'}", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # the reader of our output went away, as `head` does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        _without_empty_folders()
        clear_line()
        print(f"error: {refusal(error)}", file=sys.stderr)
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return UNUSABLE


def _keep_memory() -> None:
    """Ask glibc to keep what is freed for what is allocated next; other C libraries lack these options. Every survey of a long recording
    needs hundreds of megabytes: to get them from the system as empty pages each time takes an eighth of a diagnosis."""
    with suppress(AttributeError, OSError, TypeError):
        mallopt = ctypes.CDLL(None).mallopt
        mallopt(M_MMAP_MAX, 0)
        mallopt(M_TRIM_THRESHOLD, 2**31 - 1)


class Parser(argparse.ArgumentParser):
    """Reports wrong arguments as all other errors are reported: in one line."""

    def error(self, message: str) -> NoReturn:
        """Raises `RecordingError`."""
        raise RecordingError(f"{' '.join(message.split())} (see --help)")


def refusal(error: OSError) -> str:
    """What the system refused, in one sentence: a full disk, a missing right, a device that failed."""
    where = f" ({error.filename})" if error.filename else ""
    return f"{error.strerror or error}{where}"


def add_recordings(parser: argparse.ArgumentParser) -> None:
    """The arguments that say what to read."""
    parser.add_argument("recordings", nargs="+", metavar="RECORDING", help="rosbag2 directory, .mcap, table, or a folder of them")
    parser.add_argument(
        "--topics", nargs="+", default=[], metavar="ROLE=TOPIC", help="topics of bags: force=/ft encoder=/joint_states:joint taxels=/skin"
    )
    parser.add_argument("--log-time", action="store_true", help="take the times of recording, not the stamps in the messages")


def topics_of(pairs: Sequence[str]) -> dict[str, str]:
    """`["force=/ft"]` as a mapping. Raises `RecordingError`, also for a role that no recording has."""
    broken = [pair for pair in pairs if not all(pair.partition("="))]
    if broken:
        raise RecordingError(f"--topics takes pairs such as force=/ft, not {broken[0]!r}")
    roles = [pair.partition("=")[0] for pair in pairs]
    twice = [role for role in roles if roles.count(role) > 1]
    if twice:
        raise RecordingError(f"--topics names {twice[0]} twice")
    topics = dict(pair.split("=", 1) for pair in pairs)
    by_role(topics)  # here, for tables do not ask
    return topics


def check_output(path: str) -> None:
    """Refuse an output folder that cannot be made or written, before any work; leaves nothing there. Raises `RecordingError`."""
    if not path:
        raise RecordingError("--out needs a name, and got an empty text")
    folder = Path(path).absolute()
    near = next(p for p in (folder, *folder.parents) if p.exists())
    if not near.is_dir():
        raise RecordingError(f"cannot write into {path}: {near} is a file")
    try:
        with tempfile.TemporaryDirectory(dir=near):  # rights alone do not tell: a disk may be full, and /proc takes nothing from anybody
            pass
    except OSError as error:
        raise RecordingError(f"cannot write into {path}: nothing can be made in {near} ({error.strerror})") from error


def check_empty(path: str) -> None:
    """As `check_output`, and refuse a folder that holds anything: what is written there would lie among it, or in its place. Raises
    `RecordingError`."""
    check_output(path)
    first = min(Path(path).glob("*"), default=None)
    if first is not None:
        raise RecordingError(f"--out {path} already holds {first.name}, and nothing is overwritten: name a folder that is new or empty")


def check_no_answer(path: str) -> None:
    """Refuse a folder with the findings of a diagnosis: a model written there would pass for the one they are about. Raises
    `RecordingError`."""
    if (Path(path) / FINDINGS).exists():
        raise RecordingError(f"{path} holds the answer of a diagnosis ({FINDINGS}), whose model.yaml must stay: name another folder")


def check_no_model(path: str) -> None:
    """Refuse a folder with a model, or a report, but without findings: it is a fit's, or somebody's own, and a diagnosis would write over
    it. Raises `RecordingError`."""
    theirs = [name for name in WRITTEN_OVER if (Path(path) / name).exists()]
    if theirs and not (Path(path) / FINDINGS).exists():
        raise RecordingError(f"{path} holds {theirs[0]}, which no diagnosis wrote (there is no {FINDINGS}): name another folder")


def output_folder(path: str) -> Path:
    """The folder to write into, made if it is missing. Raises `RecordingError` where that is not possible."""
    check_output(path)
    folder = Path(path)
    missing = [p for p in reversed(folder.absolute().parents) if not p.exists()]
    _given.update(dict.fromkeys(missing, True) | {folder.absolute(): not folder.exists()})
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RecordingError(f"cannot write into {path}: {error.strerror}") from error
    return folder


@contextmanager
def whole_folder(path: str) -> Iterator[Path]:
    """As `output_folder`; where writing fails or is stopped, a folder that was made for it goes again, with all that is in it."""
    folder = output_folder(path)
    try:
        yield folder
    except BaseException:
        if _given[folder.absolute()]:
            shutil.rmtree(folder, ignore_errors=True)
        raise


def _without_empty_folders() -> list[Path]:
    """Remove the empty folders that this command made. Returns those of its output folders that hold something then, outermost first."""
    for folder in reversed([folder for folder, new in _given.items() if new]):
        with suppress(OSError):  # something is in it
            folder.rmdir()
    return [folder for folder in _given if folder.is_dir() and any(folder.iterdir())]


def check_seed(seed: int, most: int | None = None) -> None:
    """Refuse a seed that no generator takes, or that is above `most`. Raises `RecordingError`."""
    if seed < 0 or (most is not None and seed > most):
        raise RecordingError(f"--seed is a whole number from 0 {'up' if most is None else f'to {most}'}, not {seed}")


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a JSON file whole or not at all; NaN and infinity become null. Raises `OSError`."""
    text = json.dumps(_plain(content), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    with whole_file(path) as partial:
        partial.write_text(text, encoding="utf-8")


def _plain(thing: Any) -> Any:
    if isinstance(thing, Mapping):
        return {str(key): _plain(value) for key, value in thing.items()}
    if hasattr(thing, "tolist"):
        return _plain(thing.tolist())
    if isinstance(thing, (list, tuple)):
        return [_plain(value) for value in thing]
    if isinstance(thing, float) and not abs(thing) < float("inf"):
        return None
    return thing


def clear_line() -> None:
    """Leave no progress on the line that a terminal shows next."""
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr, flush=True)


def say(text: str) -> None:
    """One line of progress."""
    print(text, file=sys.stderr, flush=True)
