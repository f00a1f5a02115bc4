"""`diagnose RECORDING… --out DIR`: what the simulation gets wrong on measured data, from which cause, and what the model gains by it."""

import argparse
import re
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from skin_ident.cli import common
from skin_ident.criticism.diagnose import are_scans, diagnose
from skin_ident.criticism.telling.outcome import Outcome
from skin_ident.recordings.carried import with_warnings_of
from skin_ident.recordings.chosen import only_taxels
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.load import find, load
from skin_ident.recordings.recording import Recording
from skin_ident.recordings.repeated import same
from skin_ident.report import save_traces, write_report
from skin_ident.report.terminal import summary
from skin_ident.report.write import PICTURES
from skin_models.model_file import load_model, save_model

BASELINE, MODEL = "baseline.yaml", "model.yaml"
UNFINISHED = ".unfinished_"  # begins the name of the folder in which an answer is written
BATTERY = re.compile(r"separating(_[1-9]\d*)?\.yaml")  # as separating_experiments names them


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    return common.run(_main, arguments)


def _main(arguments: Sequence[str] | None) -> int:
    chosen = _parser().parse_args(arguments)
    how = {"topics": common.topics_of(chosen.topics), "log_time": chosen.log_time}
    common.check_output(chosen.out)
    common.check_no_model(chosen.out)
    model = load_model(chosen.model) if chosen.model else None
    files, kept = apart(chosen.recordings, chosen.hold_out)
    _check_apart(Path(chosen.out), [file for file, _ in files + kept])
    for file, said in kept:
        if said:
            common.say(f"{file}: {said}")
    say = progress_line()
    say("reading recordings")
    recordings, held, twins = (_loaded(paths, how, chosen.taxels) for paths in (files, kept, [(p, "") for p in chosen.twin]))
    if chosen.taxels and are_scans([*recordings, *held, *twins]):
        raise RecordingError(f"{recordings[0].name} is a static spread scan, of one taxel: leave --taxels out")
    _check_held_out(recordings, held, files, kept)
    with with_warnings_of([*recordings, *held, *twins]):
        outcome = diagnose(recordings, held, model, say, twins)
    if chosen.taxels:
        outcome.findings["taxels"] = {f"taxel_{i}": name for i, name in enumerate(recordings[0].taxel_names)}
    say("writing the report")
    with common.whole_folder(chosen.out) as folder:
        write(outcome, folder)
    common.clear_line()
    print(summary(outcome.findings))
    print(f"\nreport: {folder / 'report.html'}")
    return 0


def _check_apart(out: Path, files: Sequence[Path]) -> None:
    """Raises `RecordingError` where the output folder is a recording; a folder that contains recordings is allowed, as in the demo."""
    if out.resolve() in {file.resolve() for file in files}:
        raise RecordingError(f"--out {out} is a recording: name another folder for the answer")


Files = list[tuple[Path, str]]  # each with a warning about it, or an empty text


def apart(recordings: list[str], hold_out: list[str]) -> tuple[Files, Files]:
    """The files to fit and those to hold out, each of them once. Raises `RecordingError` where none is left to fit."""
    fitted, held = ([file for path in paths for file in find(path)] for paths in (recordings, hold_out))
    kept = {file.resolve() for file in held}
    files = [file for file in fitted if file.resolve() not in kept]
    if not files:
        raise RecordingError("every recording is held out (--hold-out), and none is left to fit: give at least one more recording")
    both = {file.resolve() for file in fitted} & kept
    said = "it was given to fit, too: it is held out, and not fitted"
    return _once(files), [(file, said if file.resolve() in both else more) for file, more in _once(held)]


def _once(files: list[Path]) -> Files:
    """Every file under its first name."""
    first = {file.resolve(): file for file in reversed(files)}
    names = [file.resolve() for file in files]
    return [(first[name], "it was given more than once: it counts once" if names.count(name) > 1 else "") for name in dict.fromkeys(names)]


def _loaded(files: Sequence[tuple[Path | str, str]], how: dict[str, Any], taxels: list[str]) -> list:
    recordings = [warned(r, said) for file, said in files for r in load(file, **how)]
    return only_taxels(recordings, taxels) if taxels else recordings


