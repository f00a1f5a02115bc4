"""What the judgement adds to findings.json: gains of faults of the record, gains by channel with the noise floor as their bound, the
parameters in which causes had been hiding, and how much of the record was compared.
"""

from typing import Any

import numpy as np

from skin_ident.criticism.baseline.residual import stiffness
from skin_ident.criticism.baseline.unknowns import unknowns, values
from skin_ident.criticism.search.bounds import raised
from skin_ident.criticism.search.named import Criticism, Named
from skin_ident.criticism.sessions.session import FITTED, KEPT
from skin_ident.criticism.telemetry.faults import PREDICTS, UNLIKE, effect_of
from skin_ident.criticism.telemetry.symptom import Symptom
from skin_ident.criticism.telling.alike import one_each
from skin_ident.criticism.telling.floor import beyond_noise, floor_of_all, left_beside, noise_floor
from skin_ident.criticism.telling.judging import Judged
from skin_ident.criticism.vocabulary import BY_NAME, revised
from skin_models.model import Model

OTHER_UNIT = 3.0  # ratio of a taxel to the applied force that no mere gain error reaches
UNSURE = 1.5  # ratio of the residual to that without what training leaves uncertain, above which a warning is given
MOVED_SHARE, MOVED_ERRORS = 0.05, 3.0  # relative change, and change in standard errors, above which a parameter is reported to have moved


def tell(findings: dict[str, Any], judged: Judged, symptoms: tuple[Symptom, ...], encoder_step: float = 0.0) -> dict[str, Any]:
    """The content of findings.json with all that added. `findings["findings"]` begins with the `symptoms`, followed by the named causes.
    `encoder_step` is the step of the depth, m. Where clearly more than noise is left, the verdict says so."""
    c = judged.criticism
    left = {channel: gain["held_out_rmse_after"] for channel, gain in judged.channels.items()}
    floor = floor_of_all(c, noise_floor(c.last, list(c.train)), left)
    certain = left_beside(c, floor, left)
    above = beyond_noise(c, floor, certain, symptoms, encoder_step)
    entries, given = findings["findings"], bool(findings["baseline"].get("given"))
    seen, named = entries[: len(symptoms)], entries[len(symptoms) :]
    seen = [_seen(e, s, gain, judged, given) for e, s, gain in zip(seen, symptoms, judged.symptoms, strict=True)]
    named = [_named(e, n, judged, given) for e, n in zip(named, c.named, strict=True)]
    entries = _once_each(one_each(seen, [r["name"] for r in findings["recordings"]]), named)
    bounds = {channel: {**gain, "noise_floor": floor[channel]["rms"]} for channel, gain in judged.channels.items()}
    recordings = [{**r, **_compared(r["name"], c)} for r in findings["recordings"]]
    warnings = [*findings["warnings"], *_more_than_applied(c), *_more_than_noise(above), *_never_loaded(certain, left)]
    excluded = [_as_read(e, encoder_step, c.extended.model) for e in findings["excluded"]]
    told = {"findings": entries, "recordings": recordings, "excluded": excluded, "warnings": warnings}
    told |= {"noise_floor": floor, "gain_by_channel": bounds}
    return {**findings, **told, "verdict": revised(findings["verdict"], bool(entries), more=bool(above))}


def _seen(entry: dict[str, Any], symptom: Symptom, gain: dict[str, Any], judged: Judged, given: bool) -> dict[str, Any]:
    """The entry of a symptom with the gain of its effect, whether the extended model contains it, and the parameters in which it had been
    hiding; those of a `given` model are not fitted and hide nothing."""
    advice = entry["advice"]
    if symptom.evidence.get(UNLIKE):
        instead = BY_NAME[symptom.cause].instead or advice
        advice = f"{instead}; the extended model does not do this, so do not rely on it near contact"
    c, evidence = judged.criticism, {**entry["evidence"], **_simulated(symptom, bool(gain))}
    hid = {"hid_in": moved(judged.clean, c.baseline.model, c)} if gain and not given else {}
    return {**entry, "gain": {**entry["gain"], **gain}, "evidence": evidence, "advice": advice, **hid}


def _named(entry: dict[str, Any], named: Named, judged: Judged, given: bool) -> dict[str, Any]:
    """The entry of a cause with its final gain, and the parameters in which it had been hiding, unless the model was `given`."""
    hid = {} if given else hid_in(named, judged.criticism)
    return {**entry, "gain": gain_at_the_end(named, judged) or entry["gain"], "hid_in": hid}


