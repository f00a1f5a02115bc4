"""The content of findings.json, schema 1, from a finished criticism."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from skin_ident.criticism.baseline.residual import residual, rmse, stiffness
from skin_ident.criticism.baseline.unknowns import Unknown, values
from skin_ident.criticism.courses.run import AT_REST
from skin_ident.criticism.pattern import FEWEST_SESSIONS, in_sessions, pattern, span
from skin_ident.criticism.said import Said
from skin_ident.criticism.search.bounds import excluded_and_untestable
from skin_ident.criticism.search.named import Criticism, Named, NotNamed
from skin_ident.criticism.search.own_skin import strays
from skin_ident.criticism.search.rivals import Rival
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.telemetry.dead import apart
from skin_ident.criticism.telemetry.encoder_noise import DECLARED, undeclared_noise
from skin_ident.criticism.telemetry.lines import not_searched
from skin_ident.criticism.telemetry.quantization import no_finer, undeclared_steps
from skin_ident.criticism.telemetry.symptom import Symptom, sensor_of
from skin_ident.criticism.telling.by_session import by_session, most_left
from skin_ident.criticism.telling.entry import Entry, alternative, no_gain
from skin_ident.criticism.telling.given_model import not_there, numbers_fitted
from skin_ident.criticism.telling.leftover import Rest
from skin_ident.criticism.telling.untold import KNOWN_LOAD, with_load_cell_untold
from skin_ident.criticism.vocabulary import BY_NAME, PARAMETERS, STIFFER, Key, word_of
from skin_ident.recordings.carried import said_of
from skin_ident.recordings.recording import Recording
from skin_ident.separating.choose import Experiment
from skin_models.model import Model
from skin_models.parameter import parameters_of

SCHEMA = 1
OTHER_SKIN = "the skin differs from session to session, and one set of parameters does not fit all of them"
SAME_SKIN = "see what changed between sessions (specimen, place, temperature, age); fit different skins separately"
Experiments = Mapping[Key, tuple[str, Experiment]]  # by cause and place: file name of the battery, and the experiment with its reasons


def described(model: Model, which: tuple[Unknown, ...], std: dict[str, float], train: list[Session], held: list[Session]) -> dict[str, Any]:
    """A model as `baseline` and `extended` in findings.json hold it: parameters with standard errors, and RMSE by channel."""
    present = values(model, which)
    parameters = {
        u.label: {"value": float(v), "unit": u.parameter.unit, "std": std.get(u.label)} for u, v in zip(which, present, strict=True)
    }
    errors = {
        part: rmse([residual(model, s) for s in sessions], sessions) if sessions else {}
        for part, sessions in (("train", train), ("held_out", held))
    }
    channels = train[0].channels
    return {
        "model": model.name,
        "parameters": parameters,
        "rmse": {c: {"train": errors["train"].get(c), "held_out": errors["held_out"].get(c), "unit": "N"} for c in channels},
    }


def found(
    named: Named, model: Model, std: dict[str, float], experiments: Experiments, had: int = 0, driven: bool = False
) -> dict[str, Any]:
    """One entry of `findings` for a cause named by the search. The first `had` effects belong to a given model and are not part of it;
    `driven` says whether force drives the sessions."""
    effects = [e for e in model.effects[had:] if e.key == named.key]
    parameters: dict[str, Any] = numbers_fitted(named, model, std) if named.key == PARAMETERS and not named.is_another_skin else {}
    for i, e in enumerate(model.effects):
        for p in parameters_of(e) if i >= had and e in effects else ():
            label = model.listed_as(i, p.name)
            parameters[label.rsplit(".", 1)[1]] = {"value": p.value, "unit": p.unit, "std": std.get(label)}
    gain = named.gain
    evidence = {
        "likelihood_gain": float(named.explained),
        "held_out_fall_of_mean_square": gain.relative,
        "held_out": gain.held_out,
        "forms": [type(e).__name__ for e in effects],
        **_of_each_session(named),
        **_in_some(named),
        **not_there(named, model, std),
    }
    separating, computed = _separating(named, experiments, driven)
    return Entry(
        cause=named.cause,
        where=named.where,
        channels=gain.carried,
        parameters=parameters,
        evidence=evidence,
        gain=gain.entry,
        alternatives=_alternatives(named),
        separating=separating,
        computed=computed,
        means=OTHER_SKIN if named.is_another_skin else "",
        advice=advice_on(named) + ("" if driven else _as_a_screw_does(named, model)),
    ).as_json


def advice_on(named: Named) -> str:
    """What to do about a finding. Courses that may have jumped, and causes that only some sessions have, need more than the usual
    advice."""
    if named.is_another_skin:
        return SAME_SKIN
    usual, own = BY_NAME[named.cause].act, named.courses.values()
    if named.only:
        return f"look for what changed between the sessions (another plug, filter or specimen, a new mounting, a loose screw); then {usual}"
    if any(course.under_way for course in own):
        return f"look for what happened at the moments that are named (a knock, a plug, a new mounting, a tare in between); then {usual}"
    if any(course.crept for course in own):
        return f"see in the pictures whether it crept ({usual}) or jumped: then look for a knock, a loose connector or a tare in between"
    return f"{usual}, before every session" if own else usual


def _as_a_screw_does(named: Named, model: Model) -> str:
    """What else to look at where a bend of the force over depth is no larger than the depth itself may be off by: an encoder on the motor
    does not see the errors of the screw."""
    if named.key != STIFFER:
        return ""
    off = float(np.sqrt(named.gain.squares)) / max(stiffness(model, named.gain.channel), 1e-9)
    if off > AT_REST:
        return ""
    return f"; an error of {1e6 * off:.2g} µm in depth, as a screw may have, would do as much: compare the depth with another sensor first"


def _of_each_session(named: Named) -> dict[str, Any]:
    """The courses of a finding in words and numbers by session, and their pattern from session to session."""
    if not named.courses:
        return {}
    said = "; ".join(f"{session}: {course}" for session, course in named.courses.items())
    goes = _goes(named.courses)
    of_many = goes if len(named.courses) >= FEWEST_SESSIONS else {}
    why = f"each session has its own ({of_many.get('pattern', said)}), which no parameter shared by all sessions can describe"
    sizes = {session: list(course.sizes) for session, course in named.courses.items()}
    return {"why": why, "of_each_session": named.courses, "sessions": sizes, **goes}


def _goes(courses: dict[str, Said]) -> dict[str, Any]:
    """The total of each session's numbers where they add up (`whole`), and their pattern over the sessions, or else their range."""
    whole = {session: course.whole for session, course in courses.items() if course.whole}
    units = {q["unit"] for course in courses.values() for q in course.sizes}
    if len(units) != 1:
        return {}
    unit = units.pop()
    if len(whole) < len(courses):
        every = [q["value"] for course in courses.values() for q in course.sizes]
        return {"pattern": span(every, unit)}
    values = {session: q["value"] for session, q in whole.items()}
    return {"whole": whole, "pattern": pattern(values, unit) or span(values.values(), unit)}


