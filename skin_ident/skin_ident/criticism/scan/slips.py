"""Slips of the pen in a table: a row, column or reading in another unit, two that were exchanged, single outliers."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.fault import Fault, mm
from skin_ident.criticism.scan.rough import Rough
from skin_ident.criticism.scan.sharp import sharpened
from skin_ident.criticism.telemetry.symptom import quantity
from skin_ident.spread_scan import SpreadScan

_WORDS = {10.0: "a decimal point, or kgf and N", 100.0: "a decimal point, or gf and N", 1e3: "mN and N", 4.44822: "lbf and N"}
FACTORS = _WORDS | {1.0 / factor: words for factor, words in _WORDS.items()} | {-1.0: "the sign"}
NEAR = 0.08  # largest relative difference between a ratio and a unit's factor
CLEAR = 6.0  # standard deviations by which the ratio of a row or column must differ from 1
ALONE = 2.5  # an outlier must be this many times as far off as the third worst of the other readings
FEWEST = 40  # readings that the sharp fit needs
EXCHANGE = 50.0  # fall of the sum of squared normalised residuals that an exchange must bring
MOST = 0.7  # share of all excess squared normalised residuals that an exchange must explain


@dataclass(frozen=True)
class Marks:
    """Thresholds: a single reading is an outlier beyond `far` standard deviations. Where more than a `share` of the readings is between
    `tailed` and `far`, the noise has heavy tails and no reading counts as an outlier."""

    far: float
    tailed: float
    share: float


ROUGHLY = Marks(15.0, 4.0, 1.0 / 200.0)
SHARPLY = Marks(12.0, 3.0, 1.0 / 100.0)  # for the sharp fit, whose standard deviation is the scatter of the readings


def find_slips(cells: Cells, table: Rough, scans: list[SpreadScan]) -> list[Fault]:
    """Faults, the gravest kind first. Cells of a fault are not searched again for the next kind."""
    found: list[Fault] = []
    clean = np.ones(len(cells), bool)
    for look in (_units_of_rows, _units_of_columns, _exchanged_columns, _exchanged_rows, _exchanged_cells, _strays, _faint_strays):
        for fault in look(cells, table, scans, clean):
            if np.any(fault.bad & clean):
                found.append(fault)
                clean = clean & ~fault.bad
    return found


def factor_near(ratio: float, doubt: float = 0.0) -> float | None:
    """The unit's factor that a ratio is close to, or None; `doubt` is the ratio's relative standard error."""
    return next((f for f in FACTORS if abs(ratio / f - 1.0) < NEAR and doubt < NEAR), None)


def _units_of_rows(cells: Cells, table: Rough, scans: list[SpreadScan], clean: np.ndarray) -> Iterator[Fault]:
    yield from _units(cells, table, scans, clean, cells.row, cells.z, "row", "depth")


def _units_of_columns(cells: Cells, table: Rough, scans: list[SpreadScan], clean: np.ndarray) -> Iterator[Fault]:
    yield from _units(cells, table, scans, clean, cells.column, cells.r, "column", "distance")


def _units(cells, table: Rough, scans, clean: np.ndarray, group: np.ndarray, place: np.ndarray, word: str, what: str) -> Iterator[Fault]:
    for g in np.unique(group[clean]):
        mine = clean & (group == g)
        f, y = table.expected[mine], cells.y[mine]
        square = float(f @ f)
        if square <= 0.0 or mine.sum() < 2:
            continue
        ratio = float(f @ y) / square
        spread = max(float(np.std(y - ratio * f)), table.sigma * min(abs(ratio), 1.0)) / np.sqrt(square)
        factor = factor_near(ratio, spread / max(abs(ratio), 1e-12))
        if factor is None or abs(ratio - 1.0) < CLEAR * max(spread, table.sigma / np.sqrt(square)):
            continue
        at, name = float(place[mine][0]), scans[int(cells.scan[mine][0])].name
        why = f"the {word} of {mm(at)} in {name} is {ratio:.4g} times what the rest of the table says: {FACTORS[factor]}"
        yield Fault("data_error", "rig", why, mine, {what: quantity(at, "m"), "factor": quantity(factor, "1")})


def _exchanged_columns(cells: Cells, table: Rough, scans: list[SpreadScan], clean: np.ndarray) -> Iterator[Fault]:
    yield from _exchanged(cells, table, scans, clean, cells.column, cells.row, cells.r, "columns")


def _exchanged_rows(cells: Cells, table: Rough, scans: list[SpreadScan], clean: np.ndarray) -> Iterator[Fault]:
    yield from _exchanged(cells, table, scans, clean, cells.row, cells.column, cells.z, "rows")


def _exchanged(cells, table: Rough, scans, clean, group: np.ndarray, along: np.ndarray, place: np.ndarray, words: str) -> Iterator[Fault]:
    """The exchange of two whole rows (or columns) of one scan that lowers the squared residuals most, if it explains most of the excess."""
    strange = np.where(clean, table.strangeness(cells) ** 2, 0.0)
    excess = float(np.sum(np.maximum(strange - 1.0, 0.0)))
    best = None
    for s in cells.scans:
        groups = np.unique(group[(cells.scan == s) & clean])
        for a, b in combinations(groups, 2):
            one, two = (np.flatnonzero(clean & (group == g)) for g in (a, b))
            if one.size != two.size or not np.array_equal(along[one], along[two]):
                continue
            after = np.r_[_strange_at(cells, table, one, two), _strange_at(cells, table, two, one)]
            fall = float(strange[one].sum() + strange[two].sum() - after.sum())
            if best is None or fall > best[0]:
                best = (fall, one, two, float(after.mean()))
    if best is None or best[0] < max(EXCHANGE, MOST * excess) or best[3] > 4.0:
        return
    _, one, two, _ = best
    bad = np.zeros(len(cells), bool)
    bad[one] = bad[two] = True
    at = place[one[0]], place[two[0]]
    name = scans[int(cells.scan[one[0]])].name
    why = f"the {words} of {mm(at[0])} and {mm(at[1])} in {name} fit each other's place, and neither its own: exchanged"
    yield Fault("data_error", "rig", why, bad, {"first": quantity(at[0], "m"), "second": quantity(at[1], "m")})


def _strange_at(cells: Cells, table: Rough, read: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Squared normalised residuals of the readings of cells `read` if they belonged to the cells `place`."""
    return ((cells.y[read] - table.expected[place]) / table.tolerance[place]) ** 2


