"""The sections below the first screen."""

import numpy as np

from skin_ident.criticism.outcome import Outcome, Trace
from skin_ident.report.bars import error_table, parameter_table, ranking
from skin_ident.report.charts import against_frequency, against_motion, key, key_left, overlay, scan_left, scan_panels
from skin_ident.report.focus import Focus, by_fall
from skin_ident.report.markup import Safe, el, join, table
from skin_ident.report.numbers import amount, plain, span
from skin_ident.report.story import amounts_line, unit_of
from skin_ident.report.view import Finding, View, mapping, text
from skin_ident.report.words import advice, capital, cause_at, channel, meaning, sentence, short, spoken

MOST_SESSIONS = 6
MOST_CHANNELS = 4
MOST_POINTS = 160_000  # points in all charts together: about 1 MB of text


def section(identity: str, title: str, *content) -> Safe:
    """One section with an anchor."""
    return el("section", el("h2", title), content, id=identity)


def measured(outcome: Outcome, v: View, seen: Focus | None) -> Safe | None:
    """Measured against simulated: the errors of every channel, then whole sessions."""
    table_ = [el("p", _error_note(v), class_="note"), error_table(v.errors)] if v.errors else []
    if seen is None and not outcome.scans:
        return section("measured", "Measured against simulated", table_) if table_ else None
    return section(
        "measured",
        "Measured against simulated",
        table_,
        key(seen.trace if seen else outcome.scans[0]),
        _sessions(outcome, v, seen),
        _scans(outcome),
    )


def _error_note(v: View) -> str:
    held = any(None not in e.held_out for e in v.errors)
    where = "data that were not used for fitting" if held else "the same data that the model was fitted to: no second session was given"
    return f"Typical error (root mean square of measured minus simulated) on {where}. The tick on the bars is what noise alone leaves."


def _sessions(outcome: Outcome, v: View, seen: Focus | None) -> list[Safe]:
    if seen is None:
        return []
    ordered = [seen.trace, *(t for t in sorted(outcome.traces, key=lambda t: not t.held_out) if t is not seen.trace and t.t.size > 1)]
    shown = ordered[:MOST_SESSIONS]
    charts = sum(min(len(t.channels), MOST_CHANNELS) for t in shown)
    buckets = int(np.clip(MOST_POINTS / (10 * max(charts, 1)), 250, 1500))
    blocks = [_session(t, v, buckets, i == 0) for i, t in enumerate(shown)]
    left = len(ordered) - len(shown)
    return [*blocks, el("p", f"{left} more sessions are in traces.npz.", class_="note")] if left else blocks


def _session(trace: Trace, v: View, buckets: int, is_open: bool) -> Safe:
    rows = by_fall(trace)[:MOST_CHANNELS]
    role = "not used for fitting" if trace.held_out else "used for fitting"
    head = el("summary", el("b", short(trace.session, 72), title=trace.session), f" – {role}, {plain(trace.t[-1] - trace.t[0])} s")
    charts = [
        el("h4", capital(channel(trace.channels[r]))) + overlay(trace, r, unit_of(v, trace.channels[r]), slice(None), buckets) for r in rows
    ]
    hidden = len(trace.channels) - len(rows)
    note = (
        el("p", f"{hidden} more channels, which gained less, are in the table above and in traces.npz.", class_="note") if hidden else None
    )
    return el("details", head, [Safe(c) for c in charts], note, open=is_open, class_="session")


def _scans(outcome: Outcome) -> list[Safe]:
    return [el("div", el("h4", s.session), el("div", scan_panels(s), class_="grid"), class_="scan") for s in outcome.scans]


def left(outcome: Outcome, v: View, seen: Focus | None) -> Safe | None:
    """What is left: against depth, speed and frequency (time is above)."""
    blocks = []
    if seen is not None:
        for row in by_fall(seen.trace)[:3]:
            unit = unit_of(v, seen.trace.channels[row])
            panels = [p for p in (*against_motion(seen.trace, row, unit), against_frequency(seen.trace, row, unit)) if p]
            blocks.append(el("h4", capital(channel(seen.trace.channels[row]))))
            blocks.append(el("div", panels, class_="grid"))
    blocks += [el("div", el("h4", s.session), el("div", scan_left(s), class_="grid")) for s in outcome.scans]
    if not blocks:
        return None
    note = (
        "What the simulation misses. A model that lacks nothing leaves flat lines around zero, and the same noise at every frequency; "
        "a lean, a step or a hump says when the model fails."
    )
    if seen is not None:
        note += f" Medians, with the middle 80 % of the samples shaded against speed; session {short(seen.trace.session)}."
    title = "What is left: against depth, speed and frequency" if seen is not None else "What is left"
    return section("left", title, el("p", note, class_="note"), key_left(seen.trace if seen else outcome.scans[0]), blocks)


def evidence(outcome: Outcome, v: View) -> Safe | None:
    """Each finding on a card, then the ranking of every round."""
    cards = [_card(f, i + 1) for i, f in enumerate(v.findings)]
    rounds = [ranking(r, i + 1) for i, r in enumerate(outcome.rounds)]
    if not cards and not rounds:
        return None
    note = (
        "The longer the bar, the more of the mismatch that cause alone would explain (fall of the squared error, counted in units of the noise). "
        "The model's own parameters were free to explain it first. The blue bar was named; a name also had to predict unused data better."
    )
    ranks = [el("h3", "How the causes compare"), el("p", note, class_="note"), el("div", rounds, class_="grid wide")] if rounds else None
    return section("evidence", "The evidence", el("div", cards, class_="cards"), ranks)


