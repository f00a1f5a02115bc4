"""The content of findings.json, schema 1, for static spread scans."""

from typing import Any

import numpy as np

from skin_ident.criticism.scan.candidates import Candidate, excited_beside
from skin_ident.criticism.scan.extended import surface_width
from skin_ident.criticism.scan.family import QUANTITIES
from skin_ident.criticism.scan.fault import Fault
from skin_ident.criticism.scan.faults import Looked
from skin_ident.criticism.scan.fitting import Fit, Member
from skin_ident.criticism.scan.gate import FEWEST_GROUPS, WHOLE, held_scans, left_out
from skin_ident.criticism.scan.leftover import Rest
from skin_ident.criticism.scan.limits import limits
from skin_ident.criticism.scan.search import Named, Search
from skin_ident.criticism.scan.sentences import separating, why
from skin_ident.criticism.scan.trials import Setting, without_candidate
from skin_ident.criticism.telling.entry import Entry, alternative, no_gain
from skin_ident.criticism.vocabulary import Key
from skin_ident.estimators.scale import rms
from skin_ident.spread_scan import SpreadScan

CHANNEL = "taxel_0"
ALSO = {"parameters": ("gain_error", "taxel")}  # rivals that no static scan can tell from the cause
UNSIMULATED = {
    "off_centre": "no: the model is written about the spread's own centre",
    "drift": "no: the simulated skin has no drift that depends on the order of the readings",
}
SAID = {"power": "shape_power", "tail": "tail_weight", "ceiling": "level", "disc": "disc_radius", "drift": "drift_over_the_scan"}


def as_findings(
    found: Search, looked: Looked, s: Setting, rest: Rest, scans: list[SpreadScan], held: set[str], verdict: str, given: str
) -> dict[str, Any]:
    """The whole of findings.json. `given` is the name of a given model, or empty."""
    baseline, extended = described(found.baseline, found, s, _name(given, s)), described(found.extended, found, s, _name(given, s, found))
    entries = [seen(f) for f in together(looked.faults)] + [entry(n, found, s) for n in found.named]
    named = {e["cause"] for e in entries} | {a["cause"] for e in entries for a in e["alternatives"]}
    x = excited_beside(s.cells, s.test.start)
    excluded, untestable = limits(found.extended.member, s.cells, found.noise.noise.whitener(), x, named, looked.known)
    return {
        "schema": 1,
        "recordings": recordings(scans, held),
        "baseline": baseline,
        "findings": entries,
        "excluded": excluded,
        "untestable": untestable,
        "extended": extended,
        "noise_floor": {CHANNEL: noise_floor(found, looked)},
        "systematic_rest": {"fall_of_mean_square": rest.depths[0], "lower_bound": rest.depths[1], "over_distances": list(rest.distances)},
        "verdict": verdict,
        "warnings": [*looked.warnings, *_doubts(found, scans, held)],
    }


def recordings(scans: list[SpreadScan], held: set[str]) -> list[dict[str, Any]]:
    """The entry of every scan."""
    return [
        {
            "name": s.name,
            "kind": "static spread scan",
            "depths": s.depth.size,
            "distances": s.distance.size,
            "samples": int(np.isfinite(s.force).sum()),
            "held_out": s.name in held,
            "warnings": list(s.declared.warnings),
        }
        for s in scans
    ]


def _name(given: str, s: Setting, found: Search | None = None) -> str:
    own = "" if "width" in s.test.start.free else " of the declared width"
    first = f"{given} with its spread" if given else f"linear skin with a Gaussian spread{own}"
    forms = [n.candidate.cause.replace("_", " ") for n in found.named] if found else []
    return " + ".join([first, *forms])


def described(f: Fit, found: Search, s: Setting, name: str) -> dict[str, Any]:
    """The entry `baseline` or `extended` of findings.json: name, parameters and RMSE of a model."""
    m = f.member
    e = s.cells.y - m.predict(s.cells)
    return {
        "model": name,
        "parameters": parameters(f),
        "rmse": {CHANNEL: {"train": rms(e), "held_out": held_out_rmse(m, found, s), "unit": "N"}},
    }


def held_out_rmse(m: Member, found: Search, s: Setting) -> float:
    """RMSE of the held-out scans, N; where there are none, of whole depths left out in turn (distances where depths are few)."""
    if s.test.held is not None:
        return rms(held_scans(m, s.test.held, WHOLE))
    group = s.cells.row if np.unique(s.cells.row).size >= FEWEST_GROUPS else s.cells.column
    return rms(left_out(m, s.cells, found.noise.noise, group, WHOLE, s.test))


def parameters(f: Fit) -> dict[str, dict[str, Any]]:
    """Values and standard errors of a fit, SI."""
    m = f.member
    width = {"width": _value(m.values["width"], "m", f.std("width") if "width" in m.free else None)}
    return sizes(f) | width | {key: value for name in m.free if name != "width" for key, value in _shown(f, name).items()}


def sizes(f: Fit) -> dict[str, dict[str, Any]]:
    """Stiffness k1 of every scan, or the factor on a given model's level."""
    m, per, found = f.member, f.member.scale.deepest, {}
    for i, k in enumerate(m.k):
        name = ("level_factor" if m.scale.law is not None else "k1") + (f"_{i + 1}" if m.k.size > 1 else "")
        std = f.k_std(i)
        found[name] = _value(k, "1", std) if m.scale.law is not None else _value(k / per, "N/m", None if std is None else std / per)
    return found