def _once_each(seen: list[dict[str, Any]], named: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Entries of faults `seen` in the record and of causes `named` by the search, joined where cause and place agree: the evidence of the
    fault with the parameters of the model. A cause that was named twice, as for two clocks, stays two entries."""
    joined, left = [], named
    for e in seen:
        again = next((n for n in left if (n["cause"], n["where"]) == (e["cause"], e["where"])), None)
        left = [n for n in left if n is not again]
        joined.append(e if again is None else {**again, "evidence": {**e["evidence"], **again["evidence"]}})
    return joined + left


def gain_at_the_end(named: Named, judged: Judged) -> dict[str, Any]:
    """The gain in the finished model, for a cause that is all the extended model adds, so that one gain has one number. {} where more was
    added, or where the final test used other data: then only the gain at the time of naming is the cause's own."""
    at_the_end = judged.channels[named.gain.channel]
    alone = len(judged.criticism.named) == 1 and not any(judged.symptoms)
    same_test = at_the_end["tested_on"] == named.gain.held_out
    return {k: v for k, v in at_the_end.items() if k != "tested_on"} if alone and same_test else {}


def _more_than_applied(c: Criticism) -> list[str]:
    """A warning where a taxel reads more than what presses on it: force and taxel then differ in unit, so ratios hold but shares do not."""
    share = c.baseline.model.dispersion.sensed_share
    if share <= (OTHER_UNIT if c.train[0].drive is None else 1.0):
        return []
    return [
        f"the strongest taxel reads {share:.3g} times the force that is applied: one of the two is in another unit, or wrongly "
        "calibrated; causes are still judged, but the values of stiffness and damping mean nothing"
    ]


def _more_than_noise(above: dict[str, float]) -> list[str]:
    return [
        f"{channel}: the remaining error is {times:.2g} times the noise, as measured in the air, or as what is left when every cause is "
        "fitted to every session by itself; no cause that could be named accounts for it"
        for channel, times in above.items()
    ]


def _as_read(bound: dict[str, Any], encoder_step: float, model: Model) -> dict[str, Any]:
    """An entry of `excluded`, with its bound raised to what the encoder can resolve: a length of the rig below the encoder's step can be
    neither named nor ruled out, nor can a dead zone that acts like a surface half a step deeper."""
    if bound["unit"] == "m" and bound.get("where") == "rig":
        return raised(bound, encoder_step)
    if bound["cause"] == "dead_zone" and bound["unit"] == "N":
        channels = {"skin": ["force"], "taxel": [f"taxel_{i}" for i in range(len(model.shares))]}.get(bound["where"], [bound["where"]])
        return raised(bound, 0.5 * encoder_step * max(stiffness(model, c) for c in channels))
    return bound


def _never_loaded(certain: dict[str, float], left: dict[str, float]) -> list[str]:
    return [
        f"{channel}: the sessions that were fitted hardly tell what it reads where the others press, so its error there "
        f"({left[channel]:.3g} N) says nothing about the model; fit a session that loads it, too"
        for channel, rms in certain.items()
        if left[channel] > UNSURE * rms
    ]


def _simulated(symptom: Symptom, predicts: bool) -> dict[str, Any]:
    """Whether the extended model contains the fault and predicts data with it, in fields and as a sentence."""
    effect = effect_of(symptom)
    if symptom.evidence.get("put_right"):
        return {"simulated": "no: it was taken out of the record, as a tare would have done", "in_model": False}
    if symptom.evidence.get(UNLIKE):
        why = "the effect of the simulated skin has another form, which would fit the record worse than none"
        return {"simulated": f"no: {why}", "in_model": False}
    if effect is None:
        return {"simulated": "no: the simulated skin has no effect for this", "in_model": False}
    has = {"in_model": True, "forms": [type(effect).__name__]}
    if predicts:
        return {"simulated": "yes, and held-out data are predicted with it", **has}
    reasons = dict.fromkeys(PREDICTS, "the noise carries readings across the steps") | {
        "adhesion": "the moments at which it acts are not compared",
        "saturation": "the force that clips drives the simulation",
        "dead_taxel": "a taxel that reads nothing has no share of the force in either model",
    }
    why = reasons.get(symptom.cause, "it comes at random")
    return {"simulated": f"yes, but nothing is predicted with it, for {why}", "predicts_nothing_for": why, **has}


def hid_in(named: Named, c: Criticism) -> dict[str, Any]:
    """The baseline's parameters that this cause had biased, before and after it was named."""
    if named.before is None or named.model is None:
        return {}
    return moved(named.model, named.before, c)


def moved(after: Model, before: Model, c: Criticism) -> dict[str, Any]:
    """Parameters of dispersion model and shares that differ clearly between two models."""
    which = [u for u in unknowns(before, c.train[0]) if isinstance(u.part, str)]
    pairs = zip(which, values(before, tuple(which)), values(after, tuple(which)), strict=True)
    return {
        u.label: {"before": float(b), "after": float(a), "unit": u.parameter.unit}
        for u, b, a in pairs
        if abs(a - b) > max(MOVED_SHARE * abs(b), MOVED_ERRORS * (c.baseline.std.get(u.label) or 0.0))
    }


def samples_compared(name: str, c: Criticism) -> tuple[np.ndarray, np.ndarray] | None:
    """The instants (n,) of a session, filtered and decimated, and which of them were compared; None if there is no such session."""
    mine = [s for s in (*c.train, *c.held) if s.name in (name, name + FITTED, name + KEPT)]
    return (mine[0].t, np.any([s.weight.min(axis=0) > 0.0 for s in mine], axis=0)) if mine else None


def _compared(name: str, c: Criticism) -> dict[str, Any]:
    """How many samples of a recording (filtered and decimated) were compared, how many were left out, and why."""
    told = samples_compared(name, c)
    if told is None:
        return {}
    seen = told[1]
    kept, out = int(seen.sum()), int((~seen).sum())
    because = "contact may have been lost or regained there, the record is wrong there, or it begins in contact and the skin still relaxes"
    return {"compared": {"samples": kept, "left_out": out, **({"because": because} if out else {})}}
