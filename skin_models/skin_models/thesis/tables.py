"""Typed access to the tables of the thesis. Numbers keep their printed digits until they are asked for as SI values."""

import csv
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np

from skin_models.errors import SkinError
from skin_models.thesis.printed import Printed, values

PARAMETERS = ("m", "b1", "k1", "b2", "k2")


@dataclass(frozen=True)
class Table:
    """One table: `rows` maps the entry of its first column to its other cells by column; a cell printed as NA is None."""

    name: str
    columns: tuple[str, ...]
    rows: dict[str, dict[str, Printed | None]]

    def column(self, name: str, only: tuple[str, ...] | None = None) -> list[Printed | None]:
        """One column, from top to bottom; `only` picks rows."""
        return [cells[name] for row, cells in self.rows.items() if only is None or row in only]

    def cell(self, row: str, column: str) -> Printed:
        """One printed number. Raises `SkinError` where the thesis has none."""
        cell = self.rows.get(row, {}).get(column)
        if cell is None:
            raise SkinError(f"Table {self.name} of the thesis has no number in row {row}, column {column}")
        return cell


@cache
def table(name: str) -> Table:
    """A table by its number (`4-10`), or `text` for the numbers in the running text. Raises `SkinError` for one that is not here."""
    path = files("skin_models") / "data" / "thesis" / (f"table_{name.replace('-', '_')}.csv" if name != "text" else "text.csv")
    try:
        content = path.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise SkinError(f"the thesis's tables have no {name!r}; there are 3-1, 3-2, 4-1 to 4-11 and text") from error
    head, *rows = csv.reader(content.splitlines())
    return Table(name, tuple(head[1:]), {row[0]: dict(zip(head[1:], map(_cell, row[1:]), strict=True)) for row in rows})


def _cell(text: str) -> Printed | None:
    try:
        float(text)
    except ValueError:
        return None  # NA, or a word of `text`
    return Printed(text)


@dataclass(frozen=True)
class Estimate:
    """A mean and a standard deviation, SI. `std` is NaN for a single run."""

    value: float
    std: float


def estimates(name: str, row: str) -> dict[str, Estimate]:
    """The dispersion parameters in one row of Tables 4-1 to 4-6, by name; SI (kg, N*s/m, N/m)."""
    cells = table(name).rows[row]
    spread = {p: cells.get(f"{p}_std") for p in PARAMETERS}
    return {p: Estimate(cells[p].value, spread[p].value if spread[p] is not None else float("nan")) for p in PARAMETERS if p in cells}


def scan(name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A spread scan, Table 4-10 (silicone) or 4-11 (Frubber): depth (D,) m, distance (R,) m, sensed force (D, R) N."""
    t = table(name)
    depth = np.array([float(row) for row in t.rows])
    distance = np.array([float(column) for column in t.columns])
    return depth * 1e-3, distance * 1e-3, np.array([values(list(cells.values())) for cells in t.rows.values()])


@dataclass(frozen=True)
class TransferFunction:
    """One row of Table 4-7: eq 32 with its parameters divided by the mass, at one deformation speed."""

    speed: float  # m/s
    b1: float  # 1/s
    k1: float  # 1/s^2
    b2: float  # 1/s
    k2: float  # 1/s^2


def transfer_functions() -> tuple[TransferFunction, ...]:
    """Table 4-7: Frubber, 4 mm, three experiments."""
    rows = table("4-7").rows.values()
    return tuple(TransferFunction(r["speed"].value * 1e-3, *(r[f"{p}_over_m"].value for p in ("b1", "k1", "b2", "k2"))) for r in rows)
