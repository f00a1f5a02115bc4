"""How a profile declares its parameters: as fields of a frozen dataclass, each with its kind, range and meaning.

Names end in their unit (`amplitude_mm`, `frequency_hz`, `speed_mm_s`), because they are what a person types into a YAML file.
"""

import math
from dataclasses import MISSING, field, fields
from difflib import get_close_matches
from typing import Any

from skin_motion_profiles.errors import ProfileError

NUMERIC = ("number", "whole", "numbers")


def number(doc: str, default: Any = ..., *, lower: float = -math.inf, upper: float = math.inf) -> Any:
    """A number within [lower, upper]. With `...` as its default it must be given; `None` makes it optional."""
    return _declared("number", doc, default, lower, upper)


def whole(doc: str, default: Any = ..., *, lower: int = 0, upper: int = 2**31) -> Any:
    """A whole number."""
    return _declared("whole", doc, default, lower, upper)


def numbers(doc: str, default: Any = ..., *, lower: float = -math.inf, upper: float = math.inf) -> Any:
    """A list of at least one number; a single number counts as a list of one."""
    return _declared("numbers", doc, default, lower, upper)


def flag(doc: str, default: Any = ...) -> Any:
    """True or false."""
    return _declared("flag", doc, default, -math.inf, math.inf)


def text(doc: str, default: Any = ...) -> Any:
    """Words."""
    return _declared("text", doc, default, -math.inf, math.inf)


def another(doc: str, default: Any = ...) -> Any:
    """Another entry."""
    return _declared("entry", doc, default, -math.inf, math.inf)


def several(doc: str, default: Any = ...) -> Any:
    """A list of other entries."""
    return _declared("entries", doc, default, -math.inf, math.inf)


def names(doc: str, default: Any = None) -> Any:
    """Names and the numbers that they stand for."""
    return _declared("names", doc, default, -math.inf, math.inf)


def _declared(kind: str, doc: str, default: Any, lower: float, upper: float) -> Any:
    default = MISSING if default is ... else default
    return field(default=default, kw_only=True, metadata={"kind": kind, "doc": doc, "lower": lower, "upper": upper})


def declared(cls: type) -> tuple[Any, ...]:
    """The fields that a person may set."""
    return tuple(f for f in fields(cls) if "kind" in f.metadata)


def check_names(cls: type, label: str, given: Any) -> None:
    """Raise `ProfileError` for a key that the class does not know, or one that it needs and does not get."""
    known = {f.name: f for f in declared(cls)}
    for name in given:
        if name not in known:
            near = get_close_matches(str(name), known, n=1, cutoff=0.5)
            hint = f"did you mean {near[0]}?" if near else f"it takes {', '.join(known) or 'none'}"
            raise ProfileError(f"{label} has no parameter {str(name)!r}: {hint}")
    missing = [f for f in known.values() if f.default is MISSING and f.name not in given]
    if missing:
        raise ProfileError(f"{label} lacks " + ", ".join(f"{f.name} ({f.metadata['doc']})" for f in missing))


def check_values(thing: Any, label: str) -> None:
    """Bring every declared field to its kind and raise `ProfileError` where that fails or the range is left."""
    for f in declared(type(thing)):
        value = getattr(thing, f.name)
        if value is None and f.default is None:
            continue
        object.__setattr__(thing, f.name, _KINDS[f.metadata["kind"]](value, f, f"{label}: {f.name}"))


def _number(value: Any, f: Any, label: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ProfileError(f"{label} must be a number ({f.metadata['doc']}), not {value!r}")
    lower, upper = f.metadata["lower"], f.metadata["upper"]
    if not lower <= value <= upper:
        raise ProfileError(f"{label} = {value:g} must {_range(lower, upper)} ({f.metadata['doc']})")
    return float(value)


def _range(lower: float, upper: float) -> str:
    if math.isinf(upper):
        return f"be at least {lower:g}"
    return f"be at most {upper:g}" if math.isinf(lower) else f"lie between {lower:g} and {upper:g}"


def _whole(value: Any, f: Any, label: str) -> int:
    if isinstance(value, float) and not value.is_integer():
        raise ProfileError(f"{label} must be a whole number ({f.metadata['doc']}), not {value:g}")
    return int(_number(value, f, label))


def _numbers(value: Any, f: Any, label: str) -> tuple[float, ...]:
    values = value if isinstance(value, (list, tuple)) else [value]
    if not values:
        raise ProfileError(f"{label} must not be empty ({f.metadata['doc']})")
    return tuple(_number(v, f, label) for v in values)


def _flag(value: Any, f: Any, label: str) -> bool:
    if not isinstance(value, bool):
        raise ProfileError(f"{label} must be true or false ({f.metadata['doc']}), not {value!r}")
    return value


def _text(value: Any, f: Any, label: str) -> str:
    if not isinstance(value, str):
        raise ProfileError(f"{label} must be text ({f.metadata['doc']}), not {value!r}")
    return value


def _as_is(value: Any, f: Any, label: str) -> Any:
    return value


_KINDS = {
    "number": _number, "whole": _whole, "numbers": _numbers, "flag": _flag, "text": _text,
    "entry": _as_is, "entries": _as_is, "names": _as_is,
}  # fmt: skip
