"""Tables as recordings; the reading itself is that of `skin_models.tables`, which the driver's replay shares."""

from pathlib import Path

import numpy as np

from skin_ident.recordings.assemble import Channels, assemble
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.recording import Recording
from skin_models.tables import table as tables


def read_table(path: Path, declared: Declared, keep: bool = False, text: str | None = None) -> Recording:
    """The recording in a table; `keep` leaves uneven times as they are. Raises `RecordingError`, or `TableError`."""
    table = tables.read_table(path, text)
    if table.t is None and declared.sample_rate_hz is None:
        raise RecordingError(f"{path} has no time column: add t_s, or declare sample_rate_hz in rig.yaml")
    t = np.arange(table.values.shape[1]) / declared.sample_rate_hz if table.t is None else table.t
    channels = [Channels(c.kind, (c.name,), c.unit, y[None]) for c, y in zip(table.columns, table.values, strict=True)]
    return assemble(path.name, t, channels, declared, (*table.warnings, *tables.renumbered(table.columns)), keep)
