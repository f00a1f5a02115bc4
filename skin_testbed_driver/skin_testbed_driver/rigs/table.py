"""Tab- or comma-separated tables of one recording, with units in the header: `t_s  x_mm  force_n  taxel_0_n  …`. Read and written."""

import os
from pathlib import Path

import numpy as np

from skin_models.errors import TableError
from skin_models.tables import table as tables
from skin_models.tables.order import in_order
from skin_models.whole_file import whole_file
from skin_models.words import counted
from skin_testbed_driver.rig import RigError
from skin_testbed_driver.rigs.replay import Recorded, Track


def read_table(path: str | os.PathLike) -> Recorded:
    """The recording in a table, read as `fit` reads it. Raises `RigError` naming the file and what is wrong with it."""
    try:
        return _recorded(str(path), tables.read_table(path))
    except TableError as error:
        raise RigError(str(error)) from error


def write_table(path: str | os.PathLike, recorded: Recorded) -> int:
    """Write `recorded` with tabs between its columns, a row for every sample of depth, and return how many rows that is.

    Samples of depth before the first of force and taxels, or after their last, are left out: readers would take them for a gap. Force and
    taxels that were sampled at other times are interpolated; nan is unknown. Depths are written to the picometre,
    forces to the nanonewton. Raises `RigError` where `path` exists or cannot be written; then nothing is left there.
    """
    whole, path = _common(recorded), Path(path)
    t, depth = recorded.depth.t[whole], recorded.depth.values[whole]
    force, taxels = recorded.force.at(t), recorded.taxels.at(t)
    titles = ["t_s", "x_mm", "force_n", *(f"taxel_{i}_n" for i in range(taxels.shape[1]))]
    columns = np.round(np.column_stack([t - t[0], 1e3 * depth, force, taxels]), 9)
    lines = ["\t".join(titles), *("\t".join(map(repr, row)) for row in columns.tolist())]
    if path.exists():
        raise RigError(f"{path} exists already: choose another name, nothing is overwritten")
    try:
        with whole_file(path) as partial:
            partial.write_text("\n".join(lines) + "\n", encoding="utf-8")
    except OSError as error:
        raise RigError(f"cannot write the table {path}: {error.strerror}") from error
    return t.size


def _common(recorded: Recorded) -> np.ndarray:
    """A mask (N,) of the samples of depth at which all signals were recorded; all samples, where there are none."""
    t, others = recorded.depth.t, [track for track in (recorded.force, recorded.taxels) if track.values.size]
    if not others:
        return np.ones(t.size, bool)
    common = (t >= max(track.t[0] for track in others)) & (t <= min(track.t[-1] for track in others))
    return common if common.any() else np.ones(t.size, bool)


def _recorded(path: str, table: tables.Table) -> Recorded:
    """What a table holds, put in order. Raises `RigError` where something is missing that replaying needs."""
    if table.t is None:
        raise RigError(f"{path} has no time column: add t_s")
    depth, force, taxels = (table.of(kind) for kind in ("depth", "force", "taxel"))
    for rows, kind, example in ((depth, "depth", "x_mm"), (force, "force", "force_n")):
        if not rows:
            raise RigError(f"{path} has no {kind}: add {example}")
    volts = next((c.name for c in table.columns if c.unit == "V"), None)
    if volts:
        raise RigError(f"{path}: {volts} is in volts: write newtons into it ({volts}_n), or leave it out")
    order, mended = in_order(table.t, path)
    rows = table.values if order is None else table.values[:, order]
    t = table.t if order is None else table.t[order]
    if t.size < 2:
        raise RigError(f"{path} holds {counted(t.size, 'usable sample')}: two or more are needed{_why(mended.notes)}")
    _check_sizes(path, table, depth[0])
    depth, force = (rows[[c.kind == kind for c in table.columns]][0] for kind in ("depth", "force"))
    taxels = rows[[c.kind == "taxel" for c in table.columns]].T
    warnings = (*table.warnings, *tables.renumbered(table.columns), *mended.notes)
    return Recorded(Track(t, depth), Track(t, force), Track(t, taxels), warnings)


def _why(notes: tuple[str, ...]) -> str:
    return f" ({'; '.join(notes)})" if notes else ""


def _check_sizes(path: str, table: tables.Table, depth: np.ndarray) -> None:
    """Refuse what only a wrong unit can give. Raises `TableError`."""
    tables.check_span(path, np.nanmax(depth) - np.nanmin(depth))
    for c, row in zip(table.columns, table.values, strict=True):
        if c.kind != "depth":
            tables.check_load(path, c.name, np.abs(row[~np.isnan(row)]).max(initial=0.0))
