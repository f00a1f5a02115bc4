"""What profiles there are and what they take, as text for a terminal."""

from typing import Any

from skin_motion_profiles.battery_file import battery_names, read_battery
from skin_motion_profiles.catalogue import entries, entry_class
from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.fields import NUMERIC, declared


def overview() -> str:
    """One line per profile and per battery. A battery that cannot be read is listed with the reason."""
    kinds = [f"  {kind:22s} {_first_sentence(cls.__doc__)}" for kind, cls in entries().items()]
    batteries = [f"  {name:32s} {_about(name)}" for name in sorted(battery_names())]
    return "\n".join(["types of profile (execute --describe TYPE tells their parameters):", *kinds, "batteries:", *batteries])


def description(kind: str) -> str:
    """What one profile does, its parameters and an example. Raises `ProfileError` for a kind that does not exist."""
    cls = entry_class(kind)
    lines = [f"{kind}: {' '.join(cls.__doc__.split())}", ""]
    lines += [f"  {f.name:20s} {f.metadata['doc']} ({_default(f)}{_range(f)})" for f in declared(cls)]
    example = ", ".join(f"{key}: {value}" for key, value in cls.example.items())
    return "\n".join([*lines, "", f"  {{type: {kind}{', ' if example else ''}{example}}}"])


def _about(name: str) -> str:
    try:
        battery = read_battery(name)
    except ProfileError as error:
        return f"({error})"
    arguments = ", ".join(f"{key}={value}" for key, value in (battery.get("arguments") or {}).items())
    return " ".join(filter(None, [str(battery.get("about") or battery.get("name") or ""), f"[{arguments}]" if arguments else ""]))


def _default(f: Any) -> str:
    if f.name == "name" or f.default is None:
        return "optional"
    return "needed" if not isinstance(f.default, (int, float, str, tuple)) else f"default {_plain(f.default)}"


def _range(f: Any) -> str:
    if f.metadata["kind"] not in NUMERIC:
        return ""
    return f", {f.metadata['lower']:g} to {f.metadata['upper']:g}"


def _plain(value: Any) -> str:
    return repr(list(value)) if isinstance(value, tuple) else repr(value)


def _first_sentence(text: str) -> str:
    return " ".join(text.split()).split(". ")[0].rstrip(".")
