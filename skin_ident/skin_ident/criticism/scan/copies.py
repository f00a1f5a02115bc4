"""Rows and columns that occur twice, digit for digit: within a scan, between scans, and in the thesis's Table 4-10.

Two cells with expected forces m1 and m2, noise sigma and resolution q are equal by chance with probability about

    P = q / (2 sqrt(pi) sigma) exp(-(m1 - m2)^2 / (4 sigma^2)),  at most 1

so the evidence of a run of equal cells is the sum of -log P (nats). Coarse steps and weak forces make equal cells common, and such runs
count for little.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.fault import Fault, mm
from skin_ident.criticism.scan.rough import OF_FORCE, Rough
from skin_ident.criticism.telemetry.symptom import quantity
from skin_ident.spread_scan import SpreadScan
from skin_models.tables.units import FORCE
from skin_models.thesis.tables import scan as thesis_table

DOUBT = np.log(1e4)  # nats by which the evidence of a run must exceed the logarithm of the number of places it could stand in
MOST = 0.85  # share of the readings that must fit the resolution; one row in another unit may have more decimals
LAST = sorted((FORCE[unit] * 10.0**-decimals for unit in ("n", "kgf", "lbf") for decimals in range(7)), reverse=True)  # N, coarse to fine
SHORTEST = 4  # equal cells in a row that count as a run
FEWEST_VALUES = 4  # different values that a row must have to be recognised in the thesis's table
REFERENCE = "thesis Table 4-10 (4 mm silicone)"


@dataclass(frozen=True, eq=False)
class _Line:
    """One row (or column) of one scan: its number `group`, positions `at` along it, forces, expected forces, and its depth (or distance)
    `place`, m."""

    scan: int
    group: int
    at: np.ndarray
    y: np.ndarray
    expected: np.ndarray
    place: float


def find_copies(cells: Cells, table: Rough, scans: list[SpreadScan], step: float | None) -> list[Fault]:
    """Faults for copied rows and columns. `step` is the converter's, N; None where readings show none."""
    q = step or resolution(cells.y)
    rows = list(_lines(cells, table, cells.row, cells.column, cells.z))
    columns = list(_lines(cells, table, cells.column, cells.row, cells.r))
    found = [*_twins(rows, "row", "depth", cells, table, q, scans), *_twins(columns, "column", "distance", cells, table, q, scans)]
    seen = np.any([f.bad for f in found], axis=0) if found else np.zeros(len(cells), bool)
    return [*found, *(f for f in _from_thesis(cells, scans) if not np.all(seen[f.bad]))]


def resolution(y: np.ndarray) -> float:
    """The unit of the last decimal that most readings have, N: a decimal of the unit of force that they were written in."""
    for q in LAST:
        if np.mean(np.abs(y / q - np.round(y / q)) < 1e-6) > MOST:
            return q
    return 1e-7


def _lines(cells: Cells, table: Rough, group: np.ndarray, along: np.ndarray, place: np.ndarray) -> Iterator[_Line]:
    for g in np.unique(group):
        mine = np.flatnonzero(group == g)
        mine = mine[np.argsort(along[mine], kind="stable")]
        yield _Line(int(cells.scan[mine[0]]), int(g), along[mine], cells.y[mine], table.expected[mine], float(place[mine[0]]))


def _twins(lines: list[_Line], word: str, what: str, cells: Cells, table: Rough, q: float, scans: list[SpreadScan]) -> Iterator[Fault]:
    sigma = np.hypot(table.sigma, q / np.sqrt(12.0))
    pairs = [(a, b) for i, a in enumerate(lines) for b in lines[i + 1 :] if a.y.size == b.y.size]
    taken: set[int] = set()
    for a, b in pairs:
        size, start, stop = _run(a, b, q, sigma)
        if stop - start < SHORTEST or size < DOUBT + np.log(max(len(pairs), 1) * a.y.size**2) or {a.group, b.group} & taken:
            continue
        wrong, right = _blame(a, b, slice(start, stop), table)
        taken.add(wrong.group)
        group, along = (cells.row, cells.column) if word == "row" else (cells.column, cells.row)
        bad = (group == wrong.group) & np.isin(along, wrong.at[start:stop])
        n, whole = stop - start, stop - start == wrong.y.size
        other = f"that of {mm(right.place)}" + ("" if right.scan == wrong.scan else f" in {scans[right.scan].name}")
        share = f"all {n}" if whole else f"{n} of {wrong.y.size}"
        why = f"in {scans[wrong.scan].name}, {share} readings of the {word} of {mm(wrong.place)} repeat {other} digit for digit"
        yield Fault("data_error", "rig", why, bad, {what: quantity(wrong.place, "m"), f"repeats_{what}": quantity(right.place, "m")})


def _run(a: _Line, b: _Line, q: float, sigma: float) -> tuple[float, int, int]:
    """Evidence (nats), start and stop of the run of equal cells with the most evidence."""
    chance = np.log(q / (2.0 * np.sqrt(np.pi) * sigma)) - ((a.expected - b.expected) / (2.0 * sigma)) ** 2
    worth = np.where(a.y == b.y, np.maximum(-chance, 0.0), -np.inf)
    best, total, start = (0.0, 0, 0), 0.0, 0
    for i, w in enumerate(worth):
        if not np.isfinite(w):
            total, start = 0.0, i + 1
            continue
        total += w
        best = max(best, (total, start, i + 1), key=lambda found: found[0])
    return best


def _blame(a: _Line, b: _Line, cut: slice, table: Rough) -> tuple[_Line, _Line]:
    """The line that fits the rest of the table worse (taken for the copy), and the other."""
    off = [float(np.sum(((line.y - line.expected)[cut] / np.hypot(table.sigma, OF_FORCE * line.expected[cut])) ** 2)) for line in (a, b)]
    return (a, b) if off[0] > off[1] else (b, a)


def _from_thesis(cells: Cells, scans: list[SpreadScan]) -> Iterator[Fault]:
    """Faults for rows that also occur in the thesis's silicone scan, but there at another depth or other distances. The thesis's own table,
    where every row is at its place, is no fault."""
    depth, distance, force = thesis_table("4-10")
    for i, scan in enumerate(scans):
        first = int(sum(s.depth.size for s in scans[:i]))
        same = [(d, e) for d, row in enumerate(scan.force) for e, known in enumerate(force) if _same(row, known)]
        elsewhere = [(d, e) for d, e in same if not _same_place(scan, d, distance, depth[e])]
        if not elsewhere:
            continue
        bad = np.isin(cells.row, [first + d for d, _ in elsewhere])
        rows = ", ".join(f"{1e3 * scan.depth[d]:.4g}" for d, _ in elsewhere)
        twins = ", ".join(f"{1e3 * depth[e]:.4g}" for _, e in elsewhere)
        why = (
            f"{len(elsewhere)} of {scan.depth.size} rows of {scan.name} ({rows} mm) are the rows of {twins} mm of {REFERENCE}, "
            "digit for digit, set against other depths or distances: copied, not measured"
        )
        yield Fault("data_error", "rig", why, bad, {"copied_rows": quantity(len(elsewhere), "1")})


def _same(row: np.ndarray, known: np.ndarray) -> bool:
    return row.size == known.size and np.array_equal(row, known) and np.unique(row).size >= FEWEST_VALUES


def _same_place(scan: SpreadScan, d: int, distance: np.ndarray, depth: float) -> bool:
    return np.isclose(scan.depth[d], depth, rtol=1e-6) and np.allclose(scan.distance, distance, atol=1e-9)
