"""Inspects the tables before any fit: converter steps, copied rows, slips of the pen, a taxel that does not respond."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.stats import spearmanr

from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.scan.cells import Cells, cells_of
from skin_ident.criticism.scan.copies import find_copies, resolution
from skin_ident.criticism.scan.fault import Fault, mm
from skin_ident.criticism.scan.levels import Levels, find_levels
from skin_ident.criticism.scan.rough import rough
from skin_ident.criticism.scan.slips import FACTORS, factor_near, find_slips
from skin_ident.criticism.scan.start import zeroed_start
from skin_ident.criticism.telemetry.quantization import COARSER
from skin_ident.criticism.telemetry.symptom import quantity
from skin_ident.recordings.declared import Declared
from skin_ident.spread_scan import SpreadScan

ANSWERS = 3e-4  # p-value below which readings are taken to follow depth and distance
FEWEST = 12  # cells that a search needs, and a scan from which a taxel can be called dead
FEWEST_ROWS, IN_A_ROW = 2, 3  # rows of so many cells that a search needs
TOO_FEW = "there are too few readings, or too few rows, to look for it"
SANE = {"distance": (5e-5, 0.2), "depth": (1e-6, 0.1), "force": (1e-3, 1e5)}  # m, m, N: plausible widths, depths and largest forces


@dataclass(frozen=True, eq=False)
class Looked:
    """The result of the inspection. `every` holds all cells, `cells` those that are trusted; `step` is the converter's, N, or None;
    `known` says for `limits` which causes were looked for here (see `_words`)."""

    every: Cells
    cells: Cells
    faults: tuple[Fault, ...]
    step: float | None
    known: dict[str, str]
    warnings: tuple[str, ...]

    @property
    def floor(self) -> float:
        """The standard deviation of rounding to the converter's step (or to the last decimal), N: a lower bound of the noise."""
        return (self.step or resolution(self.every.y)) / np.sqrt(12.0)

    @property
    def enough(self) -> bool:
        """Whether a search can run on what is left."""
        rows = [np.sum(self.cells.row == d) for d in np.unique(self.cells.row)]
        return len(self.cells) >= FEWEST and sum(n >= IN_A_ROW for n in rows) >= FEWEST_ROWS


def look(scans: list[SpreadScan], directions: list[str], declared: Declared) -> Looked:
    """All faults that can be seen without a model. Raises `DiagnosisError` where pressing makes the readings negative."""
    cells = cells_of(scans, directions)
    levels = [found for s in scans if (found := find_levels(s.force[np.isfinite(s.force)])) is not None]
    step = float(np.median([f.step for f in levels])) if len(levels) == len(scans) else None
    faults = [*_silent(cells, scans), *_coarse(cells, step, declared)]
    answering = ~np.any([f.bad for f in faults], axis=0) if faults else np.ones(len(cells), bool)
    found, searched = _in_the_record(cells, answering, scans, step) if answering.sum() >= FEWEST else ([], False)
    faults += found
    bad = np.any([f.bad for f in faults], axis=0) if faults else np.zeros(len(cells), bool)
    words = _words(declared, step, searched, all(_askable(cells, i) for i in range(len(scans))))
    return Looked(cells, cells.only(~bad), tuple(faults), step, words, tuple(_off_level(scans)))


def _in_the_record(cells: Cells, answering: np.ndarray, scans: list[SpreadScan], step: float | None) -> tuple[list[Fault], bool]:
    """The faults within tables, and whether there was enough to search for all of them."""
    believed = cells.only(answering)
    table = rough(believed, (step or resolution(believed.y)) / np.sqrt(12.0))
    if np.all(table.member.k < 0.0):
        raise DiagnosisError(f"{scans[0].name}: pressing makes the readings negative; compression must be positive")
    found = [*find_copies(believed, table, scans, step)]
    copied = np.any([f.bad for f in found], axis=0) if found else np.zeros(len(believed), bool)
    rest = believed.only(~copied)
    enough = len(rest) >= FEWEST and np.unique(rest.row).size >= 3
    if enough:
        table = rough(rest, (step or resolution(rest.y)) / np.sqrt(12.0))
        found += [f.among(~copied) for f in find_slips(rest, table, scans)]
        found += [f.among(~copied) for f in _other_units(rest, scans)]
    return [f.among(answering) for f in found], enough


def _silent(cells: Cells, scans: list[SpreadScan]) -> Iterator[Fault]:
    """Scans whose readings depend on neither depth nor distance."""
    for i, scan in enumerate(scans):
        mine = cells.only(cells.scan == i)
        if _askable(cells, i) and not answers(mine):
            why = f"the readings of {scan.name} depend on neither depth nor distance: the taxel does not answer"
            yield Fault("dead_taxel", "taxel", why, cells.scan == i, {"spread_of_readings": quantity(np.std(mine.y), "N")})


def _askable(cells: Cells, scan: int) -> bool:
    """Whether a scan has enough readings to tell whether its taxel answers."""
    return np.sum(cells.scan == scan) >= FEWEST


