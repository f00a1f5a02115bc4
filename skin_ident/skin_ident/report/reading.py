"""Reads findings.json into a `View`, tolerating entries that an older or newer version left out or added."""

import math
from dataclasses import replace
from typing import Any

from skin_ident.criticism.above import above_noise
from skin_ident.criticism.gates.gate import EACH_IN_TURN
from skin_ident.criticism.search.rivals import CHANCE_SCORE
from skin_ident.criticism.vocabulary import cause_at, spoken
from skin_ident.report.numbers import finite, percent
from skin_ident.report.tolerant import mapping, place_in, sequence, text
from skin_ident.report.view import Amount, ChannelError, Finding, Gain, View
from skin_ident.report.words import advice, declared, effect_words, label, meaning, sentence, undivided
from skin_models.parameter import Parameter

NEAR_END = 0.02  # a parameter this near (relatively) to an end of its allowed range lies at it
LONE = "taxel_alone"  # the place of a lone taxel, in words.PLACES
PLACED = ("findings", "excluded", "untestable")  # entries of findings.json that hold places
TOLD_ELSEWHERE = ("cause", "where", "channel_clock", "explains_less_by", "short_by", "parameters", "forms")  # of an alternative
_KNOWN = {
    "schema",
    "recordings",
    "baseline",
    "findings",
    "excluded",
    "untestable",
    "extended",
    "noise_floor",
    "verdict",
    "warnings",
    "systematic_rest",
    "gain_by_channel",
}


def view(findings: dict[str, Any]) -> View:
    """Read the content of findings.json (schema 1)."""
    findings = _lone_taxel(findings)
    baseline, extended = mapping(findings.get("baseline")), mapping(findings.get("extended"))
    gains = {str(c): mapping(g) for c, g in mapping(findings.get("gain_by_channel")).items()}
    return View(
        verdict=text(findings.get("verdict")) or "unknown",
        model=text(baseline.get("model")),
        recordings=tuple(sequence(findings.get("recordings"))),
        findings=tuple(_finding(mapping(f), baseline) for f in sequence(findings.get("findings"))),
        errors=_errors(mapping(baseline.get("rmse")), mapping(extended.get("rmse")), mapping(findings.get("noise_floor")), gains),
        before=_model_amounts(baseline.get("parameters"), _alone(baseline), {}),
        after=_model_amounts(extended.get("parameters"), _alone(baseline), _forms(findings)),
        excluded=tuple(mapping(e) for e in sequence(findings.get("excluded"))),
        untestable=tuple(mapping(e) for e in sequence(findings.get("untestable"))),
        warnings=tuple(text(w) for w in sequence(findings.get("warnings"))),
        rest=finite(mapping(findings.get("systematic_rest")).get("fall_of_mean_square")),
        band_hz=_band(mapping(findings.get("noise_floor"))),
        in_turn=any(g.get("tested_on") == EACH_IN_TURN for g in gains.values()),
        other={k: v for k, v in findings.items() if k not in _KNOWN},
        held=tuple(_held(str(name), mapping(h)) for name, h in mapping(baseline.get("held")).items()),
        above=above_noise(findings),
        given=baseline.get("given") is True,
        most_left=mapping(findings.get("systematic_rest")),
    )


def _band(floors: dict[str, Any]) -> float | None:
    """The edge (Hz) of the band in which errors are counted, from the first noise floor that has it; None where none has."""
    edges = (finite(mapping(floor).get("band_hz")) for floor in floors.values())
    return next((hz for hz in edges if hz is not None), None)


def _alone(baseline: dict[str, Any]) -> bool:
    """Whether the load cell stands alone: without taxels the skin carries one force, not two parts of it."""
    return set(mapping(baseline.get("rmse"))) == {"force"}


def _lone_taxel(findings: dict[str, Any]) -> dict[str, Any]:
    """The findings with the place `taxel` replaced where there is only one taxel: it then means that taxel, not all taxels alike."""
    channels = [c for c in mapping(mapping(findings.get("baseline")).get("rmse")) if str(c).startswith("taxel")]
    return {**findings, **{k: lone(v) for k, v in findings.items() if k in PLACED}} if len(channels) == 1 else findings


def lone(thing: Any) -> Any:
    """A copy in which every place `taxel` is replaced by that of a lone taxel."""
    if isinstance(thing, list):
        return [lone(x) for x in thing]
    if isinstance(thing, dict):
        return {k: LONE if k == "where" and v == "taxel" else lone(v) for k, v in thing.items()}
    return thing


