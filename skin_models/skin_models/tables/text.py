"""The text of a table: one row per sample, tab, comma or semicolon between the columns, a header, comments after #."""

import io
import os
from pathlib import Path

import numpy as np

from skin_models.errors import TableError
from skin_models.words import counted

SUFFIXES = (".csv", ".tsv", ".txt", ".tab", ".dat")
PROBES = 50  # rows in which decimal commas are looked for
WHOLE = 0.9  # share of the rows, and of the cells of a column, that must be intact: more damage is no single accident
MISSING = ("", "-", "--", "na", "n/a", "#n/a", "null", "none")  # what programs write where nothing was measured, beside nan


def read_text(path: str | os.PathLike) -> str:
    """The text of a table. Raises `TableError` for one that is empty or no text."""
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise TableError(f"cannot read {path}: {getattr(error, 'strerror', None) or 'it is not UTF-8 text; save it as UTF-8'}") from error
    if not text.strip():
        raise TableError(f"{path} is empty")
    return text.replace('"', "")  # some programs put every cell in quotes


def header_of(text: str) -> tuple[list[str], str]:
    """The column titles and the separator."""
    line = next((line for line in text.splitlines() if line.strip() and not line.startswith("#")), "")
    mark = max("\t,;", key=line.count)
    return [title.strip() for title in line.split(mark)], mark


def read_rows(text: str, path: str | os.PathLike) -> tuple[list[str], np.ndarray, tuple[str, ...]]:
    """Titles, values (columns, rows) with NaN where there is no number, and warnings. Raises `TableError`."""
    titles, mark = header_of(text)
    if not any(titles):
        raise TableError(f"{path} holds nothing but comments")
    if all(_is_number(title) for title in titles):
        raise TableError(f"{path} has no header: its first line must name the columns with units, as in t_s, x_mm, force_n")
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")][1:]
    if not lines:
        raise TableError(f"{path} has a header but no rows")
    if mark not in lines[0] and len(lines[0].split()) > 1:
        raise TableError(f"{path}: columns are to be separated by tabs, commas or semicolons, not by spaces")
    try:
        values = np.loadtxt(io.StringIO("\n".join(lines)), delimiter=mark, ndmin=2, unpack=True, comments=None)
    except ValueError:
        return _carefully(titles, mark, lines, path)
    if len(values) != len(titles):
        commas = ": are its decimals written with commas? write them with points" if mark == "," and len(values) == 2 * len(titles) else ""
        raise TableError(f"{path}: the rows have {counted(len(values), 'column')}, the header {len(titles)}{commas}")
    return titles, values, ()


def _carefully(titles: list[str], mark: str, lines: list[str], path: str | os.PathLike) -> tuple[list[str], np.ndarray, tuple[str, ...]]:
    """Cell by cell: empty cells become NaN. Rows that are cut short, or hold text where a number belongs, are dropped and counted: what
    damaged one cell may have damaged those beside it."""
    cells = [line.split(mark) for line in lines]
    whole = [row for row in cells if len(row) == len(titles)]
    if mark != "," and any("," in c for row in whole[:PROBES] for c in row):
        raise TableError(f"{path}: decimal commas are not read; write numbers with a point")
    if len(whole) < WHOLE * len(cells):
        short = counted(len(cells) - len(whole), "row")
        raise TableError(f"{path}: {short} of {len(cells)} do not have the {len(titles)} columns of the header")
    lost = len(cells) - len(whole)
    notes = [f"{counted(lost, 'incomplete row')} dropped"] if lost else []
    values, damaged = np.array([[_number(c) for c in row] for row in whole]).T, np.zeros(len(whole), bool)
    for title, numbers, column in zip(titles, values, zip(*whole, strict=True), strict=True):
        strange = [i for i in np.flatnonzero(np.isnan(numbers)) if _is_text(column[i])]
        if strange:
            notes.append(_quoted(title, [column[i].strip() for i in strange], len(whole), path))
            damaged[strange] = True
    return titles, values[:, ~damaged], tuple(notes)


def _quoted(title: str, strange: list[str], rows: int, path: str | os.PathLike) -> str:
    """A warning of the text that stands for numbers in a column. Raises `TableError` where it stands in more than a tenth of its cells."""
    if len(strange) > (1.0 - WHOLE) * rows:
        raise TableError(
            f"{path}: {strange[0]!r} in column {title} is no number ({len(strange)} of {rows} cells there hold text): "
            "mend the column, leave it out, or leave cells empty where nothing was measured"
        )
    return f"{counted(len(strange), 'row')} with text in column {title} ({strange[0]!r}) dropped"


def _is_text(cell: str) -> bool:
    return cell.strip().lower() not in MISSING and not _is_number(cell)


def _is_number(cell: str) -> bool:
    return not np.isnan(_number(cell)) or cell.strip().lower().lstrip("+-") == "nan"


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return np.nan
