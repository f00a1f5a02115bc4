"""Reads JSON that someone else wrote, without errors where something is missing."""

import re
from typing import Any

from skin_ident.criticism.vocabulary import cause_at, spoken
from skin_ident.report.numbers import amount, plain


def mapping(thing: Any) -> dict[str, Any]:
    """`thing` where it is a mapping, else an empty one."""
    return thing if isinstance(thing, dict) else {}


def sequence(thing: Any) -> list[Any]:
    """`thing` as a list; a single value is a list of one."""
    return list(thing) if isinstance(thing, (list, tuple)) else [] if thing is None else [thing]


def text(thing: Any) -> str:
    """`thing` as a line of text: mappings become `key: value` pairs, numbers have three digits and quantities their unit."""
    if isinstance(thing, bool):
        return "yes" if thing else "no"
    if isinstance(thing, float):
        return plain(thing)
    if isinstance(thing, dict) and set(thing) == {"value", "unit"}:
        return amount(thing["value"], str(thing["unit"]))
    if isinstance(thing, dict):
        return "; ".join(f"{spoken(k)}: {text(v)}" for k, v in thing.items())
    if isinstance(thing, (list, tuple)):
        return ", ".join(text(v) for v in thing)
    return "" if thing is None else str(thing)


def with_spoken_taxels(said: str) -> str:
    """A sentence of findings.json with `taxel_0` written as `taxel 0`."""
    return re.sub(r"\btaxel_(\d+)\b", r"taxel \1", said)


def place_in(entry: dict) -> str:
    """The place of an entry of findings.json as the catalogue names it; a clock with its channel."""
    return "_".join(filter(None, (text(entry.get("where")), text(entry.get("channel_clock")))))


def named_at(entry: dict) -> str:
    """The cause and place of an entry of findings.json in words (see `cause_at`)."""
    return cause_at(text(entry.get("cause")), place_in(entry))