def recording_name(r: Any) -> str:
    """The name of an entry of `recordings`."""
    entry = mapping(r)
    return text(entry.get("name") or entry.get("session") or entry.get("path")) or text(r) or "recording"


def warning_sentences(v: View) -> list[str]:
    """The warnings as sentences. A session's name at the beginning is not capitalised."""
    names = tuple(f"{recording_name(r)}:" for r in v.recordings)
    return [sentence(w, begins_with_name=w.startswith(names)) for w in v.warnings]


def _forms(findings: dict[str, Any]) -> dict[tuple[str, str], tuple[str, ...]]:
    """The forms of what was found, by cause and place."""
    found = [mapping(f) for f in sequence(findings.get("findings"))]
    return {(text(f.get("cause")), text(f.get("where"))): _of_entry(f) for f in found}


def _of_entry(entry: dict[str, Any]) -> tuple[str, ...]:
    """The forms of a finding, or of one of its alternatives."""
    return tuple(map(text, sequence(mapping(entry.get("evidence")).get("forms")) or sequence(entry.get("forms"))))


def _model_amounts(entries: Any, alone: bool, forms: dict[tuple[str, str], tuple[str, ...]]) -> tuple[Amount, ...]:
    """The parameters of a model: those of the dispersion model (`k1`), and those of its effects (`stress_relaxation.skin.tau`), whose
    `forms` are given by cause and place where they are known."""
    entries = _felt({str(name): entry for name, entry in mapping(entries).items()}, alone)
    parts: dict[tuple[str, str], list[str]] = {}
    for name in entries:
        if name.count(".") == 2:
            cause, where, short = name.split(".")
            parts.setdefault((cause, where), []).append(short)
    words, known = {}, {}
    for (cause, where), names in parts.items():
        of = cause, where, tuple(names), forms.get((cause, where), ())
        said = effect_words(*of)
        words |= {f"{cause}.{where}.{short}": f"{cause_at(cause, where)}: {said.get(short) or spoken(short)}" for short in names}
        known |= {f"{cause}.{where}.{short}": p for short, p in declared(*of).items()}
    return tuple(_in_range(_amount(name, entry, _said(words, name, alone)), known.get(name)) for name, entry in entries.items())


def _felt(entries: dict[str, Any], alone: bool) -> dict[str, Any]:
    """The entries, by parameter, without those of the part that taxels feel where the load cell stands `alone`."""
    return {name: entry for name, entry in entries.items() if not (alone and name.endswith("_sensed"))}


def _said(words: dict[str, str], name: str, alone: bool) -> str:
    """The words for a parameter, undivided where the load cell stands `alone`."""
    said = words.get(name) or label(name)
    return undivided(said) if alone else said


def _amount(name: str, entry: Any, words: str) -> Amount:
    entry = entry if isinstance(entry, dict) else {"value": entry}
    return Amount(name, words, finite(entry.get("value")), text(entry.get("unit")), finite(entry.get("std")))


def _held(name: str, entry: dict[str, Any]) -> tuple[Amount, str]:
    return _amount(name, entry, label(name)), text(entry.get("because"))


def _finding(f: dict[str, Any], baseline: dict[str, Any]) -> Finding:
    cause, where = text(f.get("cause")), place_in(f)
    channels, evidence = tuple(text(c) for c in sequence(f.get("channels"))), mapping(f.get("evidence"))
    alternatives, alone = sequence(f.get("alternatives")), _alone(baseline)
    return Finding(
        cause=cause,
        where=where,
        channels=channels,
        amounts=_amounts(cause, where, f, alone),
        evidence=tuple(evidence.items()),
        gain=_gain(mapping(f.get("gain")), channels, baseline, evidence.get("held_out")),
        alternatives=tuple(_alternative(a, evidence) for a in alternatives),
        separating=text(f.get("separating_experiment")),
        hid_in=tuple(_bent(str(name), mapping(entry)) for name, entry in mapping(f.get("hid_in")).items()),
        battery=text(f.get("battery")),
        by_hand="separating_evidence" in f and not f.get("battery"),
        act=text(f.get("advice")) or advice(cause),
        means=text(f.get("means")) or meaning(cause),
        behind=tuple(_behind(a, evidence) for a in alternatives),
        rival_amounts=tuple(_amounts(text(a.get("cause")), place_in(a), a, alone) for a in map(mapping, alternatives)),
    )


