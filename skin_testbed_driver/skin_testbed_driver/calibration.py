"""Volts to newtons (thesis eqs 25 and 26), and the calibration file.

    F_load_cell = V x 25 lbf / 8 V x 4.44822 N / lbf          (25)
    F_taxel     = V x slope                                    (26)

The file gives every taxel's slope from the calibration before a session and, where there is one, from that after it; the two are
averaged, as in the thesis (section 5.1).

    load_cell_n_per_v: 13.9006875
    taxels:
      taxel_0: {before: {date: 2026-03-01, slope_n_per_v: 9.413}, after: {date: 2026-03-02, slope_n_per_v: 9.443}}
"""

import datetime
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from skin_models.errors import SkinError

LOAD_CELL_SLOPE = 25.0 / 8.0 * 4.44822  # N/V, eq. 25
LOAD_CELL_RANGE = 25.0 * 4.44822  # N, capacity of the MLP-25
THESIS_SLOPES = (9.40825, 13.75, 10.34375, 13.515)  # N/V, means of the four experiments of Table 3-1


class CalibrationError(SkinError):
    """A calibration file cannot be used."""


@dataclass(frozen=True)
class Calibration:
    """Slopes in N/V of the load cell and of every taxel, (T,); NaN for a taxel that nobody calibrated."""

    taxels: np.ndarray
    load_cell: float = LOAD_CELL_SLOPE
    source: str = "thesis, eq. 25 and means of Table 3-1"

    def force(self, voltage: float) -> float:
        """Eq. 25: N from V."""
        return voltage * self.load_cell

    def taxel_force(self, voltage: np.ndarray) -> np.ndarray:
        """Eq. 26: N from V, both (T,)."""
        return voltage * self.taxels

    def as_dict(self, names: Sequence[str]) -> dict[str, Any]:
        """What a recording keeps: the slopes in use, N/V, by taxel; `source` says where they come from."""
        taxels = {name: None if math.isnan(slope) else slope for name, slope in zip(names, self.taxels.tolist(), strict=True)}
        return {"load_cell_n_per_v": self.load_cell, "taxels_n_per_v": taxels, "source": self.source}


def thesis_calibration(count: int) -> Calibration:
    """The slopes of the thesis's four taxels, repeated for `count` taxels."""
    return Calibration(np.resize(THESIS_SLOPES, count))


def load_calibration(path: str | os.PathLike, names: Sequence[str]) -> Calibration:
    """Read a calibration file for the taxels `names`; one that the file does not name is NaN. Raises `CalibrationError`."""
    try:
        content = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())
        raise CalibrationError(f"cannot read the calibration {path}: {reason}") from error
    try:
        return _calibration(content, names, str(path))
    except CalibrationError as error:
        raise CalibrationError(f"{path}: {error}") from error


def _calibration(content: Any, names: Sequence[str], source: str) -> Calibration:
    if not isinstance(content, Mapping) or not isinstance(content.get("taxels"), Mapping):
        raise CalibrationError("a calibration is a mapping with the entry 'taxels'")
    unknown = sorted(set(map(str, content["taxels"])) - set(names))
    if unknown:
        raise CalibrationError(f"{unknown[0]!r} is no taxel of this rig, which has {', '.join(names)}")
    load_cell = _slope(content.get("load_cell_n_per_v", LOAD_CELL_SLOPE), "load_cell_n_per_v")
    slopes = [_taxel(content["taxels"][name], name) if name in content["taxels"] else math.nan for name in names]
    return Calibration(np.array(slopes), load_cell, source)


def _taxel(entry: Any, name: str) -> float:
    if not isinstance(entry, Mapping) or "before" not in entry or set(entry) - {"before", "after"}:
        raise CalibrationError(f"{name} needs the entry 'before', and 'after' if there is one, each with date and slope_n_per_v")
    return float(np.mean([_run(run, f"{name}.{key}") for key, run in entry.items() if run is not None]))


def _run(entry: Any, label: str) -> float:
    if not isinstance(entry, Mapping) or set(entry) != {"date", "slope_n_per_v"}:
        raise CalibrationError(f"{label} must be written as {{date: YYYY-MM-DD, slope_n_per_v: …}}")
    if not isinstance(entry["date"], datetime.date):
        raise CalibrationError(f"{label}.date must be a date like 2026-03-01, not {entry['date']!r}")
    return _slope(entry["slope_n_per_v"], f"{label}.slope_n_per_v")


def _slope(value: Any, label: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not (math.isfinite(value) and value > 0.0):
        raise CalibrationError(f"{label} must be a positive number in N/V, not {value!r}")
    return float(value)
