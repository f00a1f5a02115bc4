"""A layout from a table: comma-separated, one taxel per row, with the units in its header.

    name, x_mm, y_mm, z_mm, nx, ny, nz, area_mm2

`name`, `z_mm`, the normal and `area_mm2` may be absent (taxel_<i>, 0, +z, a disc that touches the nearest neighbour's). Lengths may be
given in m as well (x_m, area_m2). Other columns, and rows of another length than the header's, are refused: a decimal comma splits a
number in two.
"""

import csv
import os
from pathlib import Path

import numpy as np

from skin_models.layout import Layout, LayoutError, arbitrary

_LENGTHS = {"mm": 1e-3, "m": 1.0}
_KNOWN = ("name", *(f"{axis}_{unit}" for axis in "xyz" for unit in _LENGTHS), "nx", "ny", "nz", *(f"area_{unit}2" for unit in _LENGTHS))


def load_layout(path: str | os.PathLike) -> Layout:
    """The layout in a file. Raises `LayoutError` naming the file and what is wrong with it."""
    try:
        rows = list(csv.reader(Path(path).read_text(encoding="utf-8-sig").splitlines(), skipinitialspace=True))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise LayoutError(f"cannot read the layout {path}: {getattr(error, 'strerror', None) or error}") from error
    try:
        return _layout([row for row in rows if row and not row[0].startswith("#")])
    except LayoutError as error:
        raise LayoutError(f"{path}: {error}") from error


def _layout(rows: list[list[str]]) -> Layout:
    if len(rows) < 2:
        raise LayoutError("a layout needs a header and one or more taxels")
    header, *body = ([cell.strip() for cell in row] for row in rows)
    _check_table(header, body)
    columns = {name: [row[i] for row in body] for i, name in enumerate(header)}
    positions = np.column_stack([_length(columns, axis, len(body), axis in "xy") for axis in "xyz"])
    normals = np.tile([0.0, 0.0, 1.0], (len(body), 1))
    if any(n in columns for n in ("nx", "ny", "nz")):
        normals = np.column_stack([_numbers(columns, n) for n in ("nx", "ny", "nz")])
    return arbitrary(positions, normals, _area(columns), tuple(columns.get("name", ())))


def _check_table(header: list[str], body: list[list[str]]) -> None:
    unknown = next((name for name in header if name not in _KNOWN), None)
    if unknown is not None:
        raise LayoutError(f"there is a column {unknown!r}, but positions need a unit and only these are known: {', '.join(_KNOWN)}")
    quantities = [name.partition("_")[0] for name in header]
    twice = next((name for name in quantities if quantities.count(name) > 1), None)
    if twice is not None:
        raise LayoutError(f"{twice} is given in two columns")
    odd = next((row for row in body if len(row) != len(header)), None)
    if odd is not None:
        raise LayoutError(f"the row {', '.join(odd)!r} has {len(odd)} cells under a header of {len(header)}")


def _numbers(columns: dict[str, list[str]], name: str) -> np.ndarray:
    if name not in columns:
        raise LayoutError(f"there is no column {name}")
    try:
        return np.array([float(text) for text in columns[name]])
    except ValueError as error:
        raise LayoutError(f"column {name} holds something that is no number: {error}") from error


def _length(columns: dict[str, list[str]], axis: str, count: int, needed: bool) -> np.ndarray:
    for unit, factor in _LENGTHS.items():
        if f"{axis}_{unit}" in columns:
            return factor * _numbers(columns, f"{axis}_{unit}")
    if needed:
        raise LayoutError(f"there is no column {axis}_mm (or {axis}_m): positions need a unit")
    return np.zeros(count)


def _area(columns: dict[str, list[str]]) -> np.ndarray | None:
    for unit, factor in _LENGTHS.items():
        if f"area_{unit}2" in columns:
            return factor**2 * _numbers(columns, f"area_{unit}2")
    return None