def _amounts(cause: str, where: str, entry: dict[str, Any], alone: bool) -> tuple[Amount, ...]:
    """The parameters of a finding, or of one of its alternatives. Where the load cell stands `alone`, those of the part that taxels feel
    are left out."""
    sizes = _felt({str(name).rpartition(".")[2]: size for name, size in mapping(entry.get("parameters")).items()}, alone)
    of = cause, where, tuple(sizes), _of_entry(entry)
    words, known = effect_words(*of), declared(*of)
    return tuple(_in_range(_amount(name, size, _said(words, name, alone)), known.get(name)) for name, size in sizes.items())


def _in_range(a: Amount, p: Parameter | None) -> Amount:
    """The amount, with its neutral value and whether it lies at the end of its range, where its parameter is declared. Natural ends, such
    as the whole of a signal, or a full turn, do not count."""
    if p is None or a.value is None:
        return a
    natural = {0.0, p.neutral, *([1.0, -1.0] if p.unit == "1" else [])}
    ends = [end for end in (p.lower, p.upper) if math.isfinite(end) and end not in natural and p.unit != "rad"]
    return replace(a, none=p.neutral, at_end=any(abs(a.value - end) <= NEAR_END * abs(end) for end in ends))


def _bent(name: str, entry: dict[str, Any]) -> tuple[Amount, Amount]:
    values = (finite(entry.get(k)) for k in ("before", "after"))
    before, after = (Amount(name, label(name), value, text(entry.get("unit"))) for value in values)
    return before, after


def _gain(g: dict[str, Any], channels: tuple[str, ...], baseline: dict[str, Any], held_out: Any) -> Gain:
    low, high = _interval(g)
    channel = text(g.get("channel")) or (channels[0] if channels else "")
    unit = text(g.get("unit")) or text(mapping(mapping(baseline.get("rmse")).get(channel)).get("unit")) or "N"
    return Gain(
        before=finite(g.get("held_out_rmse_before")),
        after=finite(g.get("held_out_rmse_after")),
        low=low,
        high=high,
        channel=channel,
        unit=unit,
        held_out=text(g.get("held_out") or held_out),
    )


def _interval(gain: dict[str, Any]) -> tuple[float | None, float | None]:
    """The ends of a gain's 95 % interval; None where one is not known."""
    low, high, *_ = (*map(finite, sequence(gain.get("ci95"))), None, None)
    return low, high


def _alternative(a: Any, evidence: dict[str, Any]) -> tuple[str, str, str]:
    if not isinstance(a, dict):
        return text(a), "", ""
    less = finite(_short_by(a))
    rest = {k: v for k, v in a.items() if k not in TOLD_ELSEWHERE}
    behind = _behind(a, evidence)
    said = [] if less is None else [f"explains {percent(behind)} less" if behind is not None else "explains about as much"]
    return text(a.get("cause")), place_in(a), "; ".join([*said, *([text(rest)] if rest else [])])


def _behind(a: Any, evidence: dict[str, Any]) -> float | None:
    """How much less an alternative explains, as a share of what the named cause explains; None where that may be chance or is not known."""
    less, whole = (finite(x) for x in (_short_by(a), evidence.get("likelihood_gain")))
    return less / whole if less is not None and whole and less > CHANCE_SCORE and less < whole else None


def _short_by(a: Any) -> Any:
    entry = mapping(a)
    return entry.get("explains_less_by", entry.get("short_by"))


def _errors(before: dict, after: dict, floor: dict, gains: dict) -> tuple[ChannelError, ...]:
    names = dict.fromkeys([*before, *after])
    return tuple(_error(c, mapping(before.get(c)), mapping(after.get(c)), floor.get(c), mapping(gains.get(c))) for c in names)


def _error(channel: str, before: dict, after: dict, floor: Any, gain: dict) -> ChannelError:
    if isinstance(floor, dict):
        floor = next((v for v in (finite(floor.get(k)) for k in ("rms", "value", "rmse", "std")) if v is not None), None)
    pairs = [(finite(before.get(k)), finite(after.get(k))) for k in ("train", "held_out")]
    if gain.get("tested_on") == EACH_IN_TURN:
        pairs[1] = (finite(gain.get("held_out_rmse_before")), finite(gain.get("held_out_rmse_after")))
    low, high = _interval(gain)
    interval = None if low is None or high is None or low == high == 0.0 else (low, high)
    return ChannelError(channel, text(before.get("unit") or after.get("unit")) or "N", *pairs, finite(floor), interval)
