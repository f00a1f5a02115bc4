"""The analysis of an array joined to the rest of the diagnosis."""

from collections.abc import Container
from dataclasses import replace
from functools import reduce
from typing import Any

from skin_ident.criticism.array.analysis import ArrayCriticism, analyse, doubted_taxels
from skin_ident.criticism.array.extending import unwritten
from skin_ident.criticism.array.findings import entries_of, excluded, untestable
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.array.sentences import changing
from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.telling.untold import is_untold
from skin_ident.criticism.vocabulary import MORE_THAN_APPLIED, Key, revised
from skin_models.model import Model

FEWEST_ALIVE = 3  # taxels that must be left beside dead ones: of two, nothing says which is off
APART = (
    "the gain from the ratios of the taxels is measured against the declared layout; baseline and extended model have a gain of their own "
    "for every taxel, so their errors do not show it"
)


def array_criticism(c: Any, layout: Layout | str, symptoms: tuple, recordings: list) -> ArrayCriticism | str:
    """Judge the ratios of the taxels under the extended model of the criticism `c`, or say why that is impossible.

    `layout` is that of all `recordings` in order; a lone session, of which blocks are held out, counts as two.
    """
    if isinstance(layout, str):
        return layout
    dead = sorted({int(channel.partition("_")[2]) for s in symptoms if s.cause == "dead_taxel" for channel in s.channels})
    spoilt = [s for s in symptoms if _spoils(s, len(layout.taxels) - len(dead))]
    if spoilt:
        return f"{spoilt[0].cause} in {', '.join(spoilt[0].channels)}: so the ratios of the taxels say nothing"
    model, thickness_mm = c.extended.model, recordings[0].declared.skin_thickness_mm
    sessions = [_but_for(dead, s, model) for s in (*c.train, *c.held)]
    if len(layout.contacts) != len(sessions):
        layout = layout.of([0] * len(sessions))
    indices = list(range(len(c.train), len(sessions)))
    return analyse(model, layout, sessions, indices, c.last.noise, doubted_taxels(c.named), thickness_mm, dead)


def _but_for(dead: list[int], s: Session, model: Model) -> Session:
    """The session with dead taxels as the model has them, which says nothing of their shares. If their samples were left out, those of all
    other channels at the same time would be left out, too."""
    if not dead:
        return s
    own = [s.channels.index(f"taxel_{i}") for i in dead]
    measured, weight = s.measured.copy(), s.weight.copy()
    measured[own], weight[own] = s.band.thin(simulated(model, s)[own]), 1.0
    return replace(s, measured=measured, weight=weight)


def _spoils(s: Any, alive: int) -> bool:
    """Whether no ratio can be judged beside a symptom: a dead taxel where too few are `alive`, or an error of the data, unless it concerns
    some samples alone, which are left out of everything."""
    if s.cause == "dead_taxel":
        return alive < FEWEST_ALIVE
    return s.cause == "data_error" and s.evidence.get("kind") != MORE_THAN_APPLIED and not s.bad


def joined(findings: dict[str, Any], a: ArrayCriticism | str, model: Model, seen: Container[Key] = ()) -> dict[str, Any]:
    """findings.json with the result of the array: one or two findings more, or bounds and reasons in place of those from the search, which
    knows no layout.

    `model` is the extended one; its effects of the array are put into words, with the reason where one cannot be written to file. `seen`
    are causes and places of which the search has found something that is no finding: for these no bound is given, since average ratios do
    not bound a form that comes and goes.
    """
    findings = {**findings, "findings": [_in_words(e, model) for e in findings["findings"]]}
    entries = reduce(_with, entries_of(a), findings["findings"])
    keys = {(e["cause"], e["where"]) for f in entries for e in (f, *f["alternatives"])}
    named = {cause for cause, _ in keys}
    reasons = [u for u in untestable(a) if u["cause"] not in named or (u.get("in_doubt") and _about(u) not in keys)]
    bounds = [] if isinstance(a, str) else [e for e in excluded(a) if e["cause"] not in named and (e["cause"], e["where"]) not in seen]
    open_to = {u["cause"] for u in reasons if not u.get("in_doubt")}  # the search has excluded only other forms of them
    doubted = {(u["cause"], place) for u in reasons if u.get("in_doubt") for place in (u["where"], "taxel")}
    able = [e for e in findings["excluded"] if e["cause"] not in named | open_to and (e["cause"], e.get("where")) not in doubted] + bounds
    decided = {u["cause"] for u in reasons} | {e["cause"] for e in able} | {(e["cause"], e["where"]) for e in bounds}
    mine = [u for u in findings["untestable"] if u["cause"] not in named or u.get("in_doubt") or is_untold(u)]
    kept = [u for u in mine if _about(u) not in set(map(_about, reasons)) and (_about(u) in seen or _about(u) not in decided)]
    verdict = revised(findings["verdict"], bool(entries), more=not isinstance(a, str) and a.unexplained)
    warnings = [*findings["warnings"], *([APART] if not isinstance(a, str) and a.named else [])]
    reasons = [u for u in reasons if u["cause"] not in {e["cause"] for e in bounds}]
    absent = unwritten(model, a)
    entries = [_marked(e, absent.get((e["cause"], e["where"]), "")) for e in entries]
    more = {"excluded": able, "untestable": kept + reasons, "verdict": verdict, "warnings": warnings}
    return {**findings, "findings": entries, **more}


def _about(reason: dict[str, Any]) -> str | Key:
    """What a reason applies to: a cause, or one at a place."""
    return (reason["cause"], reason["where"]) if "where" in reason else reason["cause"]


def _in_words(entry: dict[str, Any], model: Model) -> dict[str, Any]:
    """An entry of the search, with a sentence if it stands for effects of the array."""
    words = "; ".join(filter(None, map(changing, model.having((entry["cause"], entry["where"])))))
    return {**entry, "evidence": {"why": words, **entry["evidence"]}} if words else entry


def _marked(entry: dict[str, Any], why: str) -> dict[str, Any]:
    """The entry with the reason `why` the extended model lacks it; unchanged if `why` is empty."""
    return {**entry, "evidence": {**entry["evidence"], "simulated": why, "in_model": False}} if why else entry


def _with(entries: list[dict[str, Any]], new: dict[str, Any]) -> list[dict[str, Any]]:
    """The entries with `new` added, or merged into the one with the same cause and place."""
    same = [e for e in entries if (e["cause"], e["where"]) == (new["cause"], new["where"])]
    if not same:
        return [*entries, new]
    words = "; ".join(w for w in (same[0]["evidence"].get("why", ""), new["evidence"]["why"]) if w)
    taught = {
        **same[0],
        "parameters": {**same[0]["parameters"], **new["parameters"]},
        "evidence": {**same[0]["evidence"], "why": words, "forms": [*same[0]["evidence"].get("forms", []), *new["evidence"]["forms"]]},
    }
    return [taught if e is same[0] else e for e in entries]
