"""How sure the result is, whether a sensor must be rebuilt, and what to do next: what the reader needs for a decision."""

from collections.abc import Iterator

from skin_ident.criticism.vocabulary import BY_NAME, cause_at
from skin_ident.report.numbers import percent
from skin_ident.report.ruled_out import weakly
from skin_ident.report.tolerant import named_at, text
from skin_ident.report.view import EXPLAINED, HELD_OUT, IN_TURN, NOTHING, PARTLY, STRETCHES, UNEXPLAINED, UNTESTED, Finding, View
from skin_ident.report.words import Rebuild, advice, capital, either, hardware, rebuild, sentence
from skin_models.words import counted

TESTED = {
    HELD_OUT: "data not used for fitting",
    STRETCHES: "stretches of the session not used for fitting",
    IN_TURN: "sessions held out in turn",
    UNTESTED: "the data it was fitted to",
}
NOT_PROVEN, NEITHER = "Not proven", "Sure neither of the gain nor of the name"
MOST_ADVICE = 4  # pieces of advice on the first screen
GAIN = "gain_error"
LATER, BY_HAND = "not before the next experiment", "not before a check by hand"


def sure(v: View) -> tuple[str, tuple[str, ...]]:
    """How sure the result is, in a few words, and the reasons."""
    rivals = sum(bool(f.alternatives) for f in v.findings)
    because = [*_on_held_out(v)]
    if rivals and len(v.findings) > 1:
        because.append(f"{rivals} of the {len(v.findings)} named causes cannot be distinguished from a rival with these data.")
    elif rivals:
        because.append(f"These data cannot tell it from the other name{'s' * (len(v.findings[0].alternatives) > 1)}.")
    because += _of_the_drive(v)
    if v.verdict in (PARTLY, UNEXPLAINED) and v.rest and v.rest > 0.0:
        because.append(f"Of the mean square of the remaining error, {percent(v.rest)} still follows a pattern: it is not only noise.")
    if untested := {text(e.get("cause")) for e in v.untestable if e not in (*v.doubts, *v.left_open)}:
        because.append(f"{counted(len(untested), 'cause')} could not be tested with these data.")
    if weak := {text(e.get("cause")) for e in weakly(v)}:
        because.append(f"{counted(len(weak), 'cause')} could be ruled out only weakly.")
    return _grade(v, rivals > 0), tuple(because)


def unsure(v: View) -> str:
    """The caveat of a headline that names something, where the gain is not significant or was never tested; else empty."""
    graded = _grade(v, any(f.alternatives for f in v.findings)) if v.judged else ""
    return {NEITHER: "not surely", NOT_PROVEN: "not proven"}.get(graded, "")


def _of_the_drive(v: View) -> Iterator[str]:
    """A sentence saying that the load cell itself may be wrong, where its force drives the simulation, so that it has no residual."""
    driven = bool(v.errors) and not v.is_scan and all(e.channel != "force" for e in v.errors)
    if driven and any(where == "load_cell" for f in v.findings for _, where in f.names):
        yield "No depth was recorded, so the force of the load cell drives the simulation: the load cell itself may be what is wrong."


def _clear(v: View) -> int:
    return sum(f.gain.low is not None and f.gain.low > 0 for f in v.judged)


def _grade(v: View, rivals: bool) -> str:
    if v.findings and not v.judged and v.verdict == EXPLAINED:
        return "Seen directly in the record"
    if v.tested == UNTESTED:
        return NOT_PROVEN
    if v.verdict == NOTHING:
        if v.doubts:
            return f"Fairly sure: {counted(len(v.doubts), 'cause')} in doubt"
        if v.left_open:
            return f"Fairly sure: {counted(len(v.left_open), 'cause')} left open"
        return "Sure, for what could be tested" if v.above is None else "Fairly sure: the remaining error is a little above the noise"
    if v.verdict == UNEXPLAINED or not v.findings:
        return "Sure that something is wrong, but not of its cause"
    if rivals:
        return "Sure of the gain, not of the name" if _clear(v) == len(v.judged) else NEITHER
    if _clear(v) < len(v.judged) or v.tested == STRETCHES:
        return "Fairly sure"
    return "Sure" if v.verdict == EXPLAINED else "Sure of what is named; something else is unexplained"