def _exchanged_cells(cells: Cells, table: Rough, scans: list[SpreadScan], clean: np.ndarray) -> Iterator[Fault]:
    """Two readings of one row that were exchanged."""
    e = np.abs(table.strangeness(cells))
    odd = np.flatnonzero(clean & (e > CLEAR / 2.0))
    for i, j in combinations(odd, 2):
        if cells.row[i] != cells.row[j]:
            continue
        after = abs(cells.y[i] - table.expected[j]) / table.tolerance[j], abs(cells.y[j] - table.expected[i]) / table.tolerance[i]
        if e[i] ** 2 + e[j] ** 2 - after[0] ** 2 - after[1] ** 2 > EXCHANGE + 2.0 * np.log(len(cells)) and max(after) < 2.5:
            bad = np.zeros(len(cells), bool)
            bad[[i, j]] = True
            where = f"at {mm(cells.z[i])} in {scans[int(cells.scan[i])].name}"
            why = f"{where}, the readings of {mm(cells.r[i])} and {mm(cells.r[j])} fit each other's place: exchanged"
            yield Fault("data_error", "rig", why, bad, {"depth": quantity(cells.z[i], "m")})


def _strays(cells: Cells, table: Rough, scans: list[SpreadScan], clean: np.ndarray, m: Marks = ROUGHLY) -> Iterator[Fault]:
    """Single outliers whose neighbours are not off in the same direction."""
    t = table.strangeness(cells)
    e = np.where(clean, np.abs(t), 0.0)
    if np.sum((e > m.tailed) & (e < m.far)) > m.share * len(cells):
        return
    for i in np.argsort(-e)[:3]:
        if e[i] < m.far:
            return
        row, column = cells.row == cells.row[i], cells.column == cells.column[i]
        beside = (row & (np.abs(cells.column - cells.column[i]) == 1)) | (column & (np.abs(cells.row - cells.row[i]) == 1))
        others = np.delete(e, i)
        if np.any(e[beside] * np.sign(t[beside]) * np.sign(t[i]) > CLEAR / 2.0) or e[i] < ALONE * np.partition(others, -3)[-3]:
            continue
        yield _stray(cells, table, scans, i)


def _faint_strays(cells: Cells, table: Rough, scans: list[SpreadScan], clean: np.ndarray) -> Iterator[Fault]:
    """The same with the sharp fit, for outliers within the tolerance of the rough one."""
    sharp = sharpened(cells.only(clean), table.only(clean)) if clean.sum() >= FEWEST else None
    for fault in () if sharp is None else _strays(cells.only(clean), sharp, scans, np.ones(int(clean.sum()), bool), SHARPLY):
        yield fault.among(clean)


def _stray(cells: Cells, table: Rough, scans: list[SpreadScan], i: int) -> Fault:
    bad = np.zeros(len(cells), bool)
    bad[i] = True
    place = f"the reading of {mm(cells.z[i])} depth and {mm(cells.r[i])} in {scans[int(cells.scan[i])].name}"
    expected = table.expected[i]
    factor = factor_near(cells.y[i] / expected, table.tolerance[i] / max(abs(expected), 1e-12)) if expected else None
    parameters = {"depth": quantity(cells.z[i], "m"), "distance": quantity(cells.r[i], "m"), "expected": quantity(expected, "N")}
    cell = {"recording": scans[int(cells.scan[i])].name, "read": quantity(cells.y[i], "N"), **parameters}
    if factor is not None:
        why = f"{place} is {cells.y[i] / expected:.4g} times what its neighbours say: {FACTORS[factor]}"
        return Fault("data_error", "rig", why, bad, parameters, (("outliers", "taxel"),), (cell,))
    why = f"{place} is {cells.y[i]:.3g} N where its neighbours say {expected:.3g} N"
    return Fault("outliers", "taxel", why, bad, parameters, (("data_error", "rig"),), (cell,))
