"""Many sessions, each fitted by itself, in parallel: one table of results, failures listed in it, resumable.

Every finished session is appended to `fits.jsonl` at once, under a key made of its path, size, time of change, its `rig.yaml` and the
options; a second call skips the sessions that are there. A session whose process died is not kept, since that was no fault of the session:
the next call tries it again. `fits.csv` (or `fits.parquet`) is written from all rows at the end, whole or not at all.
"""

import csv
import hashlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import asdict
from importlib import import_module
from pathlib import Path
from typing import Any, TextIO

from skin_ident.estimators.errors import FitError
from skin_ident.estimators.fit import Options, fit_recordings, sessions_of
from skin_ident.processes import no_interrupts, workers
from skin_ident.recordings.carried import with_warnings_of
from skin_ident.recordings.declared import rig_file
from skin_ident.recordings.load import load_one
from skin_models.errors import SkinError
from skin_models.whole_file import whole_file

JOURNAL = "fits.jsonl"


def fit_session(path: str, options: Options, how: Mapping[str, Any]) -> dict[str, Any]:
    """One row of the table: path, status (ok or failed), reason, parameters with standard errors, residuals, warnings. Never raises.

    `how` holds the arguments of `load_one` other than the path.
    """
    try:
        recordings, _ = sessions_of([load_one(Path(path), **how)])
        with with_warnings_of(recordings):
            estimate = fit_recordings(recordings, options)
    except SkinError as error:
        return {"path": path, "status": "failed", "why": str(error)}
    except Exception as error:  # one broken file must not end a night's batch
        return {"path": path, "status": "failed", "why": f"{type(error).__name__}: {' '.join(str(error).split())}"}
    row: dict[str, Any] = {"path": path, "status": "ok", "why": "", "samples": len(recordings[0]), "method": estimate.method}
    for p in estimate.parameters:
        row |= {p.name: p.value, f"{p.name}_std": estimate.std[p.name], f"{p.name}_verdict": estimate.verdicts[p.name].word}
    row |= {f"{name}_rmse": r.rmse for name, r in estimate.residuals.items()}
    return row | {"warnings": " | ".join(estimate.warnings)}


def run_batch(
    paths: Sequence[Path],
    folder: Path,
    options: Options | None = None,
    topics: Mapping[str, str] | None = None,
    *,
    jobs: int | None = None,
    scheduler: str | None = None,
    log_time: bool = False,
    keep: bool = False,
    progress: Callable[[int, int, Mapping[str, Any]], None] = lambda done, total, row: None,
) -> list[dict[str, Any]]:
    """Fit every path and return the rows in the order of `paths`. `scheduler` is the address of a Dask cluster. Raises `FitError`.

    `progress(done, total, row)` is called as rows come in. Sessions that are in the journal already are not fitted again.
    """
    options, how = options or Options(), {"topics": dict(topics or {}), "log_time": log_time, "keep": keep}
    keys = {str(p): _key(p, options, how) for p in paths}
    rows = {row["key"]: row for row in _journal(folder) if row["key"] in set(keys.values())}
    todo = [p for p, key in keys.items() if key not in rows]
    with _kept(folder / JOURNAL) as journal:
        if journal.tell() and not (folder / JOURNAL).read_bytes().endswith(b"\n"):
            journal.write("\n")  # an earlier call was cut off within a line
        for row in _rows(todo, (options, how), jobs, scheduler):
            row["key"] = keys[row["path"]]
            rows[row["key"]] = row
            if not row.pop("lost", False):
                journal.write(json.dumps(row) + "\n")
                journal.flush()
            progress(len(rows), len(keys), row)
    return [rows[key] for key in keys.values()]


@contextmanager
def _kept(path: Path) -> Iterator[TextIO]:
    """The journal, to append to; it goes again where nothing was written."""
    try:
        with path.open("a", encoding="utf-8") as journal:
            yield journal
    finally:
        if path.exists() and not path.stat().st_size:
            path.unlink()


