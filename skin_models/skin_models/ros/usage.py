"""What a node answers to `--help`: what it is, and its parameters with their defaults and ranges."""

import inspect
import textwrap
from dataclasses import fields

_WIDTH = 110
_INDENT = 6 * " "


def usage(name: str, doc: str | None, settings: type | None) -> str:
    """The whole text: `doc` of the node's module, and the parameters that the dataclass `settings` declares."""
    lines = [f"usage: {name} [--ros-args -p parameter:=value ...]", "", inspect.cleandoc(doc or "").strip()]
    declared = [f for f in fields(settings) if "doc" in f.metadata] if settings else []
    if declared:
        lines += ["", "parameters, with their defaults:"]
    for f in declared:
        lines += [
            f"  {f.name}:={_plain(f.default)}",
            textwrap.fill(_said(f.metadata), _WIDTH, initial_indent=_INDENT, subsequent_indent=_INDENT),
        ]
    return "\n".join(lines)


def _said(metadata: dict) -> str:
    """Meaning, range and choices of a parameter, and whether a running node can change it."""
    parts = [metadata["doc"]]
    if metadata["lower"] is not None:
        parts.append(f"from {metadata['lower']:g} to {metadata['upper']:g}")
    if metadata["choices"] and not all(choice in metadata["doc"] for choice in metadata["choices"]):
        parts.append(f"one of {', '.join(metadata['choices'])}")
    return "; ".join([*parts, *(["cannot be changed later"] if metadata["fixed"] else [])])


def _plain(value: object) -> str:
    """A default as it would be written on a command line."""
    if isinstance(value, bool):
        return str(value).lower()
    return f"[{', '.join(map(str, value))}]" if isinstance(value, tuple) else str(value) or "''"
