"""`challenge --out DIR`: hide effects in simulated recordings, diagnose them, and count the hits. The same command again resumes, and
another one adds to what is there."""

import argparse
import math
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import as_completed
from pathlib import Path
from typing import Any

from skin_ident.cli import common
from skin_ident.criticism.sessions.session import prepare
from skin_ident.hiding.campaign import NULL, SHARES, Case, cases, keep, kept, key, recordings, result
from skin_ident.hiding.drawing import hideable, refused
from skin_ident.hiding.errors import HidingError
from skin_ident.processes import no_interrupts, workers
from skin_models.words import counted

RESULTS = "results.jsonl"


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    return common.run(_main, arguments)


def _main(arguments: Sequence[str] | None) -> int:
    chosen = _parser().parse_args(arguments)
    chosen.causes = [cause for word in chosen.causes or [] for cause in word.split(",") if cause]
    wanted = _wanted(chosen)
    folder = common.output_folder(chosen.out)
    file = folder / RESULTS
    done = {key(r): r for r in kept(file)}
    _alike(wanted[0], list(done), folder)
    left = [case for case in wanted if case not in done]
    if len(left) < len(wanted):
        common.say(f"{len(wanted) - len(left)} of {len(wanted)} cases are there already")
    try:
        for entry in _played(left, chosen.jobs):
            done[key(entry)] = entry
            keep(entry, file)
    except KeyboardInterrupt:
        if not file.exists():
            raise
        common.say(f"\ninterrupted; the cases so far are kept in {file}, and the same command goes on")
        return common.INTERRUPTED
    _report([done[case] for case in wanted], list(done.values()), folder)
    return 0


def _alike(wanted: Case, there: list[Case], folder: Path) -> None:
    """Raises `HidingError` where the folder holds cases of other recordings than those wanted: one rate of both would say nothing."""
    other = next((case for case in there if (case.protocol, case.taxels) != (wanted.protocol, wanted.taxels)), None)
    if other is not None:
        held = f"holds cases of the battery {other.protocol} with {counted(other.taxels, 'taxel')}"
        raise HidingError(f"{folder} {held}, and all cases in a folder are counted together: name another folder")


def _report(wanted: list[dict[str, Any]], results: list[dict[str, Any]], folder: Path) -> None:
    """Count all results in the folder, those of this call and of earlier ones. Raises `HidingError` where none of the cases of this call
    could be played."""
    from skin_ident.hiding.picture import save_confusion  # drawing costs a second of start-up that a refusal should not
    from skin_ident.hiding.tally import summary, write_tables

    reasons = [r.get("skipped") or r.get("failed") for r in wanted]
    if all(reasons):
        raise HidingError(f"none of the {len(wanted)} cases could be played, the first because {reasons[0]}")
    if len(results) > len(wanted):
        print(f"{len(results)} cases, {len(results) - len(wanted)} of them from earlier calls with other arguments:")
    print(summary(results))
    write_tables(results, folder)
    save_confusion(results, folder / "confusion.png")
    print(f"\ntables and picture: {folder / 'cases.csv'}, {folder / 'confusion.csv'}, {folder / 'confusion.png'}")


def _played(left: list[Case], jobs: int) -> Iterator[dict[str, Any]]:
    """Results as they come, with a line of progress."""
    started = time.monotonic()
    with workers(jobs, finish=False) as pool:
        with no_interrupts():  # submitting starts workers
            running = [pool.submit(result, case) for case in left]
        for n, future in enumerate(as_completed(running), 1):
            yield future.result()
            _progress(n, len(left), time.monotonic() - started)


def _progress(n: int, of: int, seconds: float) -> None:
    text = f"{n} of {of} cases, {seconds:.0f} s, {seconds / n * (of - n):.0f} s to go"
    live = sys.stderr.isatty()
    print(f"\r\033[K{text}" if live else text, end="" if live and n < of else "\n", file=sys.stderr, flush=True)


def _wanted(chosen: argparse.Namespace) -> list[Case]:
    """The cases that were asked for. Raises `HidingError`, or `ProfileError` for a battery that does not exist."""
    for name, value, most in (("--seeds", chosen.seeds, 100_000), ("--jobs", chosen.jobs, 256), ("--taxels", chosen.taxels, len(SHARES))):
        if not 1 <= value <= most:
            raise HidingError(f"{name} must lie between 1 and {most}, not {value}")
    for name, values in (("--causes", chosen.causes), ("--sizes", chosen.sizes)):
        twice = next((value for value in values if values.count(value) > 1), None)
        if twice is not None:  # a case that is counted twice is evidence for nothing
            raise HidingError(f"{name} names {twice} twice: name it once, and ask for more --seeds to have more cases of it")
    wrong = [size for size in chosen.sizes if not 0.0 < size < math.inf]
    if wrong:
        raise HidingError(f"--sizes are in units of the noise and positive, not {wrong[0]:g}")
    able = hideable(prepare(recordings(Case(NULL, 0.0, 0, chosen.protocol, chosen.taxels))[0]))
    causes = chosen.causes or [NULL, *sorted(able)]
    for cause in causes:
        if cause != NULL and cause not in able:
            raise HidingError(refused(cause, (NULL, *able), " here"))
    return cases(causes, chosen.sizes, chosen.seeds, chosen.protocol, chosen.taxels)


def _parser() -> argparse.ArgumentParser:
    parser = common.Parser(prog="challenge", description=__doc__)
    parser.add_argument(
        "--causes", nargs="+", metavar="CAUSE", help=f"what to hide, spaces or commas between; {NULL} hides nothing; default: everything"
    )
    parser.add_argument("--sizes", nargs="+", type=float, default=[0.5, 1.0], help="RMS of the effect divided by that of the noise (0.5 1)")
    parser.add_argument("--seeds", type=int, default=5, help="specimens, noises and forms per cause and size (5)")
    parser.add_argument("--protocol", default="full", metavar="BATTERY", help="battery of the sessions (full)")
    parser.add_argument("--taxels", type=int, default=1, help="taxels in the recordings (1)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (2)")
    parser.add_argument("--out", required=True, metavar="DIR", help="where results, tables and picture go")
    return parser


if __name__ == "__main__":
    raise SystemExit(main())