def _key(path: Path, options: Options, how: dict[str, Any]) -> str:
    files = sorted(path.rglob("*")) if path.is_dir() else [path]
    facts = [(str(f), *_size_and_change(f)) for f in files]
    rig = rig_file(path)
    facts += [(str(rig), _content(rig))] if rig else []
    return hashlib.sha256(json.dumps([facts, asdict(options), how]).encode()).hexdigest()[:24]


def _size_and_change(file: Path) -> tuple[int, int]:
    try:
        return file.stat().st_size, file.stat().st_mtime_ns
    except OSError:  # a link to nothing: the fit will say so
        return 0, 0


def _content(file: Path) -> str:
    try:
        return file.read_bytes().hex()
    except OSError:  # the fit will say so
        return ""


def _journal(folder: Path) -> Iterator[dict[str, Any]]:
    """Rows of earlier calls; a line that was cut off by a crash is skipped."""
    path = folder / JOURNAL
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else []:
        try:
            row = json.loads(line)
        except json.JSONDecodeError:
            continue
        if isinstance(row, dict) and "key" in row:
            yield row


def _rows(todo: list[str], how: tuple[Options, dict[str, Any]], jobs: int | None, scheduler: str | None) -> Iterator[dict[str, Any]]:
    """Rows as they are finished. A worker that dies takes its pool down; the sessions lost by that are tried again, each in its own
    pool."""
    lost: list[str] = []
    with _workers(jobs, scheduler) as executor:
        with no_interrupts():  # submitting starts workers, which must not receive Ctrl-C
            running = {executor.submit(fit_session, path, *how): path for path in todo}
        for future in as_completed(running):
            try:
                yield future.result()
            except BrokenProcessPool:
                lost.append(running[future])
            except Exception as error:  # a cluster has failures of its own
                yield _lost(running[future], f"lost by the cluster: {type(error).__name__}: {' '.join(str(error).split())}")
    for path in lost:
        with _workers(1, scheduler) as executor:
            try:
                yield executor.submit(fit_session, path, *how).result()
            except BrokenProcessPool:
                yield _lost(path, "the process that fitted it died (out of memory?)")


def _lost(path: str, why: str) -> dict[str, Any]:
    return {"path": path, "status": "failed", "why": why, "lost": True}


@contextmanager
def _workers(jobs: int | None, scheduler: str | None) -> Iterator[Executor]:
    if scheduler is None:
        with workers(jobs, finish=True) as pool:
            yield pool
        return
    with dask_client(scheduler) as client:
        yield client.get_executor()


def dask_client(scheduler: str) -> Any:
    """A client of the cluster at this address. Raises `FitError` without Dask, or where no scheduler answers."""
    try:
        client_of = import_module("distributed").Client  # by name: optional, and no dependency of the package
    except ImportError as error:
        raise FitError("a Dask scheduler was named, but Dask is not installed: pip install distributed") from error
    try:
        return client_of(scheduler, timeout="10s")
    except (OSError, ValueError) as error:
        raise FitError(f"no Dask scheduler answers at {scheduler}") from error


def parquet_library() -> tuple[Any, Any]:
    """pyarrow and its Parquet module. Raises `FitError` where they are not installed; call it before a long batch, not only after it."""
    try:
        return import_module("pyarrow"), import_module("pyarrow.parquet")
    except ImportError as error:
        raise FitError("Parquet needs pyarrow: pip install pyarrow, or write --format csv") from error


def write_table(rows: Sequence[Mapping[str, Any]], path: Path) -> None:
    """All rows as CSV or, by the suffix .parquet, as Parquet; whole or not at all. Raises `FitError` without pyarrow for the latter."""
    columns = list(dict.fromkeys(name for row in rows for name in row if name != "key"))
    with whole_file(path) as partial:
        if path.suffix == ".parquet":
            arrow, parquet = parquet_library()
            parquet.write_table(arrow.table({c: [row.get(c) for row in rows] for c in columns}), partial)
            return
        with partial.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, columns, extrasaction="ignore")
            writer.writeheader()
            writer.writerows(rows)