def _in_some(named: Named) -> dict[str, Any]:
    if not named.only:
        return {}
    why = f"it is in {', '.join(named.only)}, as far as each session tells, and not in {', '.join(named.free)}"
    return {"why": why, **in_sessions(named.only, (*named.only, *named.free))}


def _alternatives(named: Named) -> list[dict[str, Any]]:
    """Every alternative name once, in the order of the search; of several clocks of the catalogue the one that explains most."""
    nearest: dict[Key, Rival] = {}
    for a in named.alternatives:
        key = a.cause, word_of(a.where)
        nearest[key] = min(a, nearest.get(key, a), key=lambda rival: rival.short_by)
    nearest.pop((named.cause, word_of(named.where)), None)
    return [alternative(*a.key, a.short_by, _fitted(a, named)) for a in nearest.values()]


def _fitted(rival: Rival, named: Named) -> dict[str, Any]:
    """Parameters and forms of a rival in its own model; {} where it was not fitted as an effect."""
    had = named.before.effects if named.before is not None else ()
    new = [(i, e) for i, e in enumerate(rival.model.effects) if e not in had] if rival.model is not None else []
    mine = [(i, e) for i, e in new if e.key == rival.key]
    sizes = {
        rival.model.listed_as(i, p.name).rsplit(".", 1)[1]: {"value": p.value, "unit": p.unit} for i, e in mine for p in parameters_of(e)
    }
    return {"parameters": sizes, "forms": [type(e).__name__ for _, e in mine]} if sizes else {}


