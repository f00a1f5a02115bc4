"""Physical parameters: a name, a unit, a value, bounds.

An effect or a model part is a frozen dataclass whose float fields are declared with `quantity`; `parameters_of` reads them back as
`Parameter` objects, so that a YAML file, a fit and a report all speak of the same thing.
"""

import math
from dataclasses import MISSING, Field, dataclass, field, fields
from functools import cache
from numbers import Real
from typing import Any

from skin_models.errors import ModelError

AMPLITUDE = "amplitude"
SHAPE = "shape"
PROMPT = 3.2e-4  # s, by which good hardware may be late: an amplifier with a filter of 500 Hz, or converters read one after the other


@dataclass(frozen=True)
class Parameter:
    """One physical parameter. `role` is AMPLITUDE (zero removes the effect) or SHAPE (meaningless without an amplitude); at its `neutral`
    value it changes nothing."""

    name: str
    unit: str
    value: float
    lower: float = -math.inf
    upper: float = math.inf
    role: str = AMPLITUDE
    typical: float = math.nan
    negligible: float = 0.0
    doc: str = ""
    neutral: float = 0.0


def quantity(
    unit: str,
    default: Any = MISSING,
    *,
    lower: float = -math.inf,
    upper: float = math.inf,
    role: str = AMPLITUDE,
    typical: float | None = None,
    negligible: float = 0.0,
    scan: tuple[float, ...] = (),
    doc: str = "",
    neutral: float = 0.0,
) -> Any:
    """Declare a parameter as a field of a frozen dataclass.

    `typical`     a sensible size (the prior's median), used to draw examples and to start fits
    `negligible`  an amplitude up to this is normal for good hardware, and is not named as a cause
    `scan`        of a SHAPE parameter: the grid on which it is profiled when a cause is proposed; of an amplitude: the sizes at which it is
                  tried, where a large one acts differently from many small ones
    `neutral`     the value that changes nothing, which is 1 for a ratio
    """
    metadata = dict(unit=unit, lower=lower, upper=upper, role=role, typical=typical, negligible=negligible, scan=scan, doc=doc)
    metadata["neutral"] = neutral
    return field(default=default, metadata=metadata, kw_only=True)


def parameters_of(thing: Any) -> tuple[Parameter, ...]:
    """The parameters that a frozen dataclass, or an instance of it, declares with `quantity`."""
    return tuple(_parameter(f, thing) for f in _declared(thing if isinstance(thing, type) else type(thing)))


@cache
def _declared(cls: type) -> tuple[Field, ...]:
    return tuple(f for f in fields(cls) if "unit" in f.metadata)


def _parameter(f: Any, thing: Any) -> Parameter:
    value = f.default if isinstance(thing, type) else getattr(thing, f.name)
    typical = f.metadata["typical"]
    return Parameter(
        name=f.name,
        unit=f.metadata["unit"],
        value=math.nan if value is MISSING else value,
        lower=f.metadata["lower"],
        upper=f.metadata["upper"],
        role=f.metadata["role"],
        typical=math.nan if typical is None else typical,
        negligible=f.metadata["negligible"],
        doc=f.metadata["doc"],
        neutral=f.metadata["neutral"],
    )


def scan_of(cls: type, name: str) -> tuple[float, ...]:
    """The grid on which the parameter `name` of a dataclass is profiled; empty where none is declared."""
    return next(f.metadata.get("scan", ()) for f in fields(cls) if f.name == name)


def clipped(cls: type, **values: float) -> dict[str, float]:
    """`values` by name, each moved to the nearest that the dataclass `cls` accepts: what was fitted or converted may lie beyond."""
    known = {p.name: p for p in parameters_of(cls)}
    return {name: min(max(float(v), known[name].lower), known[name].upper) for name, v in values.items()}


def check_parameters(thing: Any) -> None:
    """Raise `ModelError` unless every parameter of `thing` is a number within its bounds. Call it from `__post_init__`.

    Infinity is no number, except where it is the default.
    """
    for f in _declared(type(thing)):
        value, (lower, upper) = getattr(thing, f.name), (f.metadata["lower"], f.metadata["upper"])
        if not (isinstance(value, float) and lower <= value <= upper and math.isfinite(value)):
            _check(_parameter(f, thing), thing)


def _check(p: Parameter, thing: Any) -> None:
    unit = "" if p.unit == "1" else f" {p.unit}"
    if isinstance(p.value, bool) or not isinstance(p.value, Real) or math.isnan(p.value):
        raise ModelError(f"{_label(thing)}: {p.name} must be a number{unit and ' in' + unit}, not {p.value!r}")
    if not p.lower <= p.value <= p.upper:
        raise ModelError(f"{_label(thing)}: {p.name} = {p.value:g}{unit} is outside [{p.lower:g}, {p.upper:g}]{unit}")
    if math.isinf(p.value) and p.value != getattr(type(thing), p.name, None):
        raise ModelError(f"{_label(thing)}: {p.name} must be finite")


def _label(thing: Any) -> str:
    return getattr(thing, "cause", type(thing).__name__.lower())
