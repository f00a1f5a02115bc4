"""The first screen in plain words: what is wrong, why we think so, how much better the model is, how sure we are, what to do next."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.pattern import listed
from skin_ident.criticism.telling.outcome import Outcome, Round, ScanTrace, Trace
from skin_ident.criticism.vocabulary import cause_at, spoken, word_of
from skin_ident.report.counsel import next_steps, rebuild_answer, sure, unsure
from skin_ident.report.focus import Focus, focus, rms
from skin_ident.report.gains import Figure, better
from skin_ident.report.numbers import amount, percent, plain
from skin_ident.report.reading import LONE, view
from skin_ident.report.ruled_out import reach
from skin_ident.report.sessions import goes_on_from_day_to_day, most_left
from skin_ident.report.shapes import residuals, smooth
from skin_ident.report.sizes import rival_sizes, sizes
from skin_ident.report.tolerant import named_at, text, with_spoken_taxels
from skin_ident.report.view import DIRECT, EXPLAINED, NOTHING, PARTLY, UNEXPLAINED, Finding, View, unit_of
from skin_ident.report.words import capital, either, meaning, sentence, signal

CLEARLY = 0.9  # the picture supports a finding if with it the error is at most this share of that without it
UNLIKE_DECLARED = "but only if the force is distributed over the taxels differently from the declared layout"
UNSURE = {  # sentences by the caveat in the title (see `counsel.unsure`)
    "not surely": "Neither gain nor name is sure.",
    "not proven": "The gain was not tested on data that were kept aside.",
}
ROUNDING = 1e-9  # a cause that explains less than this share of the best one explains nothing
MOST_NAMES = 3  # names of one finding in the headline
MOST_SIZES = 3  # with more findings, sizes on the first screen are brief


@dataclass(frozen=True)
class Headline:
    """The verdict: `tone` picks the colour of the banner (good, found, part, bad)."""

    tone: str
    title: str
    line: str


@dataclass(frozen=True)
class Wrong:
    """One thing that is wrong: its name, what that means, and its size; or a sentence alone. An entry with `of_last` belongs to the last
    entry without: another name for it, or how well such names fit."""

    name: str
    means: str
    size: str = ""
    of_last: bool = False


@dataclass(frozen=True)
class Story:
    """Everything the first screen says. Tuples of text hold sentences."""

    headline: Headline
    wrong: tuple[Wrong, ...]
    why: tuple[str, ...]
    better: Figure
    sure: str
    sure_because: tuple[str, ...]
    rebuild: str
    rebuild_because: str
    next: tuple[str, ...]


@dataclass(frozen=True)
class Told:
    """An outcome with everything that page, markdown and pictures share, computed once. `folder` is that of findings.json and its files,
    empty where they are beside the report. `seen` is what to look at first."""

    outcome: Outcome
    view: View
    seen: Focus | None
    story: Story
    folder: str = ""


def tell(outcome: Outcome, folder: str = "") -> Told:
    """Read an outcome, pick what to look at first, and put it into words."""
    v = replace(view(outcome.findings), reach=reach(outcome.traces))
    if _has_one_taxel(v):
        outcome = replace(outcome, rounds=tuple(replace(r, ranked=_lone(r.ranked)) for r in outcome.rounds))
    outcome = outcome if v.findings else replace(outcome, traces=tuple(map(_kept, outcome.traces)), scans=tuple(map(_kept, outcome.scans)))
    seen = focus(outcome.traces, v)
    wrong, why = tuple(_wrong(v, seen)), tuple(_why(v, seen, outcome.rounds))
    story = Story(_headline(v), wrong, why, better(v), *sure(v), *rebuild_answer(v), tuple(next_steps(v, folder)))
    return Told(outcome, v, seen, story, folder)


def _kept(trace: Trace | ScanTrace) -> Trace | ScanTrace:
    """The trace with the extended simulation as its baseline, for outcomes that name nothing: there is then only one simulation, and zeros
    fitted to each session must not be shown as a gain."""
    return replace(trace, baseline=trace.extended)


def _has_one_taxel(v: View) -> bool:
    return sum(e.channel.startswith("taxel") for e in v.errors) == 1


def _lone(ranked: tuple[tuple[str, str, float], ...]) -> tuple[tuple[str, str, float], ...]:
    return tuple((c, LONE if w == "taxel" else w, g) for c, w, g in ranked)


def _headline(v: View) -> Headline:
    names, open_ = _names(v), unsure(v)
    if v.verdict == NOTHING:
        down = "The simulation matches these measurements down to their noise."
        if goes_on_from_day_to_day(v):
            down = "The simulation matches each session down to its noise, but the fitted numbers change from session to session."
        if v.unsettled:
            down = "No cause could be named beyond doubt." if v.doubts else f"{down[:-1]}, {UNLIKE_DECLARED}."
            title = f"Nothing named, but not settled: {either([named_at(e) for e in v.unsettled], MOST_NAMES)}"
            return Headline("part", title, _above(v, "No cause could be named beyond doubt") or down)
        if above := _above(v, "No cause could be named"):
            return Headline("good", "Nothing wrong that could be named", above)
        return Headline("good", "Nothing wrong found", down)
    if v.verdict == EXPLAINED and not v.judged:
        return Headline("found", f"Explained: {names}", _in_the_record(v))
    if v.verdict == EXPLAINED:
        down = "With this in the model, the remaining mismatch looks like noise."
        down = _above(v, "With this in the model, nothing more could be named") or down
        if open_:
            return Headline("part", f"Explained, but {open_}: {names}", f"{down} {UNSURE[open_]}")
        return Headline("found", f"Explained: {names}", down)
    if v.verdict == PARTLY and open_:
        return Headline("part", f"Partly explained, but {open_}: {names}", f"The remaining error is not only noise. {UNSURE[open_]}")
    if v.verdict == PARTLY:
        return Headline("part", f"Partly explained: {names}", "The extended model is better, but the remaining error is not only noise.")
    if v.verdict == UNEXPLAINED:
        title = f"Not explained, despite {names}" if v.findings else "Not explained"
        return Headline("bad", title, "The simulation is measurably wrong, and no known cause explains the error.")
    return Headline("part", capital(spoken(v.verdict)), "This version of the report does not know this verdict; see the findings below.")


def _in_the_record(v: View) -> str:
    compared = any(None not in e.train for e in v.errors)
    rest = "the simulation matches the rest of it" if compared else "what is left of it is too little to judge a simulation"
    if all(f.cause in DIRECT or f.put_right for f in v.findings):
        return f"The fault is in the record itself; {rest}."
    return f"It is seen in samples that the comparison leaves out; {rest}."


def _above(v: View, begins: str) -> str:
    """A sentence, begun with `begins`, where the error is clearly above the noise, but not enough to need a cause; else empty."""
    if v.above is None:
        return ""
    channel, times = v.above
    return f"{begins}; what is left of the {signal(channel)} is {percent(times - 1.0)} above what noise alone leaves."


def _names(v: View) -> str:
    said = [f.called + f.in_some for f in v.findings]
    if not said:
        return "no single cause"
    if len(said) == 1 and v.findings[0].each_session and v.findings[0].has_pattern and not v.findings[0].alternatives:
        return f"{said[0]}, which {v.findings[0].goes.partition(', from ')[0]}"
    if len(said) == 1 and v.findings[0].alternatives:
        return either([cause_at(*name) for name in v.findings[0].names], MOST_NAMES) + v.findings[0].in_some
    if len(said) == 2 and v.findings[0].where == v.findings[1].where and not v.findings[0].in_some:
        said[0] = spoken(v.findings[0].cause)
    return said[0] if len(said) == 1 else f"{said[0]}, and {len(said) - 1} more" if len(said) > 2 else " and ".join(said)


def _wrong(v: View, seen: Focus | None) -> Iterator[Wrong]:
    """Each finding with its rivals, then what they amount to in newtons, and what is not settled."""
    for f in v.findings:
        size = "; ".join(sizes(f, v, brief=len(v.findings) > MOST_SIZES))
        yield Wrong(capital(f.called) + f.in_some, sentence(f.means), size)
        for i, (cause, where, _) in enumerate(f.alternatives[:MOST_NAMES]):
            yield Wrong(f"Or {cause_at(cause, where)}", sentence(meaning(cause)), "; ".join(rival_sizes(f, i, brief=True)), of_last=True)
        yield from (Wrong("", said, of_last=True) for said in _as_well(f))
    if v.judged and seen is not None and seen.changes:
        yield Wrong("", _in_newtons(seen, v))
    elif v.verdict == UNEXPLAINED and seen is not None:
        yield Wrong("", _stray(seen, v))
    elif not v.findings and v.verdict == NOTHING:
        nothing = "Nothing else that these data can show" if goes_on_from_day_to_day(v) else "Nothing that these data can show"
        nothing = "Nothing that could be named for sure" if v.unsettled else nothing
        yield Wrong("", f"{nothing}. What was ruled out, and what could not be tested, is listed below.")
    elif not v.findings:
        yield Wrong("", "No departure from the model could be named with confidence.")
    if most := most_left(v):
        yield Wrong("", sentence(most))
    if changes := goes_on_from_day_to_day(v):
        yield Wrong("From session to session", changes)
    yield from (Wrong("Not settled", sentence(said)) for said in _unsettled(v))


def _as_well(f: Finding) -> Iterator[str]:
    """Sentences on how well the rivals fit: those that are equal, those that explain less, and how many are only on the card."""
    behind = {cause_at(cause, where): b for (cause, where, _), b in zip(f.alternatives, f.behind, strict=True)}
    equal = [name for name, b in behind.items() if b is None]
    less = sorted((b, name) for name, b in behind.items() if b is not None)
    if equal:
        yield f"{_which(equal, behind)} fit{'s' * (len(equal) == 1)} these data almost as well."
    if less:
        by = " to ".join(dict.fromkeys(percent(b) for b, _ in (less[0], less[-1])))
        one = f"{_which([name for _, name in less], behind)} explain{'s' * (len(less) == 1)}"
        yield f"{one} {by} less of the mismatch: more than chance, but too little to rule out a cause, because no model is exact."
    if len(f.alternatives) > MOST_NAMES:
        yield f"{len(f.alternatives) - MOST_NAMES} more names are on its card below."


def _which(names: list[str], of: Collection[str]) -> str:
    """Some of the other names, as the beginning of a sentence: listed, unless they are all of them."""
    if len(names) == len(of):
        return "The other name" if len(of) == 1 else "The other names"
    return capital(listed(names)) if len(names) <= MOST_NAMES else f"{len(names)} of the other names"


def _unsettled(v: View) -> Iterator[str]:
    """Sentences on causes that are in doubt, and the common reason of causes that are left open."""
    yield from (f"{named_at(e)}: {with_spoken_taxels(text(e.get('because')))}" for e in v.doubts)
    yield from dict.fromkeys(with_spoken_taxels(text(e.get("because"))) for e in v.left_open)


def _in_newtons(seen: Focus, v: View) -> str:
    change = (seen.trace.extended[seen.row] - seen.trace.baseline[seen.row])[seen.trace.compared]
    peak = float(np.nanmax(np.abs(change), initial=0.0))
    top = float(np.nanmax(np.abs(seen.trace.measured[seen.row]), initial=0.0))
    unit, name, like = unit_of(v, seen.channel), signal(seen.channel), v.loudest or [rms(change)]
    adding = "Adding it changes" if len(v.findings) == 1 else "Adding them changes"
    adding = "Correcting them changes" if all(f.cause == "parameters" for f in v.findings) else adding
    return (
        f"{adding} the simulated {name} by up to {amount(peak, unit, like=like)}, typically {amount(rms(change), unit, like=like)}, "
        f"where the measurement reaches {amount(top, unit)}."
    )


def _why(v: View, seen: Focus | None, rounds: tuple[Round, ...]) -> Iterator[str]:
    yield from (s for s in (_against_rivals(f, rounds) for f in v.findings[:2]) if s)
    if len(v.findings) > 2:
        more = len(v.findings) - 2
        yield "The other was accepted in the same way." if more == 1 else f"The other {more} were accepted in the same way, one by one."
    if v.findings and ((v.judged and (seen is None or seen.changes)) or (seen is not None and seen.beside)):
        yield from _in_the_picture(seen, v) if seen is not None else ("The picture shows what the model misses without it, and with it.",)
    if v.findings:
        return
    tested = {c for r in rounds for c, _, _ in r.ranked} | {text(e.get("cause")) for e in v.excluded}
    if tested and v.verdict == NOTHING:
        better_than = "surely better than the model does alone" if v.unsettled else "better than the model does alone"
        yield f"{len(tested)} causes were tried on these data, and none predicts the measurement {better_than}."
    elif tested:
        yield f"{len(tested)} causes were tried on these data, and none predicts sessions that were not used for fitting reliably better."


def _stray(seen: Focus, v: View) -> str:
    """A sentence on how large the unexplained error is."""
    left = smooth(seen.trace.t, residuals(seen.trace, seen.row)[1], v.band_hz)[seen.trace.compared]
    unit, worst = unit_of(v, seen.channel), float(np.nanmax(np.abs(left), initial=0.0))
    like = v.loudest or [worst]
    return (
        f"The simulated {signal(seen.channel)} differs from the measured one by up to {amount(worst, unit, like=like)}, typically "
        f"{amount(rms(left), unit, like=like)}, in a pattern that noise does not produce."
    )


def _in_the_picture(seen: Focus, v: View) -> Iterator[str]:
    """A sentence on the largest error in the picture without and with the named causes, where it clearly falls."""
    looked_at = seen.trace.compared | seen.beside
    cut = np.flatnonzero(looked_at[seen.start : seen.stop]) + seen.start
    cut = cut if cut.size else np.arange(seen.start, seen.stop)
    worst = [float(np.nanpercentile(np.abs(smooth(seen.trace.t, r, v.band_hz)[cut]), 99.0)) for r in residuals(seen.trace, seen.row)]
    if worst[1] > CLEARLY * worst[0]:
        return
    unit, like = unit_of(v, seen.channel), v.loudest or worst
    few = "this cause" if len(v.findings) == 1 else "these causes"
    beside = ", in samples that were not compared" if seen.beside else ""
    yield (
        f"The picture: without {few} the simulated {signal(seen.channel)} differs from the measured one by up to "
        f"{amount(worst[0], unit, like=like)}, with {few} by up to {amount(worst[1], unit, like=like)}{beside}."
    )


def named_cause(named: str) -> str:
    """The cause in the text that a round has for what it named: `hysteresis` in `hysteresis skin`."""
    return named.split(" ")[0].split(".")[0]


def explaining(round_: Round, most: int) -> list[tuple[str, str, float]]:
    """Cause, place and gain of the causes that explain anything in a round, the best first, at most `most`."""
    least = ROUNDING * max((gain for _, _, gain in round_.ranked), default=0.0)
    return sorted((r for r in round_.ranked if r[2] > max(least, 0.0)), key=lambda r: -r[2])[:most]


def _against_rivals(f: Finding, rounds: tuple[Round, ...]) -> str:
    """Why this cause and no other: the finding's own sentence, or how far ahead it was, when it was named, of the best cause that is not
    listed as its rival."""
    if f.why:
        return sentence(f.why)
    ranked = next((r.ranked for r in rounds if r.named and named_cause(r.named) == f.cause), ())
    names = {(cause, word_of(where)) for cause, where in f.names}
    own = max((g for c, w, g in ranked if (c, word_of(w)) == (f.cause, word_of(f.where))), default=None)
    rival = max((r for r in ranked if (r[0], word_of(r[1])) not in names and r[2] > 0.0), key=lambda r: r[2], default=None)
    if own is None:
        return ""
    name, others = capital(cause_at(f.cause, f.where)), " but those named beside it" if len(names) > 1 else ""
    if rival is None:
        return f"{name} explains the mismatch, and no other cause{others} explains any of it."
    next_ = f"the best cause that is not named beside it, {cause_at(rival[0], rival[1])}"
    next_ = next_ if others else f"the next best, {cause_at(rival[0], rival[1])}"
    if (ratio := own / rival[2]) >= 1.1:
        return f"{name} explains {plain(ratio, 2)} times as much of the mismatch as {next_}."
    return f"{name} explained about as much at first as {next_}, and more when all had been fitted in full."
