"""Entries of findings.json that belong to one finding are joined here.

A fault that all taxels have alike is one finding: it sits in what they share (a supply, a converter, an amplifier). Two columns that are
exchanged in several sessions are one finding. So are a wrong unit of one session and the change of its converter's step that follows from
it.
"""

from typing import Any

import numpy as np

from skin_ident.criticism.pattern import in_sessions, listed
from skin_ident.criticism.vocabulary import EXCHANGED, UNIT_CHANGE, UNIT_FACTOR

NEARLY = 0.02  # relative difference within which two numbers agree
# The parameter that must agree over all taxels, by cause, and within what: what makes taxels loud need not make all quite as loud.
ALIKE = {"interference": ("frequency", NEARLY), "quantization": ("step", NEARLY), "noise": ("times_expected", 0.3)}


def one_each(entries: list[dict[str, Any]], sessions: list[str]) -> list[dict[str, Any]]:
    """The entries of faults seen in `sessions`, each fault once, with the sessions that have it."""
    entries = [e for i, e in enumerate(entries) if not any(_same_unit(e, other) for other in entries[:i])]
    exchanged: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    for e in entries:
        if e["evidence"].get("kind") == EXCHANGED and e["evidence"].get("pieces"):
            exchanged.setdefault(tuple(e["channels"]), []).append(e)
    for own in exchanged.values():
        entries = [_in_turn(own) if e is own[0] else e for e in entries if not any(e is o for o in own[1:])]
    return [{**e, "evidence": {**e["evidence"], **in_sessions(_sessions_of(e), sessions)}} for e in entries]


def _same_unit(e: dict[str, Any], other: dict[str, Any]) -> bool:
    """Whether `e` is a change of unit that follows from the wrong unit reported in `other` for the same channel and session: once the unit
    was put right, the converter's steps there are further apart by the inverse factor."""
    kinds = [x["evidence"].get("kind") for x in (other, e)]
    first, second = ((x["channels"], x["evidence"].get("session")) for x in (other, e))
    if kinds != [UNIT_FACTOR, UNIT_CHANGE] or first != second:
        return False
    return abs(np.prod([x["parameters"]["factor"]["value"] for x in (other, e)]) - 1.0) < NEARLY


def _in_turn(own: list[dict[str, Any]]) -> dict[str, Any]:
    """One entry in place of several for the same two columns, exchanged in different sessions."""
    pieces = [p for e in own for p in e["evidence"]["pieces"]]
    where = listed([f"in {p['session']} from {p['start']:.1f} s on for {p['seconds']:.3g} s" for p in pieces])
    stays = "each follows there what the model says of the other, and every other channel agrees with the model"
    why = f"{listed(own[0]['channels'])} are exchanged {where}: {stays}"
    lasts = {"lasts": {"value": sum(p["seconds"] for p in pieces), "unit": "s"}}
    return {**own[0], "parameters": lasts, "evidence": {**own[0]["evidence"], "why": why, "pieces": pieces}}


def _sessions_of(e: dict[str, Any]) -> set[str]:
    """The sessions that an entry of a `data_error` names, if any."""
    pieces = e["evidence"].get("pieces")
    named = [p["session"] for p in pieces] if isinstance(pieces, list) else [e["evidence"].get("session")]
    return {n for n in named if n} if e["cause"] == "data_error" else set()


def in_all_taxels(entries: list[dict[str, Any]], taxels: int) -> list[dict[str, Any]]:
    """The entries of findings.json, where a cause that each of several `taxels` has with about the same number is joined into one entry."""
    for cause, (number, within) in ALIKE.items():
        own = {e["where"]: e for e in entries if e["cause"] == cause and e["where"].startswith("taxel_") and number in e["parameters"]}
        values = np.array([e["parameters"][number]["value"] for e in own.values()])
        if taxels > 1 and len(own) == taxels and np.ptp(values) <= within * values.max():
            first, *others = own.values()
            entries = [_joined(list(own.values())) if e is first else e for e in entries if not any(e is o for o in others)]
    return entries


def _joined(own: list[dict[str, Any]]) -> dict[str, Any]:
    """One entry in place of those of every taxel: median parameters, and the gain of the taxel that improved most."""
    loudest = max(own, key=_mended)
    said_of_all = [name for name in own[0]["parameters"] if all(name in e["parameters"] for e in own)]
    numbers = {
        name: {**own[0]["parameters"][name], "value": float(np.median([e["parameters"][name]["value"] for e in own]))}
        for name in said_of_all
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
