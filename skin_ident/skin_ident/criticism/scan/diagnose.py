"""The diagnosis of static spread scans: from tables to findings, an extended model and the curves for the report."""

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.scan.between import between_scans
from skin_ident.criticism.scan.candidates import able, excited_beside, rich
from skin_ident.criticism.scan.cells import Cells, as_tables, cells_of
from skin_ident.criticism.scan.contradicting import contradiction
from skin_ident.criticism.scan.declared_noise import declared_noise
from skin_ident.criticism.scan.extended import baseline_of, model_of
from skin_ident.criticism.scan.faults import Looked, look
from skin_ident.criticism.scan.findings import as_findings, parameters
from skin_ident.criticism.scan.fitting import Member
from skin_ident.criticism.scan.gate import Test
from skin_ident.criticism.scan.leftover import systematic_rest
from skin_ident.criticism.scan.search import Search, search
from skin_ident.criticism.scan.start import declared_start, given_start, plain_start
from skin_ident.criticism.scan.trials import Setting, Trial
from skin_ident.criticism.scan.unreadable import unreadable
from skin_ident.criticism.telling.outcome import Outcome, Round, ScanTrace
from skin_ident.criticism.usable import named_apart
from skin_ident.criticism.vocabulary import verdict_of
from skin_ident.recordings.declared import Declared
from skin_ident.spread_scan import SpreadScan
from skin_models.model import Model

NAME = "static spread scan"


def diagnose_scans(
    scans: list[SpreadScan],
    hold_out: list[SpreadScan] | None = None,
    model: Model | None = None,
    progress: Callable[[str], None] = lambda stage: None,
) -> Outcome:
    """Criticise the thesis's spread model, or `model` where it is given, on static scans; `hold_out` are scans never used to fit.

    The baseline is what the simulated skin does: force = k depth exp(-(r / c)^2), with one stiffness k per scan and one width c for all
    scans. The width is `spread_width_mm` of rig.yaml where that is declared, else it is fitted. Raises `DiagnosisError` where there is
    no scan, too few readings, where pressing makes the readings negative, or where no reading of the held-out scans can be trusted.
    """
    if not scans:
        raise DiagnosisError("there is no scan to diagnose")
    every = named_apart([*scans, *(hold_out or [])])
    scans, held = every[: len(scans)], every[len(scans) :]
    progress("looking at the tables")
    declared = scans[0].declared
    looked = look(scans, [direction(s) for s in scans], declared)
    if not looked.enough:
        return unreadable(scans, held, looked)
    apart = _held(held, declared)
    setting = _setting(looked, apart, _start(looked.cells, model, declared))
    found = search(setting.test.start, setting, progress)
    progress("testing whether a pattern is left")
    rest = systematic_rest(found, setting)
    looked = between_scans(declared_noise(looked, found, declared), found, scans, held, apart)
    contradicting = contradiction(found, setting, scans)
    looked = replace(looked, warnings=(contradicting, *looked.warnings)) if contradicting else looked
    verdict = verdict_of(bool(found.named or looked.faults), rest.is_systematic or bool(contradicting))
    names = {s.name for s in held}
    content = as_findings(found, looked, setting, rest, [*scans, *held], names, verdict, model.name if model else "")
    return _outcome(content, found, [*scans, *held], model)


def direction(scan: SpreadScan) -> str:
    """x, y or empty: the scan's declared direction, else the one in its file name (scan_x.csv)."""
    words = re.split(r"[^a-z0-9]+", scan.name.lower().rsplit(".", 1)[0])
    named = [w for w in words if w in ("x", "y")]
    return scan.direction or (named[0] if len(named) == 1 else "")


def _held(held: list[SpreadScan], declared) -> Cells | None:
    """The trusted cells of held-out scans, None where there are none. Rows, columns and scans are numbered apart from those fitted; the
    sizes are fitted again when these cells are predicted. Raises `DiagnosisError` where no cell can be trusted."""
    if not held:
        return None
    cells = look(held, [direction(s) for s in held], declared).cells
    if not len(cells):
        raise DiagnosisError(f"nothing in {held[0].name} can be believed: hold out another scan")
    return cells


def _start(cells: Cells, model: Model | None, declared: Declared) -> Member:
    """The baseline: a given model with its own width, else the thesis's model with the width of rig.yaml, else with a fitted width."""
    if model is not None:
        return given_start(cells, model)
    return declared_start(cells, 1e-3 * declared.spread_width_mm) if declared.spread_width_mm else plain_start(cells)


def _setting(looked: Looked, held: Cells | None, start: Member) -> Setting:
    cells = looked.cells
    x = excited_beside(cells, start)
    return Setting(cells, able(x), rich(x), looked.floor, Test(start, held), x.both_sides)


def _outcome(content: dict, found: Search, scans: list[SpreadScan], model: Model | None) -> Outcome:
    before, after = found.baseline.member, found.extended.member
    model_after = model_of(after, model, NAME)
    bent = model_after.dispersion.k1 != float(np.mean(after.k)) / after.scale.deepest  # k1 is one of several terms: its error is unknown
    std = {} if bent or model else {k: v["std"] for k, v in parameters(found.extended).items() if k == "k1"}
    traces = tuple(trace(s, i, before, after) for i, s in enumerate(scans))
    ranked = tuple(Round(_ranked(trials), name) for trials, name in found.rounds)
    return Outcome(content, baseline_of(before, model, NAME), model_after, std, (), traces, ranked)


def _ranked(trials: tuple[Trial, ...]) -> tuple[tuple[str, str, float], ...]:
    """(cause, where, fall of the cost) of the best form of every cause, best first, for a round of the report."""
    kept: dict[str, Trial] = {}
    for t in sorted(trials, key=lambda t: -t.fall):
        kept.setdefault(t.candidate.cause, t)
    return tuple((t.candidate.cause, t.candidate.where, t.fall) for t in kept.values())


def trace(scan: SpreadScan, number: int, before: Member, after: Member) -> ScanTrace:
    """A scan as measured, and as the baseline and the extended model predict it, lost and faulty cells included."""
    whole = SpreadScan(scan.depth, scan.distance, np.zeros(scan.force.shape), name=scan.name)
    cells = cells_of([whole], [direction(scan)])
    own = [m if number < m.k.size else _resized(m, scan, cells) for m in (before, after)]
    cells = replace(cells, scan=np.full(len(cells), number if number < before.k.size else 0))
    curves = [as_tables(m.predict(cells), replace(cells, scan=np.zeros(len(cells), int)), [scan])[0] for m in own]
    return ScanTrace(scan.name, scan.depth, scan.distance, scan.force, *curves)


def _resized(m: Member, scan: SpreadScan, cells: Cells) -> Member:
    """A member whose sizes are scaled by the least-squares factor for a held-out scan."""
    known = np.isfinite(scan.force.ravel())
    shape = m.through(cells)[known]
    factor = float(shape @ scan.force.ravel()[known]) / max(float(shape @ shape), 1e-300)
    return replace(m, k=m.k * factor)
