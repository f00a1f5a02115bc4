"""Entries of `untestable` for sensors that cannot be judged: a load cell whose force drives a test without depth, and a dead taxel."""

from collections.abc import Collection, Iterable
from typing import Any

from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.rivals import Rival
from skin_ident.criticism.telemetry.dead import apart
from skin_ident.criticism.vocabulary import CAUSES, FORCE_OFFSET, Key
from skin_models.catalogue import effects

KNOWN_LOAD = "the depth (encoder), or a known load on the load cell"
OF_LOAD_CELL = "the force drives the simulation: without a depth, the load cell cannot be distinguished from taxels and skin"
OF_DEAD = "the taxel is dead: other faults of it cannot be seen"
SEEN = ("outliers", "quantization")  # visible in the force itself, also where it drives the test
# Causes that a dead taxel does not hide: they show in its readings or in other taxels, or say that it is dead.
NOT_HIDDEN = ("interference", "outliers", "crosstalk", "dead_taxel")


def is_untold(entry: dict[str, Any]) -> bool:
    """Whether an entry of `untestable` is of this kind; it stays, even where its cause is named elsewhere."""
    return entry["because"] in (OF_LOAD_CELL, OF_DEAD)


def beside_silence(named: Iterable[Named], recordings: list) -> tuple[Named, ...]:
    """The causes that were named, where a zero of a taxel that does not follow the load may as well be the reading of an open channel."""
    silent = apart(recordings)
    open_too = [[Rival("dead_taxel", n.where, 0.0)] if n.where in silent and n.cause in (FORCE_OFFSET, "drift") else [] for n in named]
    return tuple(n.with_rivals(rivals) for n, rivals in zip(named, open_too, strict=True))


def with_load_cell_untold(untestable: list[dict[str, Any]], named: Collection[Key]) -> list[dict[str, Any]]:
    """The entries `untestable` followed by one for every cause that a load cell may have, in the order of the vocabulary. Left out are
    causes `named` there, or as a rival, and those that the force itself shows. An older entry of the same cause without a place is
    replaced."""
    untold = [cause for cause in _causes_of("load_cell") if cause not in SEEN and (cause, "load_cell") not in named]
    kept = [e for e in untestable if e["cause"] not in untold or e.get("where") not in (None, "load_cell")]
    return kept + [{"cause": name, "where": "load_cell", "because": OF_LOAD_CELL, "needs": KNOWN_LOAD} for name in untold]


def with_dead_untold(untestable: list[dict[str, Any]], dead: Iterable[str]) -> list[dict[str, Any]]:
    """The entries `untestable` with one for every cause that a taxel may have, for each taxel that is `dead`."""
    untold = [(cause, where) for where in dead for cause in _causes_of("taxel") if cause not in NOT_HIDDEN]
    kept = [e for e in untestable if (e["cause"], e.get("where")) not in untold]
    needs = "the taxel replaced, or its connector and wire repaired"
    return kept + [{"cause": cause, "where": where, "because": OF_DEAD, "needs": needs} for cause, where in untold]


def _causes_of(sensor: str) -> list[str]:
    """The causes of the catalogue that a sensor of this kind may have, in the order of the vocabulary."""
    able = {cls.cause for cls in effects() if sensor in cls.places}
    return [c.name for c in CAUSES if c.name in able]
