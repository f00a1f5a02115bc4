"""A table as columns of known meaning, in SI units."""

import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from skin_models.errors import TableError
from skin_models.tables.text import read_rows, read_text
from skin_models.tables.units import Column, column
from skin_models.words import counted

FARTHEST = 0.2  # m: no skin is indented so deep
STRONGEST = 1e5  # N


@dataclass(frozen=True, eq=False)
class Table:
    """Stamps t (N,) s, or None where there are none; columns beside them, taxels in the order of their numbers, and values (C, N)."""

    t: np.ndarray | None
    columns: tuple[Column, ...]
    values: np.ndarray
    warnings: tuple[str, ...]

    def of(self, kind: str) -> list[np.ndarray]:
        """The rows of one kind: depth (m), force or taxel (N or V)."""
        return [row for c, row in zip(self.columns, self.values, strict=True) if c.kind == kind]


def read_table(path: str | os.PathLike, text: str | None = None) -> Table:
    """The table in a file, or in its `text` where that was read already. Raises `TableError` naming file and fault."""
    titles, values, warnings = read_rows(read_text(path) if text is None else text, path)
    try:
        columns = [column(title) for title in titles]
        _check_columns(columns, values)
    except TableError as error:
        raise TableError(f"{path}: {error}") from error
    scaled = [c.factor * np.where(np.isfinite(row), row, np.nan) for c, row in zip(columns, values, strict=True)]
    t = next((row for c, row in zip(columns, scaled, strict=True) if c.kind == "time"), None)
    order = sorted((i for i, c in enumerate(columns) if c.kind != "time"), key=lambda i: number_of(columns[i]))
    rows = np.array([scaled[i] for i in order]).reshape(len(order), values.shape[1])
    return Table(t, tuple(columns[i] for i in order), rows, (*warnings, *_infinite(columns, values)))


def _infinite(columns: Sequence[Column], values: np.ndarray) -> Iterator[str]:
    """A warning for every column that holds infinite numbers: they are read as missing ones."""
    for c, row in zip(columns, values, strict=True):
        if endless := np.count_nonzero(np.isinf(row)):
            yield f"{c.name}: {counted(endless, 'infinite number')}, taken for missing"


def _check_columns(columns: Sequence[Column], values: np.ndarray) -> None:
    for kind in ("time", "depth", "force"):
        same = [c.name for c in columns if c.kind == kind]
        if len(same) > 1:
            raise TableError(f"it has more than one {kind}{' column' * (kind == 'time')}: {', '.join(same)}")
    names = [c.name for c in columns]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice:
        raise TableError(f"it has two columns {twice}: leave one out, or give it a name of its own")
    empty = [c.name for c, row in zip(columns, values, strict=True) if c.kind != "taxel" and not np.isfinite(row).any()]
    if empty:
        raise TableError(f"{empty[0]} holds no number; mend it, or leave it out")


def number_of(column: Column) -> float:
    """The number in a taxel's name, by which taxels are put in order; those without one stay behind, in the order of the table."""
    numbered = re.fullmatch(r"taxel_?(\d+)", column.name)
    return int(numbered[1]) if numbered else np.inf


def renumbered(columns: Sequence[Column]) -> Iterator[str]:
    """Yields a note where the taxels' numbers do not run from 0 without a gap: from here on they are counted that way."""
    taxels = [c for c in columns if c.kind == "taxel"]
    if any(number_of(c) not in (i, np.inf) for i, c in enumerate(taxels)):
        yield f"taxels are counted from 0: {', '.join(f'taxel_{i} is {c.name}' for i, c in enumerate(taxels))}"


def check_span(name: str, span: float) -> None:
    """Refuse a depth that only a wrong unit can give; `span` in m. Raises `TableError`."""
    if span > FARTHEST:
        raise TableError(f"{name}: the depth spans {span:.4g} m, more than any skin; is it in mm?")


def check_load(name: str, channel: str, largest: float) -> None:
    """Refuse a load that only a wrong unit can give, N. Raises `TableError`."""
    if largest > STRONGEST:
        raise TableError(f"{name}: {channel} reaches {largest:.4g} N, more than any load cell; check its unit")
