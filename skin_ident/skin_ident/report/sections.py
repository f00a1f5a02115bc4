"""The sections of charts below the first screen: measured against simulated, and the residual."""

import numpy as np

from skin_ident.criticism.telling.outcome import Outcome, Trace
from skin_ident.report.bars import error_table
from skin_ident.report.charts import against_frequency, against_motion, below_band, key, key_left, overlay, scan_left, scan_panels
from skin_ident.report.counsel import TESTED
from skin_ident.report.focus import Focus, by_fall
from skin_ident.report.gains import at_any_scale, quieter
from skin_ident.report.markup import Safe, el, section
from skin_ident.report.numbers import plain
from skin_ident.report.view import IN_TURN, UNTESTED, View
from skin_ident.report.words import capital, channel, role, short

MOST_SESSIONS = 6  # that are drawn
MOST_CHANNELS = 4  # of a session that are drawn
MOST_POINTS = 160_000  # points in all charts together: about 1 MB of text


def measured(outcome: Outcome, v: View, seen: Focus | None) -> Safe | None:
    """The section of measured against simulated: the errors of every channel, then whole sessions."""
    table_ = [el("p", _error_note(v), class_="note"), error_table(v)] if v.errors else []
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
    where = TESTED[UNTESTED if _told_on_cards(v) else v.tested]
    turn = " Each session was held out in turn to judge the causes; those errors are on the cards below." if _told_on_cards(v) else ""
    error = f"Typical error (root mean square of measured minus simulated{below_band(v)}) on {where}."
    scaled = any(at_any_scale(e, v) for e in v.errors)
    turn += " Causes were judged with a scale factor fitted to each session; those errors are on the cards below." if scaled else ""
    mark = "The mark on the bars is the error that noise alone leaves"
    least = f"{mark}. {beyond}" if (beyond := quieter(v)) else f"{mark}; no model can do better."
    return f"{error} {least}{turn}"


def _told_on_cards(v: View) -> bool:
    """Whether sessions were held out in turn while the errors by channel are those of the fit; then only the cards have held-out errors."""
    return v.tested == IN_TURN and not v.in_turn


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
    rows = by_fall(trace, v.silent)[:MOST_CHANNELS]
    about = f" – {role(trace.held_out)}, {plain(trace.t[-1] - trace.t[0])} s"
    head = el("summary", el("b", short(trace.session, 72), title=trace.session), about)
    charts = [el("h4", capital(channel(trace.channels[r]))) + overlay(trace, r, v, slice(None), buckets) for r in rows]
    hidden = len(trace.channels) - len(rows)
    note = (
        el("p", f"{hidden} more channels, which gained less, are in the table above and in traces.npz.", class_="note") if hidden else None
    )
    return el("details", head, [Safe(c) for c in charts], note, open=is_open, class_="session")


def _scans(outcome: Outcome) -> list[Safe]:
    return [el("div", el("h4", s.session), el("div", scan_panels(s), class_="grid"), class_="scan") for s in outcome.scans]


def left(outcome: Outcome, v: View, seen: Focus | None) -> Safe | None:
    """The section of the residual: against depth, speed and frequency (against time is in the section above)."""
    blocks = []
    if seen is not None:
        for row in by_fall(seen.trace, v.silent)[:3]:
            panels = [p for p in (*against_motion(seen.trace, row, v), against_frequency(seen.trace, row, v)) if p]
            blocks.append(el("h4", capital(channel(seen.trace.channels[row]))))
            blocks.append(el("div", panels, class_="grid"))
    blocks += [el("div", el("h4", s.session), el("div", scan_left(s), class_="grid")) for s in outcome.scans]
    if not blocks:
        return None
    note = (
        "What the simulation misses. A complete model leaves flat lines around zero, and the same noise at every frequency; "
        "a slope, a step or a peak shows where the model fails."
    )
    if seen is not None:
        note += f" Lines are medians; against speed, the middle 80 % of the samples are shaded. Session: {short(seen.trace.session)}."
    title = "What is left: against depth, speed and frequency" if seen is not None else "What is left"
    return section("left", title, el("p", note, class_="note"), key_left(seen.trace if seen else outcome.scans[0]), blocks)
