"""The first screen in plain words: what is wrong, why we think so, how much better the model is, how sure we are, what to do next."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.outcome import Outcome, Round
from skin_ident.report.focus import Focus, focus, rms
from skin_ident.report.numbers import amount, percent, plain, span
from skin_ident.report.view import Amount, ChannelError, Finding, View, view
from skin_ident.report.words import advice, capital, cause_at, channel, meaning, place, rebuild, sentence, spoken

NOTHING, EXPLAINED, PARTLY, UNEXPLAINED = "nothing_wrong", "explained", "partly_explained", "unexplained"
MOST_AMOUNTS = 4


@dataclass(frozen=True)
class Headline:
    """The verdict: `tone` picks the colour of the banner (good, found, part, bad)."""

    tone: str
    title: str
    line: str


@dataclass(frozen=True)
class Figure:
    """How much better the model is: a number that stands out, and the sentences that hold it."""

    number: str
    caption: str
    sentences: tuple[str, ...]


@dataclass(frozen=True)
class Story:
    """Everything the first screen says. Lists hold sentences."""

    headline: Headline
    wrong: tuple[str, ...]
    why: tuple[str, ...]
    better: Figure
    sure: str
    sure_because: tuple[str, ...]
    rebuild: str
    rebuild_because: str
    next: tuple[str, ...]


def story(outcome: Outcome, v: View | None = None) -> Story:
    """Tell an outcome."""
    v = v or view(outcome.findings)
    seen = focus(outcome.traces, v)
    sure, because = _sure(v)
    answer, reason = _rebuild(v)
    return Story(
        _headline(v), tuple(_wrong(v, seen)), tuple(_why(v, outcome.rounds)), _better(v), sure, because, answer, reason, tuple(_next(v))
    )


def _headline(v: View) -> Headline:
    names = _names(v)
    if v.verdict == NOTHING:
        return Headline("good", "Nothing wrong found", "The simulation matches these measurements down to their noise.")
    if v.verdict == EXPLAINED:
        return Headline("found", f"Explained: {names}", "With this in the model, what is left of the mismatch looks like noise.")
    if v.verdict == PARTLY:
        return Headline("part", f"Partly explained: {names}", "The extended model is better, but what is left is not yet noise.")
    if v.verdict == UNEXPLAINED:
        title = f"Not explained, despite {names}" if v.findings else "Not explained"
        return Headline("bad", title, "The simulation is measurably wrong, and no cause that we know describes how.")
    return Headline("part", capital(spoken(v.verdict)), "This report does not know the verdict; see the findings below.")


def _names(v: View) -> str:
    said = [cause_at(f.cause, f.where) for f in v.findings]
    if not said:
        return "no single cause"
    return said[0] if len(said) == 1 else f"{said[0]}, and {len(said) - 1} more" if len(said) > 2 else " and ".join(said)


def _wrong(v: View, seen: Focus | None) -> Iterator[str]:
    """One sentence for each finding, then what they amount to in newtons."""
    for f in v.findings:
        sizes = amounts_line(f.amounts)
        rivals = "".join(f", or {cause_at(c, w)}" for c, w, _ in f.alternatives)
        means = f" – {meaning(f.cause)}" if meaning(f.cause) else ""
        yield sentence(f"{cause_at(f.cause, f.where)}{rivals}{means}" + (f": {sizes}" if sizes else ""))
    if not v.findings:
        yield (
            "No departure from the model could be named with confidence."
            if v.verdict != NOTHING
            else ("Nothing that these data can show. The causes that were ruled out, and those that could not be tested, are listed below.")
        )
    elif seen is not None:
        yield _in_newtons(seen, v)


def amounts_line(amounts: tuple[Amount, ...]) -> str:
    """Sizes in words: `relaxation time 0.800 s, …`; parameters that are zero are left out."""
    shown = [a for a in amounts if a.value]
    more = f", and {len(shown) - MOST_AMOUNTS} more" if len(shown) > MOST_AMOUNTS else ""
    return ", ".join(f"{a.words} {amount(a.value, a.unit, a.std)}" for a in shown[:MOST_AMOUNTS]) + more


def _in_newtons(seen: Focus, v: View) -> str:
    change = seen.trace.extended[seen.row] - seen.trace.baseline[seen.row]
    peak = float(np.nanmax(np.abs(change), initial=0.0))
    top = float(np.nanmax(np.abs(seen.trace.measured[seen.row]), initial=0.0))
    unit = unit_of(v, seen.channel)
    return (
        f"The correction moves the simulated {channel(seen.channel)} by up to {amount(peak, unit)} (typically {amount(rms(change), unit)}) "
        f"where the measurement reaches {amount(top, unit)}."
    )


def unit_of(v: View, name: str) -> str:
    """The unit of a channel."""
    return next((e.unit for e in v.errors if e.channel == name), "N")


def _why(v: View, rounds: tuple[Round, ...]) -> Iterator[str]:
    yield from (s for s in (_against_rivals(f, rounds) for f in v.findings[:2]) if s)
    if len(v.findings) > 2:
        yield f"The other {len(v.findings) - 2} were accepted in the same way, one after the other."
    if v.findings:
        yield "The picture shows it: the gap between measured and simulated that the old model leaves, and what the new one leaves."
        return
    tested = {c for r in rounds for c, _, _ in r.ranked}
    if tested and v.verdict == NOTHING:
        yield f"{len(tested)} causes were tried on these data, and none predicts the measurement better than the model does alone."
    elif tested:
        yield f"{len(tested)} causes were tried on these data, and none predicts sessions that were not used for fitting reliably better."


def _against_rivals(f: Finding, rounds: tuple[Round, ...]) -> str:
    """How far ahead of the next cause it was when it was named."""
    ranked = next((r.ranked for r in rounds if r.named and r.named.split(" ")[0].split(".")[0] == f.cause), ())
    own = next((g for c, w, g in ranked if (c, w) == (f.cause, f.where)), None)
    rival = next(((c, w, g) for c, w, g in ranked if c != f.cause and g > 0), None)
    if own is None:
        return ""
    name = capital(cause_at(f.cause, f.where))
    if rival is None:
        return f"{name} is the only cause that explains any of the mismatch."
    ratio = own / rival[2]
    if ratio >= 1.1:
        return f"{name} explains {plain(ratio, 2)} times as much of the mismatch as the next best, {cause_at(rival[0], rival[1])}."
    return (
        f"{name} and {cause_at(rival[0], rival[1])} explain about as much; {spoken(f.cause)} was kept after both had been fitted in full."
    )


def _better(v: View) -> Figure:
    told = [e for e in v.errors if None not in e.pair and e.pair[0]]
    named = [f.gain.channel for f in v.findings]
    if not told:
        return Figure("–", "no error known", ())
    if not v.findings:
        return Figure("0" + "\u00a0%", "nothing to gain", tuple(_floor_line(e) for e in told[:3]))
    best = next((e for e in told if named and e.channel == named[0]), None) or max(told, key=fall)
    return _gain_figure(best, v)


def _gain_figure(e: ChannelError, v: View) -> Figure:
    before, after = e.pair
    tested = "held-out" if e.pair == e.held_out else "training"
    caption = f"{'less' if fall(e) >= 0 else 'more'} error in {channel(e.channel)}, on {'data not used for fitting' if tested == 'held-out' else 'the data it was fitted to'}"
    said = [f"Typical error: {amount(before, e.unit, like=e.pair)} before, {amount(after, e.unit, like=e.pair)} after."]
    interval = _interval(v, e)
    said += [interval] if interval else []
    said.append(_floor_line(e))
    return Figure(percent(abs(fall(e))), caption, tuple(s for s in said if s))


def _interval(v: View, e: ChannelError) -> str:
    gains = [f.gain for f in v.findings if f.gain.channel == e.channel and f.gain.low is not None and f.gain.high is not None]
    if not gains:
        return ""
    if len(v.findings) == 1:
        return f"The fall is {span(gains[0].low, gains[0].high, gains[0].unit)} with 95 % confidence."
    return f"The first step's share of the fall is {span(gains[0].low, gains[0].high, gains[0].unit)} with 95 % confidence."


def fall(e: ChannelError) -> float:
    """Relative fall of a channel's error, on held-out data where it is known."""
    before, after = e.pair
    return 1.0 - after / before if before and after is not None else 0.0