def _card(f: Finding, number: int) -> Safe:
    rows = [
        ("What it means", sentence(meaning(f.cause))),
        ("Seen in", ", ".join(channel(c) for c in f.channels)),
        ("Size", el("div", [el("div", line) for line in amounts_line(f.amounts, 12).split("; ")])),
    ]
    g = f.gain
    if g.before is not None and g.after is not None:
        rows.append(
            (
                "Error on unused data",
                f"{amount(g.before, g.unit, like=[g.before, g.after])} → {amount(g.after, g.unit, like=[g.before, g.after])}",
            )
        )
    if g.low is not None and g.high is not None:
        rows.append(("Fall, 95 % interval", span(g.low, g.high, g.unit)))
    if g.held_out:
        rows.append(("Tested on", g.held_out))
    rows += [(capital(spoken(k)), text(value)) for k, value in f.evidence]
    rows += [("Could also be", join([cause_at(c, w), f" ({why})" if why else ""])) for c, w, why in f.alternatives]
    rows += [("Would tell them apart", sentence(f.separating))] if f.separating else []
    rows += [("What to do", sentence(advice(f.cause)))] if advice(f.cause) else []
    entries = [[el("dt", k), el("dd", value)] for k, value in rows if value]
    return el("article", el("h3", f"{number}. {capital(cause_at(f.cause, f.where))}"), el("dl", entries), class_="card")


def parameters(v: View) -> Safe | None:
    """Before and after."""
    if not v.before and not v.after:
        return None
    note = (
        "When an effect is missing, the fit bends the other parameters to make up for it. Those that moved by more than three standard errors "
        "(and 5 %) are where it was hiding: their old values were wrong."
    )
    return section("parameters", "Parameters before and after", el("p", note, class_="note"), parameter_table(v))


def excluded(v: View) -> Safe | None:
    """Causes that would have been seen."""
    if not v.excluded:
        return None
    rows = [[capital(cause_at(text(e.get("cause")), text(e.get("where")))), amount(e.get("below"), text(e.get("unit"))), sentence(meaning(text(e.get("cause"))))]
            for e in v.excluded]  # fmt: skip
    note = "These were tested and not found. If one were there above the size given, these data would have shown it."
    return section(
        "excluded", "Ruled out", el("p", note, class_="note"), table(["cause", "smaller than", "what it would mean"], rows, (1,), "plain")
    )


def untestable(v: View) -> Safe | None:
    """Causes that these data could not show."""
    if not v.untestable:
        return None
    rows = [
        [capital(cause_at(text(e.get("cause")), text(e.get("where")))), sentence(text(e.get("because"))), sentence(text(e.get("needs")))]
        for e in v.untestable
    ]
    note = "Nothing can be said about these, for or against: the data never excite them."
    return section(
        "untestable", "Could not be tested", el("p", note, class_="note"), table(["cause", "because", "would need"], rows, (), "plain")
    )


def recordings(v: View) -> Safe | None:
    """What was read, and what was odd about it."""
    items = [el("li", _recording(r)) for r in v.recordings]
    warned = [el("p", el("b", "Warnings")), el("ul", [el("li", sentence(w)) for w in v.warnings])] if v.warnings else []
    rest = {k: value for k, value in v.other.items() if value not in (None, "", [], {})}
    more = (
        el(
            "details",
            el("summary", "More from findings.json"),
            el("dl", [[el("dt", spoken(k)), el("dd", text(x))] for k, x in rest.items()]),
        )
        if rest
        else None
    )
    return section("recordings", "Recordings", el("ul", items), warned, more) if items or warned or more else None


def _recording(r) -> Safe:
    r = mapping(r) or {"name": r}
    name = text(r.get("name") or r.get("session") or r.get("path") or "recording")
    rest = text({k: value for k, value in r.items() if k not in ("name", "warnings") and value not in (None, "", [], {})})
    warned = el("ul", [el("li", sentence(text(w))) for w in (r.get("warnings") or [])]) if r.get("warnings") else None
    return join([el("b", name), f" – {rest}" if rest else "", warned])


def reading() -> Safe:
    """A glossary."""
    words = (
        ("before, after", "the simulation without and with the causes named here, both fitted to the same data"),
        ("measured − simulated", "what the simulation misses; zero is perfect"),
        ("typical error", "root mean square of measured − simulated"),
        ("data not used for fitting", "a session kept aside: a model that merely memorised the other sessions would fail on it"),
        ("95 % interval", "if the experiment were repeated, the fall of the error would lie in it 19 times out of 20; found by drawing stretches of the session at random"),
        ("noise alone", "the error that would remain with a perfect model, because sensors are noisy"),
        ("ruled out", "tested and not found; would have been seen above the size given"),
        ("could not be tested", "the motion never brought it out, so the data are silent"),
        ("where", "skin: the material; taxel: a sensor in it; load cell: the reference; rig: mount and stage; clock: timing between channels"),
    )  # fmt: skip
    files = "Beside this file: findings.json (everything here, for programs), model.yaml (the extended model), report.md and pictures (for a mail), traces.npz (the curves)."
    return section(
        "reading",
        "How to read this",
        el("dl", [[el("dt", k), el("dd", sentence(w))] for k, w in words], class_="gloss"),
        el("p", files, class_="note"),
    )