def _shown(f: Fit, name: str) -> dict[str, dict[str, Any]]:
    """One parameter under the name and in the form that findings.json uses."""
    v, std = f.member.values[name], f.std(name)
    if name == "shift":
        return {"offset": _value(-v, "m", std)}
    if name == "ratio":
        return {"width_ratio": _value(np.exp(v), "1", std * np.exp(v))}
    if name == "growth":
        width, growth = surface_width(f.member)
        return {"growth": _value(growth, "1/m", std), "width_at_surface": _value(width, "m", None)}
    return {SAID.get(name, name): _value(v, QUANTITIES[name].unit, std)}


def _value(value: float, unit: str, std: float | None) -> dict[str, Any]:
    return {"value": float(value), "unit": unit, "std": None if std is None else float(std)}


def entry(n: Named, found: Search, s: Setting) -> dict[str, Any]:
    """The entry of `findings` for a cause that is in the extended model."""
    c, f = n.candidate, found.extended
    before = without_candidate(c, f.member, s.test.start)
    shown = {key: value for name in c.names for key, value in _shown(f, name).items()} or sizes(f)
    alternatives = [_alternative(r, short) for r, short in n.rivals]
    alternatives += [_placed()] if n.or_placing and "off_centre" not in {a["cause"] for a in alternatives} else []
    alternatives += [alternative(*ALSO[c.cause])] if c.cause in ALSO else []
    words = why(c.cause, found.baseline.member if c.bends != "reading" else before, f.member, s.cells)
    evidence = {
        **({"why": words} if words else {}),
        "likelihood_gain": n.explained,
        "held_out_fall_of_mean_square": n.gain.relative,
        "held_out_fall_over_distances": n.gain.across,
        "held_out": n.gain.held_out,
        "forms": [c.form or c.cause],
        "simulated": UNSIMULATED.get(c.cause, "yes, in the written model"),
        "in_model": c.cause not in UNSIMULATED,
    }
    errors = {"held_out_rmse_before": n.gain.before, "held_out_rmse_after": n.gain.after, "ci95": list(n.gain.ci95)}
    return Entry(
        cause=c.cause,
        where=c.where,
        channels=[CHANNEL],
        parameters=shown,
        evidence=evidence,
        gain={**errors, "channel": CHANNEL, "unit": "N"},
        alternatives=alternatives,
        separating=separating([c.cause, *(a["cause"] for a in alternatives)], n.or_placing),
    ).as_json


def _alternative(c: Candidate, short: float) -> dict[str, Any]:
    more = {"remark": f"it explains {-short:.3g} more, but on one side of the taxel it looks like another shape"}
    return alternative(c.cause, c.where, max(short, 0.0)) | ({} if short > -1.0 else more)


def _placed() -> dict[str, Any]:
    """The alternative that placing errors, another one at every distance, explain the finding."""
    remark = "a plunger that stood a little beside each distance, differently each time, looks the same"
    return alternative("off_centre", "rig") | {"remark": remark}


def together(faults: tuple[Fault, ...]) -> list[Fault]:
    """One fault per cause and place; the sentences of several such faults are joined."""
    groups: dict[Key, list[Fault]] = {}
    for f in faults:
        groups.setdefault((f.cause, f.where), []).append(f)
    return [_merged(group) for group in groups.values()]


def _merged(group: list[Fault]) -> Fault:
    first = group[0]
    if len(group) == 1:
        return first
    alternatives = tuple(dict.fromkeys(a for f in group for a in f.alternatives))
    cells = tuple(cell for f in group for cell in f.cells)
    count = {"faults": {"value": float(len(group)), "unit": "1"}}
    return Fault(
        first.cause, first.where, "; ".join(f.why for f in group), np.any([f.bad for f in group], axis=0), count, alternatives, cells
    )


def seen(f: Fault) -> dict[str, Any]:
    """The entry of `findings` for a fault of the table. It is no term of the model, so there is no gain."""
    return Entry(
        cause=f.cause,
        where=f.where,
        channels=[CHANNEL],
        parameters=f.parameters,
        evidence={"why": f.why, **({"cells": list(f.cells)} if f.cells else {})},
        gain=no_gain(CHANNEL),
        alternatives=[alternative(*key) for key in f.alternatives],
        separating=separating([f.cause, *(c for c, _ in f.alternatives)]),
    ).as_json


def noise_floor(found: Search, looked: Looked) -> dict[str, Any]:
    """RMS of the noise, N, and the standard deviations of its parts."""
    n = found.noise.noise
    parts = {"independent": (n.sigma, "N"), "relative": (n.relative, "1"), "placing": (n.placing, "m"), "repeat": (n.repeat, "1")}
    steps = {"step": {"value": looked.step, "unit": "N"}} if looked.step else {}
    return {"rms": rms(n.total()), "unit": "N", **steps, **{k: {"value": float(v), "unit": u} for k, (v, u) in parts.items()}}


def _doubts(found: Search, scans: list[SpreadScan], held: set[str]) -> list[str]:
    """Warnings that limit how far the findings can be trusted."""
    n, said = found.noise.noise, []
    if n.placing > 0.0:
        beside = f"as if the plunger had stood about {1e3 * n.placing:.2f} mm beside them"
        said.append(f"at the same distances the residual has the same sign at all depths, {beside}")
    if n.repeat > 0.0:
        said.append(f"from row to row the force differs by about {n.repeat:.1%} more than it should, as if depths did not repeat")
    if len(scans) == 1 and not held:
        said.append("only one scan: its depths and distances were held out in turn, a weaker test than a second scan; record one")
    return said