def _on_held_out(v: View) -> Iterator[str]:
    if direct := len(v.findings) - len(v.judged):
        yield f"{counted(direct, 'finding')} can be seen in the record itself, whatever the model."
    if v.tested == UNTESTED and v.judged:
        yield "There was no second session to test it on: the model was judged on the data it was fitted to."
    elif not v.findings and v.tested != UNTESTED:
        yield f"Checked on {TESTED[v.tested]}."
    elif v.judged and _clear(v) == len(v.judged):
        yield f"The prediction of {TESTED[v.tested]} improves beyond chance (the 95 % interval excludes zero)."
    elif len(v.judged) == 1:
        yield f"The prediction of {TESTED[v.tested]} improves, but the 95 % interval of the fall of the RMS error includes zero."
    elif v.judged:
        yield f"{_clear(v)} of {counted(len(v.judged), 'finding')} improve the prediction of {TESTED[v.tested]} beyond chance."
    if v.tested == STRETCHES:
        yield "There is only one session: a second one would be a stricter test."


def rebuild_answer(v: View) -> tuple[str, str]:
    """Whether a sensor must be rebuilt: the most serious answer among the findings, and a reason that follows "because"."""
    if not v.findings and v.verdict == NOTHING and not v.unsettled:
        return "No", f"nothing in these data indicates a fault of the sensor{_but_a_gain(v)}"
    if not v.findings:
        open_ = "what is not settled may be an error of the declared layout" if v.left_open else "no cause could be named"
        return "Not on this evidence", "what is in doubt is not confirmed" if v.doubts else open_
    answers = [_of_all_names(f) for f in v.findings]
    for grave in ("yes", "perhaps", "cannot say", BY_HAND, LATER):
        for a in answers:
            if a.answer == grave:
                return capital(grave), a.because
    reasons, checks = dict.fromkeys(a.because for a in answers), dict.fromkeys(c for a in answers for c in a.checks)
    return _no(v, answers), ". ".join(["; ".join(reasons), *checks]) + _but_a_gain(v)


def _no(v: View, answers: list[Rebuild]) -> str:
    """The "no" of several findings, with the hardware besides the taxels that may be at fault instead."""
    but = list(dict.fromkeys(b for a in answers for b in a.but))
    sensor = "taxel" if any(where == "load_cell" for f in v.findings for _, where in f.names) else "sensor"
    return f"No {sensor}, but perhaps {either(but)}" if but else "No"


def _but_a_gain(v: View) -> str:
    """The caveat of a "no" where a gain error could not be tested: a constant error of gain looks like another stiffness of the skin."""
    return ". Not testable with these data: a constant gain error of a sensor" if any(e.get("cause") == GAIN for e in v.untestable) else ""


def _of_all_names(f: Finding) -> Rebuild:
    """The answer that holds for a finding whichever of its names is the true one, with a reason that they share."""
    each = [rebuild(cause, where) for cause, where in f.names]
    answers, reasons = {a.answer for a in each}, {a.because for a in each}
    later = BY_HAND if f.by_hand else LATER
    if len(reasons) == 1:
        return _no_taxel(f, each[0].because) if len(each) > 1 and answers == {"no"} else each[0]
    if answers == {"no"} and not any(where.startswith("taxel") for _, where in f.names):
        return _no_taxel(f, "none of the names that are left is a fault of a taxel")
    if answers == {"no"}:
        return _no_taxel(f, "none of the names that are left requires a new taxel; at most its calibration, zero or wiring is wrong")
    if answers <= {"yes", "perhaps"}:
        return Rebuild("perhaps", "every name that is left is a fault of a sensor, but not every one requires a new sensor")
    if answers == {"no", "cannot say"}:
        return Rebuild(later, "one of the names that are left is a wrong record, which says nothing about a sensor")
    return Rebuild(later, "of the names that are left, one is a fault of a sensor, and another does not concern a sensor")