def _floor_line(e: ChannelError) -> str:
    if e.floor is None:
        return ""
    after = e.pair[1] if e.pair[1] is not None else e.pair[0]
    near = after is not None and after < 1.15 * e.floor
    return f"Noise alone leaves {amount(e.floor, e.unit)} in {channel(e.channel)}" + (
        ": there is nothing more to gain." if near else "; no model can do better than that."
    )


def _sure(v: View) -> tuple[str, tuple[str, ...]]:
    """How sure, in a word or two, and why."""
    tested = any(e.held_out[0] is not None for e in v.errors)
    clear = [f for f in v.findings if f.gain.low is not None and f.gain.low > 0]
    rivals = [f for f in v.findings if f.alternatives]
    because = [_on_held_out(v, tested, len(clear))]
    if rivals:
        because.append(f"{len(rivals)} of the {len(v.findings)} named causes cannot be told from a rival on these data." if len(v.findings) > 1
                       else "These data cannot tell it from the rival named beside it.")  # fmt: skip
    if v.verdict in (PARTLY, UNEXPLAINED):
        because.append("Something is left that is not noise.")
    if v.untestable:
        because.append(f"{len(v.untestable)} causes could not be tested, because nothing in these data excites them.")
    return _grade(v, tested, bool(rivals), len(clear)), tuple(b for b in because if b)


