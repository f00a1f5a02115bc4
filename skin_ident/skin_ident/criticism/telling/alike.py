"""One fault that all taxels have alike is one finding: what they share (a supply, a converter, an amplifier) has it, and no taxel."""

from typing import Any

import numpy as np

ALIKE = {"interference": "frequency", "quantization": "step"}  # the number that must be the same
NEARLY = 0.02  # relative


def in_all_taxels(entries: list[dict[str, Any]], taxels: int) -> list[dict[str, Any]]:
    """The entries of findings.json, those of a cause joined that every one of several `taxels` has to itself with the same number."""
    for cause, number in ALIKE.items():
        own = {e["where"]: e for e in entries if e["cause"] == cause and e["where"].startswith("taxel_") and number in e["parameters"]}
        values = np.array([e["parameters"][number]["value"] for e in own.values()])
        if taxels > 1 and len(own) == taxels and np.ptp(values) <= NEARLY * values.max():
            first, *others = own.values()
            entries = [_joined(list(own.values())) if e is first else e for e in entries if not any(e is o for o in others)]
    return entries


def _joined(own: list[dict[str, Any]]) -> dict[str, Any]:
    """One entry in the place of those of every taxel, with the gain of that which is mended most."""
    loudest = max(own, key=_mended)
    numbers = {
        name: {**q, "value": float(np.median([e["parameters"][name]["value"] for e in own]))} for name, q in own[0]["parameters"].items()
    }
    why = f"{loudest['evidence']['why']}; all taxels have it alike"
    each = {e["where"]: e["parameters"] for e in own}
    return {
        **loudest,
        "where": "taxel",
        "channels": [c for e in own for c in e["channels"]],
        "parameters": numbers,
        "evidence": {**loudest["evidence"], "why": why, "of_each_taxel": each},
    }


def _mended(e: dict[str, Any]) -> float:
    before, after = (e["gain"].get(f"held_out_rmse_{when}") for when in ("before", "after"))
    return 0.0 if before is None else before - after
