"""What the judgement adds to findings.json: gains of telemetry's findings, gains by channel with the noise as their bound, what the
baseline's numbers had been hiding, and how much of the record was compared."""

from typing import Any

import numpy as np

from skin_ident.criticism.criticise import Criticism, Named
from skin_ident.criticism.faults import PREDICTS, effect_of
from skin_ident.criticism.fitting import tangents
from skin_ident.criticism.judging import Judged
from skin_ident.criticism.noise import RICHEST, pursue
from skin_ident.criticism.proposals import bank
from skin_ident.criticism.residual import residual
from skin_ident.criticism.session import Session
from skin_ident.criticism.survey import Survey
from skin_ident.criticism.telemetry.symptom import Symptom
from skin_ident.criticism.unknowns import unknowns, values
from skin_ident.criticism.whitening import Whitener, stack
from skin_models.model import Model

ROUNDING = 1e-9  # N
WELL_ABOVE = 1.5  # times the noise
OTHER_UNIT = 3.0  # times the applied force, which no taxel reads whose gain is merely off
MOVED, SURE = 0.05, 3.0  # share, and standard errors, from which a parameter is said to have moved


def tell(findings: dict[str, Any], judged: Judged, symptoms: tuple[Symptom, ...]) -> dict[str, Any]:
    """The content of findings.json with all of that; `findings["findings"]` begins with the symptoms."""
    c = judged.criticism
    floor = noise_floor(c.last, list(c.train))
    entries = findings["findings"]
    for entry, symptom, gain in zip(entries, symptoms, judged.symptoms, strict=False):
        entry["gain"] |= gain
        entry["evidence"] |= _simulated(symptom, bool(gain))
        if gain:
            entry["hid_in"] = moved(judged.naive, c.baseline.model, c)
    for entry, named in zip(entries[len(symptoms) :], c.named, strict=False):
        entry["hid_in"] = hid_in(named, c)
    bounds = {channel: {**gain, "noise_floor": floor[channel]["rms"]} for channel, gain in judged.channels.items()}
    recordings = [{**r, **_compared(r["name"], c)} for r in findings["recordings"]]
    warnings = [*findings["warnings"], *_more_than_applied(c), *_more_than_noise(findings["verdict"], bounds)]
    return {**findings, "recordings": recordings, "noise_floor": floor, "gain_by_channel": bounds, "warnings": warnings}


def _more_than_applied(c: Criticism) -> list[str]:
    """Where a taxel reads more than what presses on it, force and taxel are not in one unit: ratios hold, shares do not."""
    share = c.baseline.model.dispersion.sensed_share
    if share <= (OTHER_UNIT if c.train[0].drive is None else 1.0):
        return []
    return [
        f"the strongest taxel reads {share:.3g} times the force that is applied: one of the two is in another unit, or wrongly "
        "calibrated; causes are judged all the same, but stiffnesses and damping mean nothing"
    ]


def _more_than_noise(verdict: str, bounds: dict[str, dict[str, Any]]) -> list[str]:
    """Where nothing more could be shown on held-out data, and yet clearly more is left than noise would leave."""
    if verdict not in ("nothing_wrong", "explained"):
        return []
    above = {c: g["held_out_rmse_after"] / max(g["noise_floor"], ROUNDING) for c, g in bounds.items()}
    return [
        f"{channel}: what is left ({bounds[channel]['held_out_rmse_after']:.3g} N) is {times:.2g} times what is left when every cause may "
        "bend the model at once; these data do not suffice to tell whether that is noise: record more sessions"
        for channel, times in above.items()
        if times > WELL_ABOVE
    ]


def _simulated(symptom: Symptom, predicts: bool) -> dict[str, Any]:
    effect = effect_of(symptom)
    if effect is None:
        return {"simulated": "no: the simulated chain has no place for this"}
    reasons = dict.fromkeys(PREDICTS, "the noise carries readings across the steps") | {
        "adhesion": "the moments at which it acts are not compared"
    }
    why = reasons.get(symptom.cause, "it comes at random")
    said = "yes, and held-out data are predicted with it" if predicts else f"yes, but nothing is predicted with it, for {why}"
    return {"simulated": said, "forms": [type(effect).__name__]}


def hid_in(named: Named, c: Criticism) -> dict[str, Any]:
    """The baseline's parameters that this cause had bent: before and after it was named."""
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
        if abs(a - b) > max(MOVED * abs(b), SURE * (c.baseline.std.get(u.label) or 0.0))
    }


def noise_floor(last: Survey, sessions: list[Session]) -> dict[str, dict[str, Any]]:
    """By channel, what noise alone leaves in the common band: the residual less everything that any cause of the catalogue may explain.

    It bounds what any model can gain. `rms` N; `lag_one` is the correlation of neighbouring samples. From the training session that tells
    most, for time's sake.
    """
    longest = max(sessions, key=lambda s: float(s.weight.sum()))
    rest = left_by_everything(last.model, last.noise, longest, last)
    rows = {c: e[w > 0] for c, e, w in zip(longest.channels, rest, longest.weight, strict=True)}
    edge = float(longest.band.edge)
    return {c: {"rms": _rms(e), "unit": "N", "lag_one": _lag_one(e), "band_hz": edge} for c, e in rows.items()}


def left_by_everything(model: Model, noise: Whitener, session: Session, last: Survey) -> np.ndarray:
    """What is left (C, n) N of a session when the model's own unknowns and the richest set of directions have had their say."""
    own = tangents(model, [session], unknowns(model, session))[0]
    every = np.concatenate([own, bank(model, last.projected.which, [session])[0]])
    e = residual(model, session)
    A, r = stack([every], [session], noise), stack([e], [session], noise)
    return e - np.tensordot(pursue(A, r, len(own) + RICHEST, forced=len(own)), every, 1)


def believed(name: str, c: Criticism) -> np.ndarray | None:
    """Which samples (n,) of a session, filtered and thinned, were compared; None for a session that is not there."""
    mine = [s for s in (*c.train, *c.held) if s.name == name or s.name.startswith(f"{name} (")]  # a lone session is in two halves
    return np.any([s.weight.min(axis=0) > 0.0 for s in mine], axis=0) if mine else None


def _compared(name: str, c: Criticism) -> dict[str, Any]:
    """How many samples of a recording (filtered and thinned) were compared, and how many were not."""
    seen = believed(name, c)
    if seen is None:
        return {}
    kept, out = int(seen.sum()), int((~seen).sum())
    because = "plunger and skin may have parted or met with a jump, or the record is wrong there"
    return {"compared": {"samples": kept, "left_out": out, **({"because": because} if out else {})}}


def _rms(e: np.ndarray) -> float:
    rms = float(np.sqrt(np.mean(e**2))) if e.size else 0.0
    return rms if rms > ROUNDING else 0.0


def _lag_one(e: np.ndarray) -> float:
    return float(np.corrcoef(e[1:], e[:-1])[0, 1]) if e.size > 2 and np.ptp(e) > 0.0 else 0.0