def _no_taxel(f: Finding, because: str) -> Rebuild:
    """The "no" of a finding of which no name requires a new taxel, with how to check the other hardware that its names concern."""
    needs: dict[str, list[str]] = {}
    for cause, where in f.names:
        if (part := hardware(cause, where)) and cause in BY_NAME:
            needs.setdefault(part, []).append(BY_NAME[cause].needs)
    checks = [f"To check {part}: {'; and '.join(dict.fromkeys(each))}" for part, each in needs.items()]
    return Rebuild("no", because, tuple(needs), tuple(checks))


def next_steps(v: View, folder: str = "") -> Iterator[str]:
    """Sentences on what to do, the most urgent first. `folder` holds the model and the batteries where they are not beside the report."""
    for f in v.findings:
        if f.battery:
            yield sentence(f.separating.replace(f.battery, f"{folder}/{f.battery}" if folder else f.battery, 1))
        elif f.by_hand:
            yield from _by_hand(f)
        elif f.separating:
            yield sentence(f"{_between(f)}: {f.separating}")
    yield from _advice(v)
    if any(f.carried for f in v.findings):
        lies = f"in {folder}" if folder else "beside this report"
        as_some = ", for all sessions: remove a cause to simulate sessions without it" * any(f.partly for f in v.findings)
        first = ", of several names for one thing the first" * any(f.alternatives for f in v.findings)
        yield f"Load model.yaml, {lies}, into the simulated skin: {_carried(v)} named here is in it{first}{as_some}."
    if v.verdict in (PARTLY, UNEXPLAINED):
        yield "See below how the remaining error depends on depth, speed and frequency, and record what the untested causes need."
    for needs in dict.fromkeys(text(e.get("needs")) for e in v.doubts):
        names = [named_at(e) for e in v.doubts if text(e.get("needs")) == needs]
        yield sentence(f"To settle {' and '.join(names)}: record {needs}")
    for needs in dict.fromkeys(text(e.get("needs")) for e in v.left_open):
        yield sentence(f"To settle whether it is {either([named_at(e) for e in v.left_open if text(e.get('needs')) == needs])}: {needs}")
    if v.errors and v.tested in (UNTESTED, STRETCHES):
        yield "Record a second session and give it with --hold-out: it takes minutes, and the result is then tested on independent data."
    if v.verdict == NOTHING:
        keep = "Until then keep the model." if v.unsettled else "Keep the model."
        yield keep + (" If you suspect one of the untested causes, record what its row below asks for." if v.untestable else "")


def _by_hand(f: Finding) -> Iterator[str]:
    """Advice where no motion tells the names of a finding apart: what to do about each of them, one at a time."""
    yield sentence(f"{_between(f)}: {f.separating}")
    each = [(cause_at(*name), f.act if name == f.names[0] else advice(name[0])) for name in f.names]
    yield from (sentence(f"If it is {name}: {act}") for name, act in each if act)
    yield "Do only one of these at a time and record again: the one that removes the mismatch was the cause."


def _between(f: Finding) -> str:
    return f"To tell {cause_at(f.cause, f.where)} from {_rivals(f)}"


def _carried(v: View) -> str:
    """How much of what is named is in the model. Some findings of a scan cannot be simulated, so a finding of a scan counts only if it says
    that it is in the model."""
    own = any(dict(f.evidence).get("of_each_session") for f in v.findings)  # per-session values cannot be simulated in advance
    whole = not own and all(f.carried and (f.says_whether_simulated or not v.is_scan) for f in v.findings)
    return "everything" if whole else "what can be simulated of what is"


def _advice(v: View) -> Iterator[str]:
    """Advice on each finding without a rival, what concerns hardware first. More than MOST_ADVICE are left to the cards below."""
    order = ["yes", "perhaps", "cannot say", "no"]
    clear = [f for f in v.findings if f.act and not f.alternatives]
    ranked = sorted(clear, key=lambda f: (order.index(rebuild(f.cause, f.where).answer), f.where == "skin"))
    yield from dict.fromkeys(sentence(f"{f.lies}: {f.act}") for f in ranked[:MOST_ADVICE])
    if len(ranked) > MOST_ADVICE:
        yield f"For the other {len(ranked) - MOST_ADVICE}, see the cards under Evidence."


def _rivals(f: Finding) -> str:
    return either([cause_at(*name) for name in f.names[1:]]) if f.alternatives else "its rivals"
