"""The spread that the notes of a model describe, so that one YAML file carries it to the simulated skin.

    notes:
      spread_width: {value: 0.00525, unit: m}           a Gaussian of this width, unless there is a table
      spread:                                           all optional
        table: {at: [0.0, 0.5, …], shares: [1.0, 0.9, …]}   distances in widths, and the shape there
        growth: {value: 100.0, unit: 1/m}               relative growth of the width per depth
        ratio: {value: 1.1, unit: 1}                    width along x over width along y

Effects of the spread (`skin_models.spread.bending`) bend what is written here.
"""

from collections.abc import Mapping
from typing import Any

from skin_models.errors import ModelError
from skin_models.spread.kernels import Anisotropic, DepthWidth, Gaussian, Kernel
from skin_models.spread.tabulated import Tabulated

THESIS_WIDTH = 5.25e-3  # m, c of 4 mm silicone (section 4.3.4), for models that do not say


def spread_width(notes: Mapping[str, Any]) -> float:
    """c of the spread (m) in the notes of a model: `spread_width: {value, unit: m}`, or the thesis's. Raises `ModelError` for nonsense."""
    width = _number(notes, "spread_width", "m", THESIS_WIDTH)
    if not 0.0 < width < 1.0:
        raise ModelError(f"notes.spread_width must be a positive length in m, not {width}")
    return width


def kernel_of(notes: Mapping[str, Any]) -> Kernel:
    """The kernel that the notes of a model describe. Raises `ModelError` for notes that cannot be understood."""
    spread = notes.get("spread", {})
    if not isinstance(spread, Mapping) or set(spread) - {"table", "growth", "ratio"}:
        raise ModelError("notes.spread may hold table, growth and ratio")
    kernel: Kernel = _shape(spread.get("table"), spread_width(notes))
    if "growth" in spread:
        kernel = DepthWidth(kernel, growth=_number(spread, "growth", "1/m"))
    return Anisotropic(kernel, ratio=_number(spread, "ratio", "1")) if "ratio" in spread else kernel


def _shape(table: Any, width: float) -> Kernel:
    if table is None:
        return Gaussian(width=width)
    if not isinstance(table, Mapping) or not all(isinstance(table.get(name), list) for name in ("at", "shares")):
        raise ModelError("notes.spread.table must hold the lists at and shares")
    try:
        return Tabulated(width=width, at=tuple(map(float, table["at"])), shares=tuple(map(float, table["shares"])))
    except (TypeError, ValueError) as error:
        raise ModelError("notes.spread.table must hold numbers") from error


def _number(notes: Mapping, name: str, unit: str, default: float | None = None) -> float:
    entry = notes.get(name, {"value": default, "unit": unit})
    value = entry.get("value") if isinstance(entry, Mapping) else None
    if isinstance(value, bool) or not isinstance(value, (int, float)) or str(entry.get("unit")) != unit:  # a bare 1 is read as a number
        raise ModelError(f"notes.{name} must be written as {{value: …, unit: {unit}}}")
    return float(value)