def _grade(v: View, tested: bool, rivals: bool, clear: int) -> str:
    if not tested:
        return "Not proven"
    if v.verdict == NOTHING:
        return "Sure, for what could be tested"
    if v.verdict == UNEXPLAINED or not v.findings:
        return "Sure that something is wrong, not what"
    if rivals:
        return "Sure of the gain, not of the name"
    if clear < len(v.findings):
        return "Fairly sure"
    return "Sure" if v.verdict == EXPLAINED else "Sure of what is named; more is left"


def _on_held_out(v: View, tested: bool, clear: int) -> str:
    if not tested:
        return "There was no second session to test it on: the model was judged on the data it was fitted to. Record one more."
    if not v.findings:
        return "Checked on a session that was not used for fitting."
    if clear == len(v.findings):
        return (
            "A session that was not used for fitting is predicted better, and chance does not explain it (the 95 % interval excludes zero)."
        )
    return f"{clear} of {len(v.findings)} findings improve the prediction of unused data beyond chance (95 % interval)."


def _rebuild(v: View) -> tuple[str, str]:
    """Must a sensor be rebuilt? The gravest answer among the findings."""
    if not v.findings:
        return (
            ("No", "nothing in these data speaks against the sensor")
            if v.verdict == NOTHING
            else ("Not on this evidence", "no cause could be named")
        )
    answers = [rebuild(f.cause, f.where) for f in v.findings]
    for grave in ("yes", "perhaps", "cannot say"):
        for a in answers:
            if a.answer == grave:
                return capital(grave), a.because
    if any(rebuild(c, w).answer != "no" for f in v.findings for c, w, _ in f.alternatives):
        return "Not before the next experiment", "one of the rival names would put the fault in the sensor"
    return "No", "; ".join(dict.fromkeys(a.because for a in answers))


def _next(v: View) -> Iterator[str]:
    for f in v.findings:
        if f.separating:
            yield sentence(f"To tell {cause_at(f.cause, f.where)} from {_either(f)}, run: {f.separating}")
    for f in v.findings:
        if advice(f.cause) and not f.alternatives:
            yield sentence(f"{place(f.where)}: {advice(f.cause)}")
    if v.findings:
        yield "Use model.yaml, beside this report: the simulated skin loads it, with everything named here in it."
    if v.verdict in (PARTLY, UNEXPLAINED):
        yield "See which way the remaining error leans (below: against time, depth, speed, frequency), and record what the table of untested causes asks for."
    if not any(e.held_out[0] is not None for e in v.errors) and v.errors:
        yield "Record a second session and give it with --hold-out: it costs minutes, and turns a guess into a test."
    if v.verdict == NOTHING and v.untestable:
        yield "If you doubt one of the untested causes, record what its row asks for."


def _either(f: Finding) -> str:
    return " or ".join(cause_at(c, w) for c, w, _ in f.alternatives) or "its rivals"