def seen(symptom: Symptom) -> dict[str, Any]:
    """One entry of `findings` for a symptom of telemetry. It is no term of the model, so it claims no gain until it is judged."""
    return Entry(
        cause=symptom.cause,
        where=symptom.where,
        channels=symptom.channels,
        parameters=symptom.parameters,
        evidence=dict(symptom.evidence),
        gain=no_gain(symptom.channels[0]),
        alternatives=[alternative(*key) for key in symptom.alternatives],
        separating=symptom.apart,
    ).as_json


def _separating(named: Named, experiments: Experiments, driven: bool) -> tuple[str, dict[str, Any]]:
    """The experiment that would separate a cause from its rivals, and the battery where one was computed. Otherwise the needs of all of
    them in words, preceded by what separates a load cell that drives the test."""
    if not named.alternatives:
        return "", {}
    if named.key in experiments:
        file, experiment = experiments[named.key]
        return experiment.sentence(file), {"separating_evidence": experiment.numbers, **({"battery": file} if file else {})}
    beside = [KNOWN_LOAD] if driven and any(where == "load_cell" for _, where in (named.key, *(a.key for a in named.alternatives))) else []
    rivals = dict.fromkeys([named.cause, *(a.cause for a in named.alternatives)])
    return "record " + "; and ".join(dict.fromkeys([*beside, *(BY_NAME[r].needs for r in rivals)])), {}


def telemetry_words(recordings: list, given: bool) -> dict[str, str]:
    """For causes that telemetry decides: why it could not look, or "" where it did."""
    declared = recordings[0].declared
    noise = declared.force_noise_n or declared.taxel_noise_n or declared.encoder_noise_um
    return {
        "outliers": "",
        "dead_taxel": "" if len(recordings[0].taxels) else "there is no taxel in these recordings",
        "data_error": "",
        "interference": not_searched(recordings),
        "saturation": "",
        "quantization": "",  # except for undeclared steps, see `_steps_seen`
        "noise": "" if noise else "rig.yaml does not declare a noise level",
        "parameters": "" if given else "no model was given to compare with",
    }


def _steps_seen(recordings: list) -> dict[str, NotNamed]:
    """Converter steps without a declared value, by place: whether they are as they should be cannot be decided."""
    n = len(recordings[0].taxels)
    return {
        sensor_of(channel, n): NotNamed(
            step, f"the levels of {channel} are {step:.3g} N apart, and rig.yaml declares no step to compare with"
        )
        for channel, step in undeclared_steps(recordings).items()
    }


def _encoder_noise_seen(recordings: list, model: Model) -> dict[str, NotNamed]:
    """The note on an encoder that is noisy, where nothing declares how noisy it should be."""
    because = undeclared_noise(recordings, model)
    return {sensor_of("depth", len(recordings[0].taxels)): NotNamed(np.inf, because, DECLARED)} if because else {}


def _silent(taxel: str, recordings: list) -> NotNamed:
    """The note on a taxel of which it is unknown whether it is dead."""
    because = f"{taxel} does not follow the load in any session, and nothing says that it should: it is open-circuit, or out of reach"
    places = "" if recordings[0].declared.taxel_positions_mm else "the place of every taxel in rig.yaml (taxel_positions_mm), or "
    return NotNamed(np.inf, because, f"{places}a press on {taxel}")


