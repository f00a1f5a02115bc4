"""Static spread scans as tables: rows of depth, columns of distance, `depth_mm, f_0mm_n, f_1mm_n, …` (as thesis Table 4-10)."""

import re
from pathlib import Path

import numpy as np

from skin_ident.recordings.declared import Declared
from skin_ident.recordings.errors import RecordingError
from skin_ident.spread_scan import SpreadScan, SpreadScanError
from skin_models.errors import TableError
from skin_models.tables.text import header_of, read_rows, read_text
from skin_models.tables.units import FORCE, LENGTH, column

# f_1mm_n, f_-2.5mm_n, F 3 mm (N), taxel_0_at_4mm_n
_DISTANCE = re.compile(r"(?:.*?[_ ])??(-?\d+(?:\.\d+)?)[ _]*(mm|um|µm|cm|m)(?:[ _]*[(\[]?(mn|kn|n|gf|kgf|lbf|v|mv)[)\]]?)?")


def is_spread_scan(text: str) -> bool:
    """Whether the header has a depth first and then one distance per column."""
    titles, _ = header_of(text)
    first = titles[0].lower().startswith(("depth", "x", "indentation"))
    return first and len(titles) > 2 and all(_DISTANCE.fullmatch(title.lower()) for title in titles[1:])


def read_spread_scan(path: Path, declared: Declared | None = None) -> SpreadScan:
    """The scan in a table; an empty cell is a lost measurement. Raises `RecordingError`."""
    titles, values, _ = read_rows(read_text(path), path)
    try:
        depth, columns = column(titles[0]), [_column(title) for title in titles[1:]]
        distances = np.array([distance for distance, _ in columns])
        order = np.argsort(distances, kind="stable")
        force = np.array([factor for _, factor in columns])[:, None] * values[1:]
        return SpreadScan(depth.factor * values[0], distances[order], force[order].T, name=path.name, declared=declared or Declared())
    except (RecordingError, TableError, SpreadScanError) as error:
        raise RecordingError(f"{path}: {error}") from error


def _column(title: str) -> tuple[float, float]:
    """Distance (m) of a column, and the factor that converts its values to newtons."""
    number, length, force = _DISTANCE.fullmatch(title.lower()).groups()
    if force not in FORCE:
        raise RecordingError(f"column {title!r} does not say its unit of force: write it as f_{number}{length}_n")
    return float(number) * LENGTH[length], FORCE[force]
