"""Tables: one row per sample, tab, comma or semicolon between the columns, units in the header (see `units`)."""

import io
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from skin_ident.recordings.assemble import Channels, assemble
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.recording import Recording
from skin_ident.recordings.timing import counted
from skin_ident.recordings.units import Column, column

PROBES = 50  # rows in which decimal commas are looked for


def read_text(path: Path) -> str:
    """The text of a table. Raises `RecordingError` for one that is empty or no text."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise RecordingError(f"cannot read {path}: {getattr(error, 'strerror', None) or 'it is not text'}") from error
    if not text.strip():
        raise RecordingError(f"{path} is empty")
    return text.replace('"', "")  # some programs put every cell in quotes


def header_of(text: str) -> tuple[list[str], str]:
    """The column titles and the separator."""
    line = next((line for line in text.splitlines() if line.strip() and not line.startswith("#")), "")
    mark = max("\t,;", key=line.count)
    return [title.strip() for title in line.split(mark)], mark


def read_rows(text: str, path: Path) -> tuple[list[str], np.ndarray, tuple[str, ...]]:
    """Titles, values (columns, rows) with NaN where there is no number, and warnings. Raises `RecordingError`."""
    titles, mark = header_of(text)
    if not any(titles):
        raise RecordingError(f"{path} holds nothing but comments")
    if all(_is_number(title) for title in titles):
        raise RecordingError(f"{path} has no header: its first line must name the columns with units, as in t_s, x_mm, force_n")
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")][1:]
    if not lines:
        raise RecordingError(f"{path} has a header but no rows")
    if mark not in lines[0] and len(lines[0].split()) > 1:
        raise RecordingError(f"{path}: columns are to be separated by tabs, commas or semicolons, not by spaces")
    try:
        values = np.loadtxt(io.StringIO("\n".join(lines)), delimiter=mark, ndmin=2, unpack=True, comments=None)
    except ValueError:
        return _carefully(titles, mark, lines, path)
    if len(values) != len(titles):
        raise RecordingError(f"{path}: the rows have {counted(len(values), 'column')}, the header {len(titles)}")
    return titles, values, ()


def _carefully(titles: list[str], mark: str, lines: list[str], path: Path) -> tuple[list[str], np.ndarray, tuple[str, ...]]:
    """Cell by cell: rows that are cut short are dropped and counted, cells that hold no number become NaN."""
    cells = [line.split(mark) for line in lines]
    whole = [row for row in cells if len(row) == len(titles)]
    if mark == ";" and any("," in c for row in whole[:PROBES] for c in row):
        raise RecordingError(f"{path}: decimal commas are not read; write numbers with a point")
    if len(whole) < 0.9 * len(cells):
        short = counted(len(cells) - len(whole), "row")
        raise RecordingError(f"{path}: {short} of {len(cells)} do not have the {len(titles)} columns of the header")
    values = np.array([[_number(c) for c in row] for row in whole]).T
    lost = len(cells) - len(whole)
    return titles, values, (f"{counted(lost, 'incomplete row')} dropped",) if lost else ()


def read_table(path: Path, declared: Declared, keep: bool = False) -> Recording:
    """The recording in a table; `keep` leaves uneven times as they are. Raises `RecordingError`."""
    text = read_text(path)
    titles, values, warnings = read_rows(text, path)
    try:
        columns = [column(title) for title in titles]
    except RecordingError as error:
        raise RecordingError(f"{path}: {error}") from error
    times = [i for i, c in enumerate(columns) if c.kind == "time"]
    if len(times) > 1:
        raise RecordingError(f"{path} has more than one time column: {', '.join(titles[i] for i in times)}")
    if not times and declared.sample_rate_hz is None:
        raise RecordingError(f"{path} has no time column: add t_s, or declare sample_rate_hz in rig.yaml")
    t = columns[times[0]].factor * values[times[0]] if times else np.arange(values.shape[1]) / declared.sample_rate_hz
    pairs = sorted(zip(columns, values, strict=True), key=lambda pair: _number_of(pair[0]))
    channels = [Channels(c.kind, (c.name,), c.unit, c.factor * y[None]) for c, y in pairs if c.kind != "time"]
    return assemble(path.name, t, channels, declared, (*warnings, *_renumbered([c for c, _ in pairs])), keep)


def _number_of(column: Column) -> float:
    """The number in a taxel's name, by which taxels are put in order; those without one stay behind, in the order of the table."""
    numbered = re.fullmatch(r"taxel_?(\d+)", column.name)
    return int(numbered[1]) if numbered else np.inf


def _renumbered(columns: list[Column]) -> Iterator[str]:
    """What is said where taxels do not count from 0 up without a gap, as they are counted from here on."""
    taxels = [c.name for c in columns if c.kind == "taxel"]
    if any(_number_of(c) not in (i, np.inf) for i, c in enumerate(c for c in columns if c.kind == "taxel")):
        yield f"taxels are counted from 0: {', '.join(f'taxel_{i} is {name}' for i, name in enumerate(taxels))}"


def _is_number(cell: str) -> bool:
    return not np.isnan(_number(cell)) or cell.strip().lower() == "nan"


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return np.nan
