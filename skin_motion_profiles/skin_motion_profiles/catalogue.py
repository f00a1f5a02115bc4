"""All profiles, found by looking into `skin_motion_profiles.profiles`: a new one is one new file there and nothing else.

    entry_from_dict({"type": "sine", "amplitude_mm": 0.3, "frequency_hz": 0.5})
    entry_from_dict({"battery": "full", "depth_mm": 0.8, "seed": 3})           a battery file with its arguments
"""

import importlib
import inspect
import math
import pkgutil
from collections.abc import Mapping
from difflib import get_close_matches
from functools import cache
from typing import Any

import skin_motion_profiles.profiles
from skin_motion_profiles.battery_file import read_battery, with_arguments
from skin_motion_profiles.entry import Entry
from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.expressions import evaluate
from skin_motion_profiles.fields import NUMERIC, check_names, declared

_DEEPEST = 8  # batteries within batteries
_EXAMPLE = "{type: sine, amplitude_mm: 0.3, frequency_hz: 0.5} or {battery: full, depth_mm: 0.8}"


@cache
def entries() -> Mapping[str, type[Entry]]:
    """Every class that YAML can name, by its kind, in the order of the files."""
    package = skin_motion_profiles.profiles
    modules = [importlib.import_module(f"{package.__name__}.{m.name}") for m in pkgutil.iter_modules(package.__path__)]
    return {c.kind: c for module in modules for c in vars(module).values() if _is_entry_of(c, module)}


def _is_entry_of(c: object, module: object) -> bool:
    return inspect.isclass(c) and issubclass(c, Entry) and not inspect.isabstract(c) and c.__module__ == module.__name__


def entry_from_dict(content: Any, arguments: Mapping[str, float] | None = None, nesting: int = 0) -> Entry:
    """The entry that a mapping describes. `arguments` are the names that its expressions may use, `nesting` counts batteries around it.

    Raises `ProfileError`, one sentence, for an unknown type, an unknown or missing parameter, or a value out of range.
    """
    if not isinstance(content, Mapping):
        raise ProfileError(f"a profile must be a mapping such as {_EXAMPLE}, not {content!r}")
    given = _opened(dict(content), arguments or {}) if "battery" in content else dict(content)
    cls = entry_class(given.pop("type", None))
    check_names(cls, cls.kind, given)
    return cls(**{key: _value(cls, key, value, _inner(given, arguments), nesting) for key, value in given.items()})


def _opened(given: dict[str, Any], arguments: Mapping[str, float]) -> dict[str, Any]:
    """The content of the battery file that `given` names, with its arguments."""
    file = given.pop("battery")
    values = {key: evaluate(value, arguments, f"battery {file}: {key}") for key, value in given.items()}
    return with_arguments(read_battery(file), values)


def _inner(given: Mapping[str, Any], outer: Mapping[str, float] | None) -> Mapping[str, float]:
    """The names that expressions inside an entry may use: its own arguments, or those around it."""
    own = given.get("arguments")
    if own is None:
        return outer or {}
    if not isinstance(own, Mapping):
        raise ProfileError("arguments must be a mapping of names to numbers")
    values = {str(key): evaluate(value, outer or {}, f"argument {key}") for key, value in own.items()}
    for key, value in values.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise ProfileError(f"argument {key} must be a number, not {value!r}")
    return values


def _value(cls: type[Entry], key: str, value: Any, arguments: Mapping[str, float], nesting: int) -> Any:
    kind = next(f.metadata["kind"] for f in declared(cls) if f.name == key)
    if kind in NUMERIC:
        return evaluate(value, arguments, f"{cls.kind}: {key}")
    if kind == "entry":
        return entry_from_dict(value, arguments, nesting)
    if kind == "entries":
        return _children(cls, value, arguments, nesting + 1)
    return value


def _children(cls: type[Entry], contents: Any, arguments: Mapping[str, float], nesting: int) -> tuple[Entry, ...]:
    if not isinstance(contents, (list, tuple)):
        raise ProfileError(f"{cls.kind}: profiles must be a list of mappings")
    if nesting > _DEEPEST:
        raise ProfileError(f"batteries are nested more than {_DEEPEST} deep: does one contain itself?")
    return tuple(_child(i, content, arguments, nesting) for i, content in enumerate(contents, 1))


def _child(i: int, content: Any, arguments: Mapping[str, float], nesting: int) -> Entry:
    try:
        return entry_from_dict(content, arguments, nesting)
    except ProfileError as error:
        raise ProfileError(f"entry {i}: {error}") from error


def entry_class(kind: Any) -> type[Entry]:
    """The class of a kind. Raises `ProfileError` listing what exists."""
    if kind is None:
        raise ProfileError(f"a profile needs a type, one of {', '.join(entries())}")
    if not isinstance(kind, str) or kind not in entries():
        near = get_close_matches(str(kind), entries(), n=1)
        hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(entries())}"
        raise ProfileError(f"no profile has the type {kind!r}: {hint}")
    return entries()[kind]
