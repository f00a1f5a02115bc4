"""Tab- or comma-separated tables of one recording, with units in the header: `t_s  x_mm  force_n  taxel_0_n  …`. Read and written."""

import csv
import os
import re
from pathlib import Path

import numpy as np

from skin_models.whole_file import whole_file
from skin_testbed_driver.rig import RigError
from skin_testbed_driver.rigs.replay import Recorded, Track

_LENGTHS = {"mm": 1e-3, "um": 1e-6, "m": 1.0}


def read_table(path: str | os.PathLike) -> Recorded:
    """The recording in a table. Raises `RigError` naming the file and what is wrong with it."""
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise RigError(f"cannot read the table {path}: {getattr(error, 'strerror', None) or 'it is not UTF-8 text'}") from error
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    if len(lines) < 3:
        raise RigError(f"{path} needs a header and two or more rows")
    rows = list(csv.reader(lines, delimiter="\t" if "\t" in lines[0] else ",", skipinitialspace=True))
    try:
        return _recorded(rows)
    except RigError as error:
        raise RigError(f"{path}: {error}") from error


def write_table(path: str | os.PathLike, recorded: Recorded) -> int:
    """Write `recorded` with tabs between its columns, a row for every sample of depth, and return how many rows that is.

    Force and taxels that were sampled at other times are interpolated; nan is what nobody knows. Depths are written to the picometre,
    forces to the nanonewton. Raises `RigError` where `path` exists or cannot be written; then nothing is left there.
    """
    t, path = recorded.depth.t, Path(path)
    force, taxels = recorded.force.at(t), recorded.taxels.at(t)
    titles = ["t_s", "x_mm", "force_n", *(f"taxel_{i}_n" for i in range(taxels.shape[1]))]
    columns = np.round(np.column_stack([t - t[0], 1e3 * recorded.depth.values, force, taxels]), 9)
    lines = ["\t".join(titles), *("\t".join(map(repr, row)) for row in columns.tolist())]
    if path.exists():
        raise RigError(f"{path} exists already: choose another name, nothing is overwritten")
    try:
        with whole_file(path) as partial:
            partial.write_text("\n".join(lines) + "\n", encoding="utf-8")
    except OSError as error:
        raise RigError(f"cannot write the table {path}: {error.strerror}") from error
    return t.size


def _recorded(rows: list[list[str]]) -> Recorded:
    names = [name.strip().lower() for name in rows[0]]
    if {len(row) for row in rows} != {len(names)}:
        raise RigError("its rows differ in length from the header")
    try:
        values = np.array([[float(cell) if cell.strip() else np.nan for cell in row] for row in rows[1:]])
    except ValueError as error:
        raise RigError(f"something in it is no number: {error}") from error
    t = _column(names, values, "t_s")
    if (np.diff(t) <= 0.0).any():
        raise RigError("its times do not grow")
    return Recorded(Track(t, _depth(names, values)), Track(t, _column(names, values, "force_n")), Track(t, values[:, _taxels(names)]))


def _taxels(names: list[str]) -> list[int]:
    """The columns of the taxels, in the order of their numbers."""
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice:
        raise RigError(f"it has two columns {twice}")
    numbers = {i: re.fullmatch(r"taxel_(\d+)_n", name) for i, name in enumerate(names) if name.startswith("taxel")}
    strange = next((names[i] for i, number in numbers.items() if number is None), None)
    if strange:
        raise RigError(f"column {strange} is not understood: a taxel's is taxel_0_n, in newtons")
    return sorted(numbers, key=lambda i: int(numbers[i][1]))


def _depth(names: list[str], values: np.ndarray) -> np.ndarray:
    for unit, factor in _LENGTHS.items():
        if f"x_{unit}" in names:
            return factor * values[:, names.index(f"x_{unit}")]
    raise RigError("it has no column x_mm (or x_m, x_um)")


def _column(names: list[str], values: np.ndarray, name: str) -> np.ndarray:
    if name not in names:
        raise RigError(f"it has no column {name}")
    return values[:, names.index(name)]
