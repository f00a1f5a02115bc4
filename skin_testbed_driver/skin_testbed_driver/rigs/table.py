"""Tab- or comma-separated tables of one recording, with units in the header: `t_s  x_mm  force_n  taxel_0_n  …`."""

import csv
import os
from pathlib import Path

import numpy as np

from skin_testbed_driver.rig import RigError
from skin_testbed_driver.rigs.replay import Recorded, Track

_LENGTHS = {"mm": 1e-3, "um": 1e-6, "m": 1.0}


def read_table(path: str | os.PathLike) -> Recorded:
    """The recording in a table. Raises `RigError` naming the file and what is wrong with it."""
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise RigError(f"cannot read the table {path}: {getattr(error, 'strerror', None) or error}") from error
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    if len(lines) < 3:
        raise RigError(f"{path} needs a header and two or more rows")
    rows = list(csv.reader(lines, delimiter="\t" if "\t" in lines[0] else ",", skipinitialspace=True))
    try:
        return _recorded(rows)
    except RigError as error:
        raise RigError(f"{path}: {error}") from error


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
    taxels = [i for i, name in enumerate(names) if name.startswith("taxel_") and name.endswith("_n")]
    return Recorded(Track(t, _depth(names, values)), Track(t, _column(names, values, "force_n")), Track(t, values[:, taxels]))


def _depth(names: list[str], values: np.ndarray) -> np.ndarray:
    for unit, factor in _LENGTHS.items():
        if f"x_{unit}" in names:
            return factor * values[:, names.index(f"x_{unit}")]
    raise RigError("it has no column x_mm (or x_m, x_um)")


def _column(names: list[str], values: np.ndarray, name: str) -> np.ndarray:
    if name not in names:
        raise RigError(f"it has no column {name}")
    return values[:, names.index(name)]