def _check_held_out(recordings: list, held: list, files: Files, kept: Files) -> None:
    """Raises `RecordingError` where a held-out session holds the same samples as a fitted one of the same name: here their paths are known,
    which tell the two apart."""
    fitted = [(r, file) for r, (file, _) in zip(recordings, files, strict=True) if isinstance(r, Recording)]
    for r, (file, _) in zip(held, kept, strict=True):
        twin = next((path for other, path in fitted if other.name == r.name and isinstance(r, Recording) and same(other, r)), None)
        if twin is not None:
            said = f"{file}, which is held out, holds the same samples as {twin}, which is fitted"
            raise RecordingError(f"{said}: hold out another session")


def warned(recording, said: str):
    """A session with one more warning, if there is one; a static scan as it is, for it has no warnings."""
    return replace(recording, warnings=(*recording.warnings, said)) if said and hasattr(recording, "warnings") else recording


def write(outcome: Outcome, folder: Path) -> None:
    """Write findings.json, model.yaml (and baseline.yaml, what it started from), separating batteries, and the report with its data.

    Everything is written apart first and put in place together. An earlier answer stays as it was until then; its findings.json goes first
    and the new one comes last, for a folder without it holds no answer. Raises `SkinError` or `OSError`.
    """
    with tempfile.TemporaryDirectory(prefix=UNFINISHED, dir=folder) as name:  # within the folder: beside it may be another file system
        fresh = Path(name)
        write_report(outcome, fresh)
        save_traces(outcome, fresh)
        if outcome.model is not None:
            save_model(outcome.baseline, fresh / BASELINE)
            save_model(outcome.model, fresh / MODEL, outcome.std)
        for file, battery in outcome.batteries.items():
            (fresh / file).write_text(battery, encoding="utf-8")
        common.write_json(fresh / common.FINDINGS, outcome.findings)
        _remove_earlier(folder, {file.name for file in fresh.iterdir()})
        for file in sorted(fresh.iterdir(), key=lambda file: file.name == common.FINDINGS):
            file.replace(folder / file.name)


def _remove_earlier(folder: Path, again: set[str]) -> None:
    """Remove the findings of an earlier answer, and of its pictures, models and batteries those that are not written `again`: they would
    seem to belong to this one.

    A folder without findings holds no answer, and models and batteries in it are somebody's own, as are all names that are not given here.
    """
    for name in set(PICTURES) - again:
        (folder / name).unlink(missing_ok=True)
    if not (folder / common.FINDINGS).exists():
        return
    (folder / common.FINDINGS).unlink()
    for file in folder.glob("*.yaml"):
        if file.name not in again and (file.name in (BASELINE, MODEL) or BATTERY.fullmatch(file.name)):
            file.unlink()


def progress_line() -> Callable[[str], None]:
    """Says each stage on stderr: in place on a terminal, a line each in a log."""
    started, live = time.monotonic(), sys.stderr.isatty()

    def say(stage: str) -> None:
        text = f"[{time.monotonic() - started:5.1f} s] {stage}"
        print(f"\r\033[K{text}" if live else text, end="" if live else "\n", file=sys.stderr, flush=True)

    return say


def _parser() -> argparse.ArgumentParser:
    parser = common.Parser(prog="diagnose", description=__doc__)
    common.add_recordings(parser)
    parser.add_argument(
        "--model", metavar="YAML", help="the simulation to criticise; default: the dispersion model fitted to the recordings"
    )
    parser.add_argument(
        "--twin", nargs="+", default=[], metavar="RECORDING",
        help="instead of --model: what a simulator of your own recorded for the same motions, one for each session (held-out ones last)",
    )  # fmt: skip
    parser.add_argument(
        "--hold-out", nargs="+", default=[], metavar="RECORDING", help="sessions never used to fit; default: each session in turn"
    )
    parser.add_argument("--taxels", nargs="+", default=[], metavar="NAME", help="only these, by name or number; renumbered in findings")
    parser.add_argument("--out", required=True, metavar="DIR", help="where findings.json, model.yaml and report.html go")
    return parser


if __name__ == "__main__":
    raise SystemExit(main())
