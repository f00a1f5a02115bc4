"""Bars and tables of numbers: errors by channel, the ranking of causes, parameters before and after."""

from skin_ident.criticism.telling.outcome import Round
from skin_ident.criticism.vocabulary import cause_at
from skin_ident.report.gains import fall
from skin_ident.report.markup import Safe, el, table
from skin_ident.report.numbers import UNKNOWN, amount, change, fall_span, plain
from skin_ident.report.sizes import moved, number, step
from skin_ident.report.story import explaining, named_cause
from skin_ident.report.view import Amount, ChannelError, View
from skin_ident.report.words import capital, channel

MOST_RANKED = 8  # causes that are shown in a round


def error_table(v: View) -> Safe:
    """The error of every channel before and after, with bars (each channel to its own scale) and the noise floor as a tick. Where nothing
    is named there is only one simulation, and one error per channel."""
    errors = v.errors
    both = any(None not in e.held_out for e in errors)
    head = ["channel", "before", "after", "change", "fall, 95 % interval", "noise alone", ""] + ["on training data"] * both
    rows = [_error_row(e, v)[: len(head)] for e in errors]
    if not v.findings:
        head, *rows = [[r[i] for i in (0, 2, 5, 6)] for r in (["channel", "", "error", "", "", "noise alone", ""], *rows)]
    elif not any(e.interval for e in errors):
        head, *rows = [r[:4] + r[5:] for r in (head, *rows)]
    return table(head, rows, numeric=tuple(i for i, h in enumerate(head) if i and h), class_="errors")


def _error_row(e: ChannelError, v: View) -> list:
    before, after = e.pair
    like = v.loudest or [before, after, e.floor]
    changed = change(-fall(e)) if before and after is not None else UNKNOWN
    training = " → ".join(amount(x, e.unit, like=like) for x in e.train) if None not in e.train else UNKNOWN
    shown = ((before, "before"), (after, "after")) if v.findings else ((after, "after"),)
    top = max((x for x in (*(x for x, _ in shown), e.floor) if x), default=0.0)
    bars = [_bar(x, top, kind) for x, kind in shown]
    floor = el("u", style=f"left:{100 * e.floor / top:.1f}%", title="noise alone") if top and e.floor else None
    cells = [amount(x, e.unit, like=like) for x in (before, after)]
    fell = fall_span(*e.interval, before, e.unit, like) if e.interval else UNKNOWN
    return [channel(e.channel), *cells, changed, fell, amount(e.floor, e.unit, like=like), el("div", bars, floor, class_="duel"), training]


def _bar(value: float | None, top: float, kind: str) -> Safe | None:
    return el("s", class_=kind, style=f"width:{100 * value / top:.1f}%") if value and top else None


def ranking(round_: Round, number: int, top: float) -> Safe:
    """One round of the search as bars: what each cause explains, the best first. A bar of the value `top` has full width, in all rounds."""
    ranked = explaining(round_, MOST_RANKED)
    named = named_cause(round_.named or "")
    title = f"Round {number}: {cause_at(named, '')} named" if named else f"Round {number}: nothing more could be named"
    if not ranked:
        return el("div", el("h4", title), el("p", "No cause explains any of the remaining error.", class_="note"), class_="rank")
    first = True
    rows = []
    for cause, where, gain in ranked:
        chosen = first and cause == named
        first = first and not chosen
        bar = el("div", el("s", class_="after" if chosen else "rival", style=f"width:{100 * gain / top:.1f}%"), class_="track")
        rows.append(
            el(
                "li",
                el("span", capital(cause_at(cause, where)), class_="who"),
                bar,
                el("span", plain(gain), class_="num"),
                class_="chosen" if chosen else None,
            )
        )
    return el("div", el("h4", title), el("ol", rows), class_="rank")


def parameter_table(v: View) -> Safe:
    """The model's parameters before and after. A change of more than three standard errors and 5 % is marked: as where the error was
    hiding, or, for given numbers, as differing from what was given."""
    before, after = {a.name: a for a in v.before}, {a.name: a for a in v.after}
    rows = [_parameter_row(before.get(name), after.get(name), v) for name in dict.fromkeys([*before, *after])]
    head = ["parameter", "name", v.begun, "after", "change", ""]
    return table(head, rows, numeric=(2, 3, 4), class_="params")


def _parameter_row(before: Amount | None, after: Amount | None, v: View) -> list:
    known = before or after
    like = [a.value for a in (before, after) if a]
    cells = [number(a, v, like) if a else UNKNOWN for a in (before, after)]
    if not before:
        return [capital(known.words), el("code", known.name.rpartition(".")[2]), *cells, "new", el("b", "added", class_="tag new")]
    has_moved = moved(before, after)
    tag = el("b", f"not {v.begun}" if v.given else "was biased by the missing effect", class_="tag hid") if has_moved else None
    return [capital(known.words), el("code", known.name.rpartition(".")[2]), *cells, _change(before, after), tag]


def _change(before: Amount, after: Amount | None) -> str:
    share = step(before, after)
    return UNKNOWN if share is None else change(share)
