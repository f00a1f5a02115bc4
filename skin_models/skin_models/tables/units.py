"""Units in the headers of tables: `x_mm`, `force_N`, `taxel 0 (mN)`, `ai1_V`."""

import re
from dataclasses import dataclass

from skin_models.errors import TableError

TIME = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9, "min": 60.0}
LENGTH = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6}
FORCE = {"n": 1.0, "mn": 1e-3, "kn": 1e3, "gf": 9.80665e-3, "kgf": 9.80665, "lbf": 4.4482216152605}
WEIGHTS = {"g": "gf", "kg": "kgf", "lb": "lbf", "lbs": "lbf"}  # unit of mass: unit of its weight
VOLTAGE = {"v": 1.0, "mv": 1e-3}
UNITS = {"time": TIME, "depth": LENGTH, "force": {**FORCE, **VOLTAGE}, "taxel": {**FORCE, **VOLTAGE}}

_WORDS = {
    "time": ("t", "time", "stamp", "timestamp"),
    "depth": ("x", "depth", "position", "pos", "indentation", "displacement", "encoder", "z"),
    "force": ("force", "f", "fz", "load", "load_cell", "loadcell", "f_lc", "applied_force"),
}


@dataclass(frozen=True)
class Column:
    """One column: what it is (time, depth, force, taxel), what it is called, and the factor to SI (or volts)."""

    kind: str
    name: str
    unit: str  # s, m, N or V
    factor: float


def column(header: str) -> Column:
    """The column that a header declares. Raises `TableError` where the unit is missing or not one of that quantity."""
    name, unit = _split(_plain(header))
    kind = _kind(name)
    if unit in VOLTAGE and kind in ("force", "taxel"):
        return Column(kind, name, "V", VOLTAGE[unit])
    _refuse_mass(header, name, unit)
    if kind == "taxel" and not name.startswith("taxel") and unit not in FORCE:
        known = "t_s, x_mm, force_n, taxel_0_n, taxel_1_n; columns in volts (ai0_V) are taken as uncalibrated taxels"
        raise TableError(f"column {header.strip()!r} is not known; a header reads {known}")
    if unit not in UNITS[kind]:
        what = f"has no unit: write it into the header, as in {_numbered(name)}_{_example(kind)}" if not unit else f"is in {unit!r}"
        raise TableError(f"column {header.strip()!r} {what}; known for {kind} are {', '.join(UNITS[kind])}")
    return Column(kind, name, {"time": "s", "depth": "m"}.get(kind, "N"), UNITS[kind][unit])


def _refuse_mass(header: str, name: str, unit: str) -> None:
    """Raise `TableError` for a force in grams or another unit of mass: the weight of that mass has a unit of its own, such as gf."""
    name, mass = (name, unit) if unit else name.rpartition("_")[::2]
    if mass in WEIGHTS and (_kind(name) == "force" or name.startswith("taxel")):
        weight = WEIGHTS[mass]
        newtons = f"{name}_n (in N; 1 {weight} = {1e3 * FORCE[weight]:.6g} mN)"
        raise TableError(f"column {header.strip()!r} is in {mass}, a mass: write {name}_{weight} for what it weighs, or {newtons}")


def kind_of(header: str) -> str:
    """The quantity of a header (time, depth, force, taxel) by its name alone, whatever its unit; an unknown name is a taxel."""
    return _kind(_split(_plain(header))[0])


def _plain(header: str) -> str:
    return header.strip().strip('"').lower().replace("μ", "µ")


def _split(text: str) -> tuple[str, str]:
    """Name and unit; an empty unit where none is recognised."""
    bracket = re.fullmatch(r"(.*?)[\s_]*[(\[](.*)[)\]]", text)
    if bracket:
        return _clean(bracket[1]), bracket[2].strip()
    head, _, tail = text.replace(" ", "_").rpartition("_")
    known = {unit for units in UNITS.values() for unit in units}
    return (_clean(head), tail) if head and tail in known else (_clean(text), "")


def _clean(name: str) -> str:
    return re.sub(r"[^a-z0-9µ]+", "_", name).strip("_")


def _kind(name: str) -> str:
    return next((kind for kind, words in _WORDS.items() if name in words), "taxel")


def _numbered(name: str) -> str:
    """`taxel_1` of `taxel_1_psi`, whose end is no unit."""
    numbered = re.match(r"taxel_\d+(?=_)", name)
    return numbered[0] if numbered else name


def _example(kind: str) -> str:
    return {"time": "s", "depth": "mm"}.get(kind, "n")
