"""The evidence: a card for each finding, and how the causes compare in every round."""

import re

from skin_ident.criticism.telling.outcome import Outcome
from skin_ident.criticism.vocabulary import cause_at, spoken
from skin_ident.report.bars import ranking
from skin_ident.report.markup import Safe, el, join, section
from skin_ident.report.numbers import amount, fall_span, percent
from skin_ident.report.sizes import rival_sizes, sizes
from skin_ident.report.tolerant import sequence, text
from skin_ident.report.view import Amount, Finding, View
from skin_ident.report.words import EVIDENCE, SHARES, capital, channel, sentence, signal

UNTOLD = (  # entries of the evidence that are shown elsewhere, or are for programs only
    "likelihood_gain", "held_out_fall_of_mean_square", "why", "unlike_simulated", "stuck", "count", "excursions", "ratio", "std",
    "sessions", "in_model", "predicts_nothing_for", "put_right", "only_in", "not_in",
    "whole", "pattern", "of_each_session", "dead_from_s",
)  # fmt: skip


def evidence(outcome: Outcome, v: View) -> Safe | None:
    """The section with a card for each finding, then the ranking of every round."""
    cards = [_card(f, v, i + 1) for i, f in enumerate(v.findings)]
    top = max((gain for r in outcome.rounds for _, _, gain in r.ranked), default=0.0)
    rounds = [ranking(r, i + 1, top) for i, r in enumerate(outcome.rounds)]
    if not cards and not rounds:
        return None
    note = (
        "The length of a bar (one scale for all rounds) is how much of the mismatch that cause alone would explain, as estimated when the "
        "round began (fall of the squared error, in units of the variance of the noise). The model's own parameters were free to explain "
        "it first. The best few were then fitted in full: percentages in the text come from these fits. The blue bar is the cause that was "
        "named; it also had to predict unused data better."
    )
    ranks = [el("h3", "How the causes compare"), el("p", note, class_="note"), el("div", rounds, class_="grid wide")] if rounds else None
    return section("evidence", "The evidence", el("div", cards, class_="cards"), ranks)


def _card(f: Finding, v: View, number: int) -> Safe:
    rows = [
        ("What it means", sentence(f.means)),
        ("Seen in", ", ".join(channel(c) for c in f.channels)),
        ("Size", [el("div", line) for line in sizes(f, v, 12)]),
        ("In each session", [el("div", f"{session}: {text(own)}") for session, own in f.each_session.items()]),
        ("Why", sentence(f.why)),
        *_gain_rows(f, v),
        ("Had biased", [el("div", _bent(*pair, v)) for pair in f.hid_in]),
        *((EVIDENCE.get(k) or capital(spoken(k)), _evidence_text(k, value)) for k, value in f.evidence if k not in UNTOLD),
        *(("Could also be", _other(f, i)) for i in range(len(f.alternatives))),
        ("Would tell them apart", sentence(f.separating)),
        ("What to do", sentence(f.act)),
    ]
    entries = [[el("dt", k), el("dd", value)] for k, value in rows if value]
    return el("article", el("h3", f"{number}. {capital(f.called)}{f.in_some}"), el("dl", entries), class_="card")


def _other(f: Finding, which: int) -> Safe:
    """One alternative name of a finding, with how well it explains the data and how large it would be."""
    cause, where, why = f.alternatives[which]
    said = [s for s in (why, *rival_sizes(f, which)) if s]
    return join([cause_at(cause, where), f" ({'; '.join(said)})" if said else ""])


def _bent(before: Amount, after: Amount, v: View) -> str:
    """A parameter before and after the cause was named. With a single finding, "after" is the final value, as in the table."""
    at_the_end = next((a for a in v.after if a.name == before.name), after)
    after = at_the_end if len(v.findings) == 1 else after
    like = [before.value, after.value]
    both = " → ".join(amount(a.value, a.unit, like=like) for a in (before, after))
    return f"{before.words}: {both}"


def _gain_rows(f: Finding, v: View) -> list[tuple[str, str]]:
    g = f.gain
    if f.direct or g.before is None or g.after is None:
        return []
    both = " → ".join(amount(value, g.unit, like=v.loudest or [g.before, g.after]) for value in (g.before, g.after))
    rows = [("Error on unused data", f"{both} in the {signal(g.channel)}")]
    if g.low is None or g.high is None:
        return rows
    return [*rows, ("Fall, 95 % interval", fall_span(g.low, g.high, g.before, g.unit, v.loudest))]


def _evidence_text(key: str, value) -> str:
    if key in SHARES:
        return percent(value)
    if key == "forms":
        return ", ".join(re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text(form)).lower() for form in sequence(value))
    return text(value)
