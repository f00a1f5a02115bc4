"""`fit RECORDING… --out DIR`: the dispersion model of one or many sessions, with an uncertainty and a verdict for every parameter."""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from skin_ident.batch import JOURNAL, dask_client, parquet_library, run_batch, write_table
from skin_ident.cli import common
from skin_ident.cli.fit_other import CALIBRATION, DISPERSION, PRONY, WHAT, fit_other
from skin_ident.cli.fit_scan import fit_scans
from skin_ident.estimators.bootstrap import bootstrap, check_runs
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.estimate import POOR, Estimate
from skin_ident.estimators.fit import (
    FIXED,
    FREE,
    MEASURED,
    SINUSOID,
    Fitted,
    Options,
    as_fitted,
    check,
    fit_prepared,
    mass_of,
    sessions_of,
)
from skin_ident.estimators.latency import latencies
from skin_ident.estimators.profile import profile
from skin_ident.estimators.robust import LINEAR, LOSSES
from skin_ident.estimators.spread import with_spread
from skin_ident.estimators.text import as_dict, as_table
from skin_ident.estimators.zeros import zero_warnings
from skin_ident.recordings.bag import with_volts
from skin_ident.recordings.carried import with_warnings_of
from skin_ident.recordings.load import find, load
from skin_ident.recordings.mass import USUAL_MM
from skin_ident.recordings.recording import Recording
from skin_ident.recordings.slopes import slopes_in_use
from skin_ident.recordings.storage import is_bag
from skin_ident.spread_scan import SpreadScan
from skin_models.model_file import save_model
from skin_models.words import counted