def _not_findings(c: Criticism, recordings: list, named: set[Key]) -> dict[str, dict[str, NotNamed]]:
    """By cause and place: what is in the record without being a finding, because nothing was declared to compare with or because good
    hardware does as much; without what is `named`."""
    seen = {
        "quantization": _steps_seen(recordings),
        "dead_taxel": {taxel: _silent(taxel, recordings) for taxel in apart(recordings)},
        "noise": _encoder_noise_seen(recordings, c.extended.model),
    }
    for (cause, where), why in c.not_named.items():
        if (cause, word_of(where)) not in named:
            seen.setdefault(cause, {}).setdefault(where, why)
    return seen


def _recording(r: Recording, held_out: bool) -> dict[str, Any]:
    """The fixed part of an entry of `recordings`."""
    return {
        "name": r.name,
        "samples": len(r),
        "seconds": float(r.t[-1] - r.t[0]),
        "rate_hz": float(1.0 / r.dt),
        "held_out": held_out,
        "warnings": list(r.warnings),
    }


def as_findings(
    c: Criticism,
    symptoms,
    recordings: list,
    train: list[Session],
    held: list[Session],
    rest: Rest,
    verdict: str,
    given: bool,
    experiments: Experiments,
) -> dict[str, Any]:
    """The whole of findings.json. `train` and `held` are the sessions without what was found to be their own; `given`: the baseline is a
    model somebody gave, whose parameters have no standard errors."""
    before = [[c.before(s) for s in part] for part in (c.train, c.held)]
    baseline = described(c.baseline.model, c.baseline.unknowns, {} if given else c.baseline.std, *before)
    baseline |= {"given": True} if given else {}
    had = len(c.baseline.model.effects) if given else 0
    driven = train[0].drive is not None
    entries = [seen(s) for s in symptoms] + [found(n, c.extended.model, c.extended.std, experiments, had, driven) for n in c.named]
    named = {(e["cause"], e["where"]) for one in entries for e in (one, *one["alternatives"])}
    known = telemetry_words(recordings, given)
    each = by_session(c, [*train, *held])
    rounds, seen_there = [s for s, _ in c.rounds], _not_findings(c, recordings, named)
    skins = strays(c.extended.model, [s for s in (*c.train, *c.held) if s.skin])
    excluded, untestable = excluded_and_untestable(c.last, rounds, {cause for cause, _ in named}, known, seen_there, c.grown, skins)
    untestable = with_load_cell_untold(untestable, named) if driven else untestable
    return {
        "schema": SCHEMA,
        "recordings": [_recording(r, any(r.name == s.name for s in held)) | each.get(r.name, {}) for r in recordings],
        "baseline": baseline,
        "findings": entries,
        "excluded": no_finer(excluded, recordings),
        "untestable": untestable,
        "extended": described(c.extended.model, _all_of(c) if given else c.extended.unknowns, c.extended.std, list(c.train), list(c.held)),
        "systematic_rest": rest.as_json | most_left(each),
        "verdict": verdict,
        "warnings": _warnings(recordings),
    }


def _all_of(c: Criticism) -> tuple[Unknown, ...]:
    """The unknowns of baseline and extended model. With a given model whose numbers are right only effects are fitted, so the extended one
    lacks those of the baseline."""
    fitted = {u.label for u in c.extended.unknowns}
    return (*(u for u in c.baseline.unknowns if u.label not in fitted), *c.extended.unknowns)


def of_reading(recordings: list) -> list[str]:
    """The warnings of all recordings; those that all sessions share appear once."""
    said = {r.name: dict.fromkeys((*r.warnings, *r.declared.warnings)) for r in recordings}
    shared = [w for w in said[recordings[0].name] if len(recordings) > 1 and all(w in own for own in said.values())]
    return [f"every session: {w}" for w in shared] + [said_of(name, w) for name, own in said.items() for w in own if w not in shared]


def _warnings(recordings: list) -> list[str]:
    """What the reader must know before relying on the findings."""
    warnings = of_reading(recordings)
    if len(recordings) == 1:
        warnings.append("only one session: blocks of it were held out, a weaker test that lets false causes pass; record a second one")
    return warnings
