"""What the analysis of an array adds to findings.json."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from skin_ident.criticism.array.analysis import ArrayCriticism
from skin_ident.criticism.array.family import IN_ORDER, Family, is_repeat
from skin_ident.criticism.array.judgement import Judged
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.array.sentences import SCAN, farthest, separating, shift_of, why
from skin_ident.criticism.array.trying import Tried
from skin_ident.criticism.telling.entry import Entry, alternative
from skin_ident.criticism.vocabulary import BY_NAME, Key
from skin_ident.estimators.estimate import HALF_95

ALL = ("off_centre", "crosstalk", "spread_width", "spread_shape", "anisotropy")
CHANGED = "; a gain of {} that is not the same in all sessions would explain as much"
UNTOLD = "for these taxels and contacts, the ratios of the taxels look like those of a spread of a slightly different width"
SILENT = 0.01  # of the largest share, below which a taxel feels nothing
DECLARED = "how well calibrations (taxel_gain_uncertainty) and the width of the spread (spread_width_mm) are known"
BESIDE = "beside {} in the {}, the ratios of the taxels still differ from those of the declared layout, and no second cause is sure"
POSSIBLE = 0.5  # probability that something is wrong, up to which causes can be excluded


def entries_of(a: ArrayCriticism | str) -> list[dict[str, Any]]:
    """The entries of `findings` for the causes that are named."""
    return [] if isinstance(a, str) else [_entry(a, t) for t in a.named]


def _entry(a: ArrayCriticism, t: Tried) -> dict[str, Any]:
    """The entry for one cause. A gain error that leaves nothing of a reading is reported as a dead taxel."""
    best, gain, rivals = t.best, t.gain, t.judgement.rivals
    dead = [("dead_taxel", f"taxel_{i}") for i in silent(a)]
    cause, where = ("dead_taxel", best.key[1]) if best.key[0] == "gain_error" and ("dead_taxel", best.key[1]) in dead else best.key
    others = [(*r.key, float(2.0 * (best.log_odds - r.log_odds))) for r in rivals]
    others += [(*key, 2.0 * lower) for key, lower in t.instead.items()]
    partners = {other.best.key for other in a.named} - {best.key}
    changed = t.judgement.may_have_changed
    changed = None if ("gain_error", changed) in partners else changed
    if changed:
        others.append(("gain_error", changed, max(float(2.0 * (best.log_odds - t.judgement.changed[1])), 0.0)))
    apart: dict[Key, float] = {}
    for *key, lower in ((*best.key, 0.0), *others, *((*d, 0.0) for d in dead)):
        apart[tuple(key)] = min(lower, apart.get(tuple(key), np.inf))
    others = [(*key, lower) for key, lower in apart.items() if key != (cause, where)]
    evidence = {
        "why": why(best, a.layout) + (CHANGED.format(changed) if changed else ""),
        "log_odds": best.log_odds,
        "held_out_fall_of_mean_square": gain.relative,
        "held_out": gain.held_out,
        "calibrations_trusted_to": best.background.scatter,
        "forms": [form_of(best)],
    }
    return Entry(
        cause=cause,
        where=where,
        channels=gain.carried,
        parameters=parameters(best, a.layout),
        evidence=evidence,
        gain=gain.entry,
        alternatives=[alternative(*o) for o in others],
        separating=separating([cause, *(c for c, _, _ in others)]),
    ).as_json


def silent(a: ArrayCriticism) -> list[int]:
    """Taxels that feel nothing where the layout predicts a reading: the spread misses them, or they are dead."""
    felt, promised = np.abs(a.measured.value), Family(a.layout).shares({})
    return [i for i, said in enumerate(promised.T) if np.all(felt[:, i] < SILENT * felt.max()) and np.any(said > 5.0 * SILENT)]


def form_of(j: Judged) -> str:
    """Which form of its cause a hypothesis is, as a word."""
    name = next(iter(j.hypothesis.free))
    forms = {"leak": "neighbours", "power": "generalised_gaussian", "tail": "tails"} | {form: form for form in ("common", *IN_ORDER)}
    if "axis" in j.hypothesis.free:
        return "turned"
    return "one" if is_repeat(name) else forms.get(name, "static")


def parameters(j: Judged, layout: Layout) -> dict[str, dict[str, Any]]:
    """Parameters of a hypothesis with standard errors, SI."""
    p, std = j.fit.member, j.fit.std
    if j.hypothesis.cause == "off_centre":
        shift = shift_of(p, layout)
        errors = np.sqrt(sum((std[f"shift_{a}"] * axis) ** 2 for a, axis in enumerate(layout.axes)))
        turned = {"angle": _quantity(p["axis"], "rad", std["axis"])} if "axis" in j.hypothesis.free else {}
        return {name: _quantity(v, "m", s) for name, v, s in zip(("x", "y"), shift, errors, strict=True)} | turned
    if j.hypothesis.cause == "spread_width":
        width = layout.width * np.exp(p["width"])
        return {"width": _quantity(width, "m", width * std["width"])}
    if "tail" in j.hypothesis.free:
        return {"tail": _quantity(p["tail"], "1", std["tail"])}
    if j.hypothesis.cause == "spread_shape":
        return {"shape_power": _quantity(2.0 + p["power"], "1", std["power"])}
    if j.hypothesis.cause == "anisotropy":
        turned = {"turn": _quantity(p["turn"], "1", std["turn"])} if "turn" in p else {}
        return {"width_ratio": _quantity(np.exp(p["ratio"]), "1", np.exp(p["ratio"]) * std["ratio"]), **turned}
    (name,) = j.hypothesis.free
    return {name.partition("_")[0] if name.startswith("gain") else "share": _quantity(p[name], "1", std[name])}


def _quantity(value: float, unit: str, std: float) -> dict[str, Any]:
    return {"value": float(value), "unit": unit, "std": float(std)}


def excluded(a: ArrayCriticism) -> Iterator[dict[str, Any]]:
    """Upper bounds (95 %, from the likelihood without the prior) on causes that the ratios would have shown, where nothing seems wrong."""
    if a.judgement.sure > POSSIBLE:
        return
    for j in filter(_told, a.judgement.unaided):
        worst = max((abs(q["value"]) + HALF_95 * q["std"], q["unit"], name) for name, q in _departures(j, a.layout).items())
        said = {"cause": j.hypothesis.cause, "where": j.hypothesis.where, "parameter": worst[2], "below": float(worst[0]), "unit": worst[1]}
        said |= {"form": form_of(j)} if j.hypothesis.cause == "crosstalk" else {}  # each has a share of something else
        yield {**said, "limited_by": DECLARED, "needs": SCAN} if j.limited else said


def _told(j: Judged) -> bool:
    """Whether the ratios determine a cause better than its prior does."""
    return all(j.fit.std[name] < std for name, std in j.hypothesis.free.items())


def _departures(j: Judged, layout: Layout) -> dict[str, dict[str, Any]]:
    """The parameters as differences from their neutral values."""
    neutral = {"width": layout.width, "shape_power": 2.0, "width_ratio": 1.0}
    return {name: {**q, "value": q["value"] - neutral.get(name, 0.0)} for name, q in parameters(j, layout).items()}


def untestable(a: ArrayCriticism | str) -> Iterator[dict[str, Any]]:
    """The causes of an array that these data cannot judge, and why."""
    if isinstance(a, str):
        yield from ({"cause": c, "because": a, "needs": BY_NAME[c].needs} for c in ALL)
        return
    said = dict.fromkeys(j.hypothesis.cause for j in a.judgement.causes)  # the most probable first
    if "spread_width" not in said:
        yield {
            "cause": "spread_width",
            "because": "no width is declared (spread_width_mm) or given with a model, or the width changes with depth",
            "needs": "a declared width, the same at all depths",
        }
    if "anisotropy" not in said:
        yield {"cause": "anisotropy", "because": "taxels and contacts lie in one row", "needs": BY_NAME["anisotropy"].needs}
    if a.judgement.sure <= POSSIBLE:
        for j in a.judgement.unaided:
            if not _told(j):
                yield {"cause": j.hypothesis.cause, "where": j.hypothesis.where, "because": UNTOLD, "needs": SCAN}
    elif a.named:
        taken = "the ratios of the taxels already show another cause: beside {} they give no bound for this one"
        shown = " and ".join("{} in the {}".format(*t.best.key) for t in a.named)
        beside = {"because": taken.format(shown), "needs": f"the same sessions after that is corrected, or {SCAN}"}
        perhaps = list(_perhaps_beside(a))
        yield from perhaps
        open_ = [c for c in ALL if c in said and c not in {"crosstalk", *(u["cause"] for u in perhaps)}]  # the search bounds crosstalk
        yield from ({"cause": c, **beside} for c in open_)
    else:
        because = f"{_scatter(a)}, which wrong calibrations or positions would explain too"
        # Beside wrong calibrations a small leak may seem negative, and is then not among the causes that were compared.
        yield from ({"cause": c, "because": because, "needs": SCAN, "left_open": True} for c in dict.fromkeys([*said, "crosstalk"]))


def _perhaps_beside(a: ArrayCriticism) -> Iterator[dict[str, Any]]:
    """The causes that may be there beside the named one, where something probably is."""
    if a.left is None or a.left.sure <= POSSIBLE:
        return
    for j in (a.left.causes[0], *a.left.rivals):
        because = f"{BESIDE.format(*a.named[0].best.key)}: {why(j, a.layout)}"
        yield {"cause": j.hypothesis.cause, "where": j.hypothesis.where, "because": because, "needs": SCAN, "in_doubt": True}


def _scatter(a: ArrayCriticism) -> str:
    off = farthest(a.judgement.causes[0], a.layout)
    return f"the ratios of the taxels differ from those of the declared layout ({off})"
