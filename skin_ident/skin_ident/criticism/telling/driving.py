"""What nobody can say of a load cell whose force drives a test without depth."""

from collections.abc import Collection
from typing import Any

from skin_ident.criticism.vocabulary import CAUSES, Key
from skin_models.catalogue import effects

NEEDS = "an encoder, or a known load on the load cell"
UNTOLD = "the force drives the simulation: without a depth a load cell is not told from taxels and skin"
SEEN = ("outliers", "quantization")  # in the force itself, whatever it drives


def is_untold(entry: dict[str, Any]) -> bool:
    """Whether an entry of `untestable` says that of a load cell: it stays said where its cause is named elsewhere."""
    return entry["because"] == UNTOLD


def with_load_cell_untold(untestable: list[dict[str, Any]], named: Collection[Key]) -> list[dict[str, Any]]:
    """The entries `untestable` with one for every cause that a load cell may have, in the order of the vocabulary behind all others: none
    for what is `named` as its own, or as a rival, nor for what its record alone shows. One that speaks of no place gives way to it."""
    of_load_cell = {cls.cause for cls in effects() if "load_cell" in cls.places} - set(SEEN)
    untold = [c.name for c in CAUSES if c.name in of_load_cell and (c.name, "load_cell") not in named]
    kept = [e for e in untestable if e["cause"] not in untold or e.get("where") not in (None, "load_cell")]
    return kept + [{"cause": name, "where": "load_cell", "because": UNTOLD, "needs": NEEDS} for name in untold]
