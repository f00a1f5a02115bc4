"""The text of message definitions with all that they use, as MCAP's `ros2msg` wants it, from the installed .msg files."""

import re
from functools import cache
from pathlib import Path

from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

from skin_models.errors import SkinError

_SEPARATOR = "=" * 80
_NUMBERS = ("float32", "float64", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64")
_PRIMITIVE = frozenset(("bool", "byte", "char", "string", "wstring", *_NUMBERS))
# A field or constant: its type, with bounds of strings and arrays cut off.
_FIELD = re.compile(r"^\s*(?P<type>[A-Za-z][\w/]*)(?:<=\d+)?(?:\[[^\]]*\])?\s+\w+")


class DefinitionError(SkinError):
    """The definition of a message is not installed."""


@cache
def definition(type_name: str) -> str:
    """The definition of `package/msg/Name`, followed by those of every type it uses. Raises `DefinitionError`."""
    found: dict[str, str] = {}
    _collect(type_name, found)
    root, *used = found.items()
    return "\n".join([root[1], *(f"{_SEPARATOR}\nMSG: {_short(name)}\n{text}" for name, text in used)])


def _collect(type_name: str, found: dict[str, str]) -> None:
    if type_name in found:
        return
    text = _text(type_name)
    found[type_name] = text
    for used in _used_types(text, type_name.split("/")[0]):
        _collect(used, found)


def _text(type_name: str) -> str:
    package, *_, name = type_name.split("/")
    try:
        return (Path(get_package_share_directory(package)) / "msg" / f"{name}.msg").read_text(encoding="utf-8")
    except (PackageNotFoundError, OSError) as error:
        raise DefinitionError(f"no definition of {type_name} is installed: source the workspace that has it") from error


def _used_types(text: str, package: str) -> list[str]:
    matches = (_FIELD.match(line.split("#", 1)[0]) for line in text.splitlines())
    names = (match["type"] for match in matches if match and match["type"] not in _PRIMITIVE)
    return [_full(name, package) for name in names]


def _full(name: str, package: str) -> str:
    parts = name.split("/")
    return f"{parts[0] if len(parts) > 1 else package}/msg/{parts[-1]}"


def _short(type_name: str) -> str:
    package, _, name = type_name.split("/")
    return f"{package}/{name}"