def answers(cells: Cells) -> bool:
    """Whether readings follow depth and distance, whatever the curve, zero and sign: by Spearman's rank correlation with a depth times a
    Gaussian, of three widths."""
    if len(cells) < 4 or np.ptp(cells.y) == 0.0:
        return False
    reach = np.abs(cells.r).max()
    guesses = (cells.z * np.exp(-((cells.r / (width * reach)) ** 2)) for width in (0.3, 0.6, 1.2))
    return any(spearmanr(cells.y, guess).pvalue < ANSWERS for guess in guesses)


def _coarse(cells: Cells, step: float | None, declared: Declared) -> Iterator[Fault]:
    """Steps coarser than rig.yaml declares."""
    said = declared.of_taxel("taxel_step_n", 0)
    if said and step and step > COARSER * said:
        why = f"the readings are {step:.3g} N apart, {step / said:.2g} times the step that rig.yaml declares"
        parameters = {"step": quantity(step, "N"), "declared": quantity(said, "N")}
        yield Fault("quantization", "taxel", why, np.zeros(len(cells), bool), parameters)


def _other_units(cells: Cells, scans: list[SpreadScan]) -> Iterator[Fault]:
    """Faults for whole scans in another unit: they differ from most scans by a unit's factor, or have sizes that no skin has."""
    answering = np.array([s for s in cells.scans if answers(cells.only(cells.scan == s))], int)
    if not answering.size:
        return
    parts = [cells.only(cells.scan == s) for s in answering]
    fits = [zeroed_start(Cells(**{**vars(one), "scan": np.zeros(len(one), int)})) for one in parts]
    stiffness = np.array([f.k[0] / f.scale.deepest for f in fits])
    width = np.array([f.values["width"] for f in fits])
    for what, value in (("force over depth", stiffness), ("width", width)):
        most = _alike(value)
        names = [scans[int(s)].name for s in answering[most]]
        either = f" (it may as well be the unit of {' and '.join(names)} that is wrong)" if 2 * most.sum() <= most.size else ""
        for s, ratio in zip(answering[~most], value[~most] / np.median(value[most]), strict=True):
            factor = factor_near(ratio)
            if factor is not None and factor > 0.0:
                other = f"{ratio:.4g} times that of {names[0] if len(names) == 1 else 'most scans'}"
                why = f"the {what} of {scans[int(s)].name} is {other}: a factor that only a unit has ({FACTORS[factor]}){either}"
                yield Fault("data_error", "rig", why, cells.scan == s, {"factor": quantity(factor, "1")})
    for s, one in zip(answering, width, strict=True):
        yield from _insane(scans[int(s)], float(one), len(cells))


def _alike(value: np.ndarray) -> np.ndarray:
    """Mask of the values that differ by no factor of units from each other: the largest such group, the first of equal ones."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = value[:, None] / value
    near = (ratio > 0.4) & (ratio < 2.5)
    return near[np.argmax(near.sum(axis=1))]


def _insane(scan: SpreadScan, width: float, n: int) -> Iterator[Fault]:
    """Faults for widths, depths and forces outside the range of robot skin (SANE)."""
    sizes = {"distance": width, "depth": float(scan.depth.max()), "force": float(np.nanmax(np.abs(scan.force)))}
    for what, value in sizes.items():
        unit, (low, high) = "N" if what == "force" else "m", SANE[what]
        if not low < value < high:
            why = f"the {what}s of {scan.name} are of the order of {value:.2g} {unit}: check their unit"
            yield Fault("data_error", "rig", why, np.zeros(n, bool), {what: quantity(value, unit)})


def _words(declared: Declared, step: float | None, searched: bool, asked: bool) -> dict[str, str]:
    """For each cause that is decided here: empty where it was looked for, else why it could not be. `searched` says whether the tables were
    searched, `asked` whether every scan was asked whether its taxel answers."""
    slips = "" if searched else TOO_FEW
    words = {"outliers": slips, "dead_taxel": "" if asked else TOO_FEW, "data_error": slips, "quantization": "", "noise": ""}
    if not declared.taxel_step_n:
        words["quantization"] = "rig.yaml does not declare taxel_step_n" + (f"; the readings are {step:.3g} N apart" if step else "")
    if not declared.taxel_noise_n:
        words["noise"] = "rig.yaml does not declare taxel_noise_n"
    return words


def _off_level(scans: list[SpreadScan]) -> Iterator[str]:
    """Warnings for readings on no level of the converter: too small an error to matter in a fit, but the converter cannot have written
    them."""
    for scan in scans:
        d, j = np.nonzero(np.isfinite(scan.force))
        found: Levels | None = find_levels(scan.force[d, j])
        for i in () if found is None else found.off:
            yield (
                f"{scan.name}: the reading {scan.force[d[i], j[i]]:.3g} N of {mm(scan.depth[d[i]])} depth and {mm(scan.distance[j[i]])} "
                f"sits on no level of the converter, whose steps are {found.step:.3g} N: misread or misprinted"
            )