_MASS = (
    "free, a value in kg, or fixed (the default): moving_mass_kg of rig.yaml, or that of silicone as thick as --thickness-mm or rig.yaml "
    f"says, or else {USUAL_MM:g} mm"
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    return common.run(_main, arguments)


def _main(arguments: Sequence[str] | None) -> int:
    chosen = _parser().parse_args(arguments)
    topics = common.topics_of(chosen.topics)
    topics = with_volts(topics) if chosen.what == CALIBRATION else topics
    options = Options(chosen.mass, chosen.thickness_mm, chosen.motion, chosen.offsets, chosen.order or 1, chosen.loss, chosen.keep_spikes)
    if chosen.loss != LINEAR and (chosen.profile or chosen.bootstrap):
        raise FitError(f"--profile and --bootstrap are for least squares: leave them or --loss {chosen.loss} out")
    _check_what(chosen)
    check(options)
    if chosen.bootstrap is not None:
        check_runs(chosen.bootstrap)
    if chosen.out is not None:
        common.check_output(chosen.out)
        common.check_no_answer(chosen.out)
    _check_bags(chosen)
    if chosen.each:
        return _batch(chosen, options, topics)
    common.say(f"reading {counted(len(chosen.recordings), 'path')} …")
    loaded = load(chosen.recordings, topics, chosen.log_time, chosen.keep_stamps)
    if all(isinstance(r, SpreadScan) for r in loaded):
        _check_order(chosen, loaded)
        return fit_scans(loaded, chosen.out)
    recordings, scans = sessions_of(loaded)
    _check_order(chosen, recordings)
    recordings = options.of(recordings)
    for name in scans:
        common.say(f"{name} is a static spread scan: left out of the fit; fit scans by themselves")
    common.say(f"fitting {counted(len(recordings), 'session')}, {sum(map(len, recordings))} samples …")
    with with_warnings_of(recordings):
        if chosen.what != DISPERSION:
            return fit_other(chosen.what, recordings, chosen.out, chosen.arms, _slopes(chosen))
        estimate = _estimate(chosen, recordings, options)
    estimate = with_spread(estimate, recordings)
    print(as_table(estimate))
    if chosen.out:
        write(estimate, common.output_folder(chosen.out))
    return 0


def _slopes(chosen: argparse.Namespace) -> dict[str, float]:
    """The slopes (N/V) by taxel that the recordings keep, those of the first that keeps any."""
    files = (file for path in chosen.recordings for file in find(path)) if chosen.what == CALIBRATION else ()
    return next(filter(None, map(slopes_in_use, files)), {})


def _estimate(chosen: argparse.Namespace, recordings: list[Recording], options: Options) -> Estimate:
    """The dispersion model, with all that was asked for beside it in the notes."""
    estimate = fit_prepared(recordings, options)
    if estimate.model is None:
        for asked, name in ((chosen.bootstrap, "--bootstrap"), (chosen.profile, "--profile")):
            if asked:
                raise FitError(f"{name} is for fits with a depth")
        return estimate
    estimate, fitted = _with_latencies(estimate, recordings, options), as_fitted(recordings, options)
    if not options.offsets and options.loss == LINEAR:
        estimate = replace(estimate, warnings=(*estimate.warnings, *zero_warnings(estimate, *fitted)))
    if chosen.bootstrap:
        estimate = _with_bootstrap(estimate, fitted, options, chosen.bootstrap)
    return _with_profile(estimate, fitted, options) if chosen.profile else estimate


def _check_what(chosen: argparse.Namespace) -> None:
    """Raises `FitError` for options that do not go together."""
    if chosen.what != DISPERSION and (chosen.each or chosen.profile or chosen.bootstrap or chosen.loss != LINEAR):
        raise FitError(f"--each, --profile, --bootstrap and --loss are for the dispersion model: leave them or --what {chosen.what} out")
    if chosen.arms is not None and chosen.arms < 1:
        raise FitError("--arms must be 1 or more")
    if chosen.arms is not None and chosen.what != PRONY:
        raise FitError(f"--arms are those of a relaxation spectrum (Prony series): add --what {PRONY}")
    if chosen.order is not None and chosen.what != DISPERSION:
        raise FitError(f"--order is that of a fit from force to force: leave it or --what {chosen.what} out")
    for value, name in ((chosen.jobs, "--jobs"), (chosen.scheduler, "--scheduler"), (chosen.format, "--format")):
        if value is not None and not chosen.each:
            raise FitError(f"{name} is for many sessions, each fitted by itself: add --each, or leave {name} out")


def _check_order(chosen: argparse.Namespace, loaded: Sequence[Recording | SpreadScan]) -> None:
    """Raises `FitError` for the order of a transfer function where the fit has a depth, and so no such order."""
    deep = next((r.name for r in loaded if r.depth is not None), None)
    if chosen.order is not None and deep is not None:
        raise FitError(f"--order is that of a fit from force to force, and {deep} has a depth: leave --order out")


def _check_bags(chosen: argparse.Namespace) -> None:
    """Raises `FitError` for options that say how to read bags where there is none."""
    asked = [name for value, name in ((chosen.topics, "--topics"), (chosen.log_time, "--log-time")) if value]
    if asked and not any(is_bag(file) for path in chosen.recordings for file in find(path)):
        raise FitError(f"{asked[0]} is for bags, and no recording given is one: leave {asked[0]} out")


def _with_latencies(estimate: Estimate, recordings: list[Recording], options: Options) -> Estimate:
    """The same with the latency of every channel in the notes, and a warning where one matters or none can be told."""
    mass = mass_of(replace(options, mass=FIXED) if options.mass == FREE else options, recordings)  # a free mass would stand for a delay
    try:
        found = {n: latency for n, latency in latencies(recordings, mass).items() if estimate.residuals[n].r2 >= POOR}
    except FitError as error:
        return replace(estimate, warnings=(*estimate.warnings, f"no latency behind the depth can be told: {error}"))
    said = [w for name, latency in found.items() for w in latency.warning(name, recordings[0].dt)]
    entries = {name: {"value": 1e3 * latency.seconds, "std": 1e3 * latency.std} for name, latency in found.items()}
    return replace(estimate, warnings=(*estimate.warnings, *said), notes={**estimate.notes, "latency_behind_depth_ms": entries})


def _with_bootstrap(estimate: Estimate, fitted: Fitted, options: Options, runs: int) -> Estimate:
    """The same with intervals drawn from stretches of the residual, in the notes."""
    common.say(f"drawing {runs} bootstrap samples …")
    drawn = bootstrap(*fitted, offsets=options.offsets, runs=runs)
    intervals = {p.name: list(drawn.interval(p.name)) for p in estimate.parameters if estimate.std[p.name] > 0.0}
    return replace(estimate, notes={**estimate.notes, "bootstrap": {"runs": runs, "stretch_s": drawn.stretch, "ci95": intervals}})


def _with_profile(estimate: Estimate, fitted: Fitted, options: Options) -> Estimate:
    """The same with intervals by profile likelihood in the notes."""
    common.say("profiling the likelihood …")
    found = profile(*fitted, offsets=options.offsets)
    return replace(estimate, notes={**estimate.notes, "profile": {"ci95": {name: list(ends) for name, ends in found.items()}}})


def _batch(chosen: argparse.Namespace, options: Options, topics: dict[str, str]) -> int:
    """Every session by itself; failures are rows of the table, and the status is 0 only where there are none. Raises `FitError`."""
    if not chosen.out:
        raise FitError("--each needs --out DIR: one table of all sessions is written there")
    if chosen.profile or chosen.bootstrap:
        raise FitError("--each writes one table of standard errors: ask for --profile or --bootstrap of single fits")
    if chosen.jobs is not None and chosen.jobs < 1:
        raise FitError(f"{chosen.jobs} processes cannot work: give --jobs a number of 1 or more, or leave it out")
    form = chosen.format or "csv"
    if form == "parquet":
        parquet_library()
    if chosen.scheduler:
        dask_client(chosen.scheduler).close()
    paths = [file for path in chosen.recordings for file in find(path)]
    folder = common.output_folder(chosen.out)
    how = {"jobs": chosen.jobs, "scheduler": chosen.scheduler, "log_time": chosen.log_time, "keep": chosen.keep_stamps}
    try:
        rows = run_batch(paths, folder, options, topics, **how, progress=_row_done)
    except KeyboardInterrupt:
        if not (folder / JOURNAL).exists():
            common.say("no session was finished yet")
            raise
        common.say(f"interrupted; the sessions that were finished are kept in {folder / JOURNAL}: the same call goes on from there")
        return common.INTERRUPTED
    table = folder / f"fits.{form}"
    write_table(rows, table)
    failed = [row for row in rows if row["status"] != "ok"]
    print(f"{counted(len(rows) - len(failed), 'session')} fitted, {len(failed)} failed: {table}")
    for row in failed:
        print(f"  failed: {row['path']}: {row['why']}")
    if failed:
        none = "none of the sessions could be fitted"
        raise FitError(none if len(failed) == len(rows) else f"{len(failed)} of {len(rows)} sessions could not be fitted; {table} says why")
    return 0


def _row_done(done: int, total: int, row: Mapping[str, Any]) -> None:
    common.say(f"[{done}/{total}] {row['path']}: {row['status']}")


def write(estimate: Estimate, folder: Path) -> None:
    """Write `model.yaml`, which the skin node loads, and `fit.json`."""
    common.write_json(folder / "fit.json", as_dict(estimate))
    if estimate.model is None:
        common.say(f"wrote {folder / 'fit.json'}; no model.yaml, for without a depth only ratios are known")
        return
    save_model(estimate.model, folder / "model.yaml", estimate.std)
    common.say(f"wrote {folder / 'model.yaml'} and {folder / 'fit.json'}")


def _parser() -> argparse.ArgumentParser:
    parser = common.Parser(prog="fit", description=__doc__)
    common.add_recordings(parser)
    what = "the model; or a relaxation spectrum; or straight lines: taxels in volts against the load cell, forces against the depth"
    parser.add_argument("--what", default=DISPERSION, choices=WHAT, help=what)
    parser.add_argument("--arms", type=int, help="number of arms for --what prony; default: as few as explain the data")
    parser.add_argument("--keep-stamps", action="store_true", help="leave uneven samples where they are instead of resampling them")
    parser.add_argument("--mass", default="fixed", help=_MASS)
    parser.add_argument("--thickness-mm", "--thickness_mm", type=float, help="thickness of the skin, for a fixed mass that is not declared")
    parser.add_argument("--motion", default=MEASURED, choices=(MEASURED, SINUSOID), help="depth as measured, or the sinusoid fitted to it")
    parser.add_argument("--offsets", action="store_true", help="fit a zero of every channel in every session, too")
    parser.add_argument("--order", type=int, choices=(1, 2), help="from force to force: 1 (the default) without mass, 2 as thesis eq 32")
    parser.add_argument("--loss", default=LINEAR, choices=LOSSES, help="all but linear reduce the influence of spikes")
    parser.add_argument("--keep-spikes", action="store_true", help="do not replace samples that jump away and back in one channel alone")
    parser.add_argument("--bootstrap", type=int, metavar="RUNS", help="also intervals by block bootstrap of the residual")
    parser.add_argument("--profile", action="store_true", help="also intervals by profile likelihood")
    parser.add_argument("--each", action="store_true", help="fit every session by itself, in parallel, into one table; resumable")
    parser.add_argument("--jobs", type=int, help="processes for --each; default: one per core")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="Dask cluster to use for --each, as tcp://host:8786")
    parser.add_argument("--format", choices=("csv", "parquet"), help="format of the table of --each; default: csv")
    parser.add_argument("--out", metavar="DIR", help="where model.yaml and fit.json go, or the table of --each; default: none")
    return parser


if __name__ == "__main__":
    raise SystemExit(main())
