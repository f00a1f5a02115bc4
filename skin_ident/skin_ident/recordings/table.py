"""Tables as recordings; they are read by `skin_models.tables`, as in the driver's replay."""

from pathlib import Path

import numpy as np

from skin_ident.recordings.assemble import Channels, assemble
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.recording import Recording
from skin_models.errors import TableError
from skin_models.tables import table as tables
from skin_models.tables.text import header_of, read_text
from skin_models.tables.units import kind_of

SCAN = "; a static spread scan, whose rows are depths, reads depth_mm, f_0mm_n, f_1mm_n, … by distance from the taxel"


def read_table(path: Path, declared: Declared, keep: bool = False, text: str | None = None) -> Recording:
    """The recording in a table; `keep` leaves uneven times as they are. Raises `RecordingError`, or `TableError`."""
    try:
        table = tables.read_table(path, text)
    except TableError as error:
        raise RecordingError(f"{error}{_or_a_scan(path, text)}") from error
    if table.t is None and declared.sample_rate_hz is None:
        raise RecordingError(f"{path} has no time column: add t_s, or declare sample_rate_hz in rig.yaml")
    t = np.arange(table.values.shape[1]) / declared.sample_rate_hz if table.t is None else table.t
    channels = [Channels(c.kind, (c.name,), c.unit, y[None]) for c, y in zip(table.columns, table.values, strict=True)]
    return assemble(path.name, t, channels, declared, (*table.warnings, *tables.renumbered(table.columns)), keep)


def _or_a_scan(path: Path, text: str | None) -> str:
    """A hint at the format of spread scans, where the header begins with a depth, has no time, and has columns of unknown names; else
    empty."""
    titles = header_of(read_text(path) if text is None else text)[0]
    kinds = [kind_of(title) for title in titles]
    strange = any(k == "taxel" and not t.lower().startswith("taxel") for k, t in zip(kinds, titles, strict=True))
    return SCAN if strange and kinds[0] == "depth" and "time" not in kinds else ""
