"""Keeps the curves behind a report, so that it can be rendered again without fitting anything.

`traces.npz` in the output directory holds the arrays of every trace and scan, and a JSON text with the rest. No pickles.
"""

import json
import zipfile
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from skin_ident.criticism.telling.outcome import Outcome, Round, ScanTrace, Trace
from skin_ident.report.errors import ReportError
from skin_models.whole_file import whole_file

TRACES = "traces.npz"
FINDINGS = "findings.json"
_FORMAT = 1
_MEANING = "_content"


def save_traces(outcome: Outcome, directory: Path) -> Path:
    """Write `traces.npz` whole or not at all; returns its path. Raises `ReportError` where it cannot be written."""
    path = Path(directory) / TRACES
    arrays: dict[str, np.ndarray] = {}
    content = {
        "format": _FORMAT,
        "traces": [_taken_apart(t, f"trace_{i}", arrays) for i, t in enumerate(outcome.traces)],
        "scans": [_taken_apart(s, f"scan_{i}", arrays) for i, s in enumerate(outcome.scans)],
        "rounds": [{"ranked": [list(r) for r in round_.ranked], "named": round_.named} for round_ in outcome.rounds],
    }
    try:
        with whole_file(path) as partial, partial.open("wb") as out:
            np.savez_compressed(out, **{_MEANING: np.array(json.dumps(content))}, **arrays)
    except OSError as error:
        raise ReportError(f"cannot write {path}: {error.strerror or error}") from error
    return path


def load_traces(directory: Path) -> tuple[tuple[Trace, ...], tuple[ScanTrace, ...], tuple[Round, ...]]:
    """Traces, scans and rounds of a directory. Raises `ReportError` where `traces.npz` is absent or not ours."""
    path = Path(directory) / TRACES
    try:
        with np.load(path, allow_pickle=False) as held:
            content = json.loads(str(held[_MEANING]))
            if content["format"] != _FORMAT:
                raise ValueError("another version")
            traces = tuple(_put_together(Trace, entry, held) for entry in content["traces"])
            scans = tuple(_put_together(ScanTrace, entry, held) for entry in content["scans"])
            rounds = tuple(Round(tuple((c, w, float(g)) for c, w, g in r["ranked"]), r["named"]) for r in content["rounds"])
    except OSError as error:
        raise ReportError(f"cannot read {path}: {error.strerror or error}; run diagnose again to make it") from error
    except (ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise ReportError(f"{path} is damaged or of another version; run diagnose again to make it") from error
    return traces, scans, rounds


def load_outcome(directory: Path) -> Outcome:
    """The outcome that `diagnose` left in a directory: findings, and its curves where they are there (`traces.npz` may be absent).

    Raises `ReportError` where there are no findings to report, or where a file is damaged.
    """
    findings = load_findings(directory)
    if not (Path(directory) / TRACES).exists():
        return Outcome(findings)
    traces, scans, rounds = load_traces(directory)
    return Outcome(findings, traces=traces, scans=scans, rounds=rounds)


def load_findings(directory: Path) -> dict[str, Any]:
    """The content of findings.json in `directory`. Raises `ReportError` where that cannot be read, or is none."""
    path = Path(directory) / FINDINGS
    try:
        findings = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ReportError(f"cannot read {path}: {error.strerror or error}; name the directory that diagnose wrote with --out") from error
    except ValueError as error:
        raise ReportError(f"{path} is not JSON: {error}") from error
    if not isinstance(findings, dict) or findings.get("schema") != 1 or not isinstance(findings.get("verdict"), str):
        raise ReportError(f"{path} is not a result of diagnose: it needs schema 1 and a verdict")
    for name, kind, what in (("findings", list, "a list"), ("baseline", dict, "a mapping"), ("extended", dict, "a mapping")):
        if not isinstance(findings.get(name, kind()), kind):
            raise ReportError(f"{path} is damaged: its {name} must be {what}; run diagnose again to make it")
    return findings


def _taken_apart(thing: Any, prefix: str, arrays: dict[str, np.ndarray]) -> dict[str, Any]:
    """The fields of a trace for JSON. Its arrays are put into `arrays`, and replaced by their names there."""
    entry = {}
    for f in fields(thing):
        value = getattr(thing, f.name)
        if isinstance(value, np.ndarray):
            arrays[f"{prefix}_{f.name}"] = value.astype(np.float32 if f.name != "t" else float)
            entry[f.name] = {"array": f"{prefix}_{f.name}"}
        else:
            entry[f.name] = value
    return entry


def _put_together(cls: type, entry: dict[str, Any], held: Any) -> Any:
    def of(value: Any) -> Any:
        if isinstance(value, dict):
            return np.asarray(held[value["array"]], float)
        return tuple(value) if isinstance(value, list) else value

    return cls(**{name: of(value) for name, value in entry.items()})
