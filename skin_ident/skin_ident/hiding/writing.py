"""Writes recordings as tables, with a rig.yaml that says what is known of them."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import fields
from pathlib import Path

import numpy as np
import yaml

from skin_ident.hiding.errors import HidingError
from skin_ident.recordings.declared import FILE_NAME, Declared
from skin_ident.recordings.load import RECORDED
from skin_ident.recordings.recording import Recording
from skin_models.whole_file import whole_file


def check_free(folder: Path) -> None:
    """Raise `HidingError` for a folder that holds recordings or a rig.yaml: they may be somebody's own, or from an earlier run."""
    taken = (p for p in folder.glob("*") if p.name == FILE_NAME or p.suffix.lower() in RECORDED or p.name.startswith("session_"))
    there = sorted(p.name for p in taken)
    if there:
        raise HidingError(f"{folder} already holds {there[0]}, and nothing is overwritten: name another folder")


def write_recordings(recordings: list[Recording], folder: Path) -> list[Path]:
    """Write one table per session with its rig.yaml, each in a folder of its own where the sessions do not share one rig: all of them, or
    none. Returns the paths of the tables. Raises `HidingError` where the folder is not free, or `OSError`."""
    with whole_recordings(recordings, folder) as tables:
        return tables


@contextmanager
def whole_recordings(recordings: list[Recording], folder: Path) -> Iterator[list[Path]]:
    """As `write_recordings`; the files are put in place at the end of the block, if nothing fails in it."""
    check_free(folder)
    alike = all(r.declared == recordings[0].declared for r in recordings)
    places = [folder if alike else folder / f"session_{i}" for i in range(1, len(recordings) + 1)]
    tables = [place / f"session_{i}.csv" for i, place in enumerate(places, 1)]
    try:
        with ExitStack() as together:
            for r, place, table in zip(recordings, places, tables, strict=True):
                place.mkdir(parents=True, exist_ok=True)
                _table(r, together.enter_context(whole_file(table)))
            for place, declared in {place: r.declared for r, place in zip(recordings, places, strict=True)}.items():
                together.enter_context(whole_file(place / FILE_NAME)).write_text(_rig(declared), encoding="utf-8")
            yield tables
    except BaseException:
        for place in () if alike else places:
            with suppress(OSError):  # it was not made yet
                place.rmdir()
        raise


def check_units(recordings: list[Recording]) -> None:
    """Raise `HidingError` for sessions whose taxels are in volts: an effect is hidden in newtons."""
    raw = [r.name for r in recordings if "V" in r.taxel_units]
    if raw:
        raise HidingError(f"{raw[0]} has taxels in volts: declare their calibration in {FILE_NAME} first")


def _table(r: Recording, path: Path) -> None:
    columns = {"t_s": r.t - r.t[0]}
    if r.depth is not None:
        columns["x_mm"] = 1e3 * r.depth
    columns |= {f"{name}_n": y for name, y in r.channels.items()}
    np.savetxt(path, np.array(list(columns.values())).T, "%.9g", ",", header=",".join(columns), comments="", encoding="utf-8")


def _rig(declared: Declared) -> str:
    known = {f.name: getattr(declared, f.name) for f in fields(declared) if f.name not in ("warnings", "calibration")}
    plain = {name: _listed(value) for name, value in known.items() if value not in (None, (), {})}
    return yaml.safe_dump(plain, sort_keys=False) if plain else "{}\n"


def _listed(value):
    if isinstance(value, dict):
        return {key: _listed(v) for key, v in value.items()}
    return [_listed(v) for v in value] if isinstance(value, tuple) else value
