"""Session by session: parameters fitted to each session alone, the error of each, and how these change from one session to the next."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from skin_ident.criticism.pattern import in_order, pattern, when
from skin_ident.criticism.telling.by_session import STANDS_OUT
from skin_ident.criticism.vocabulary import spoken
from skin_ident.report.markup import Safe, el, section, table
from skin_ident.report.numbers import UNKNOWN, bare, finite, plain, scale
from skin_ident.report.reading import recording_name
from skin_ident.report.tolerant import mapping, sequence, text
from skin_ident.report.view import PARTLY, UNEXPLAINED, View
from skin_ident.report.words import sentence, short, signal

ZERO = "zero"
KINDS = ("stiffness", "ratio", "recovery", ZERO)
WORTH_SAYING = 0.01  # smallest relative change from session to session that the first screen reports
MOST_ZEROS, MOST_ERRORS = 6, 6  # channels in the table of zeros, and in that of errors
CLEARLY = 6.0  # standard errors by which numbers must differ before a pattern over sessions is reported
NOTE = (
    "Stiffness and damping of the model with the causes named here, fitted to each session alone, with a zero of every channel, and "
    "without what was found to be that session's own. Recovery is damping divided by stiffness. Standard errors contain noise only. "
    "Numbers that differ from those of the other sessions by more than their scatter are marked."
)
NO_GAIN = "The stiffness of the taxel does the same: so the skin, or the place pressed, has changed, and no gain of a sensor."
ERRORS = "Typical error of each session; errors that differ clearly from those of the other sessions are marked."


@dataclass(frozen=True)
class Column:
    """One column of numbers: its head, its cells by session, and the sessions whose number stands out."""

    head: str
    cells: dict[str, str]
    odd: frozenset[str]


@dataclass(frozen=True)
class BySession:
    """The columns of three tables (own parameters, zeros, errors), the sessions in order, those held out, and sentences about how numbers
    change over the sessions."""

    names: tuple[str, ...]
    held: frozenset[str]
    own: tuple[Column, ...]
    zeros: tuple[Column, ...]
    errors: tuple[Column, ...]
    said: tuple[str, ...]
    hidden: int  # number of channels that are not shown and only in findings.json


def by_session(v: View) -> BySession | None:
    """What findings.json says about each session alone; None where it does not for at least two sessions."""
    told = {recording_name(r): mapping(r) for r in v.recordings if mapping(r).get("by_itself")}
    if len(told) < 2:
        return None
    names = tuple(in_order(told))
    channels = list(dict.fromkeys(c for n in names for c in mapping(told[n].get("rmse"))))
    odd = {n: frozenset(map(text, sequence(told[n].get("stands_out")))) for n in names}
    zeros, errors = (_most_telling(channels, kind, most, odd) for kind, most in ((ZERO, MOST_ZEROS), ("rmse", MOST_ERRORS)))
    own = {kind: [_own(kind, c, names, told, odd) for c in _of(kind, names, told) if kind != ZERO or c in zeros] for kind in KINDS}
    return BySession(
        names,
        frozenset(n for n in names if told[n].get("held_out") is True),
        tuple(column for kind in KINDS if kind != ZERO for column in own[kind]),
        tuple(own[ZERO]),
        tuple(_errors(c, names, told, odd, v) for c in errors),
        tuple(said for kind in KINDS for c in _of(kind, names, told) for said in _goes(kind, c, names, told)),
        len(channels) - min(len(zeros), len(errors)),
    )


def _of(kind: str, names: tuple[str, ...], told: dict[str, dict]) -> list[str]:
    """The channels for which sessions have numbers of a kind (see KINDS)."""
    listed = dict.fromkeys(c for n in names for c in mapping(mapping(told[n]["by_itself"]).get(kind)))
    return [c for c in listed if _numbers(kind, c, names, told)]


def _most_telling(channels: list[str], kind: str, most: int, odd: dict[str, frozenset[str]]) -> list[str]:
    """At most `most` channels, in their order; channels in which a session stands out are preferred."""
    ranked = sorted(channels, key=lambda c: not any(f"{kind}.{c}" in each for each in odd.values()))
    return [c for c in channels if c in ranked[:most]]


def _numbers(kind: str, channel: str, names: tuple[str, ...], told: dict[str, dict]) -> dict[str, tuple[float, float, str]]:
    """Value, standard error and unit by session."""
    each = {n: mapping(mapping(mapping(told[n]["by_itself"]).get(kind)).get(channel)) for n in names}
    return {
        n: (q["value"], finite(q.get("std")) or 0.0, text(q.get("unit"))) for n, q in each.items() if finite(q.get("value")) is not None
    }


def _own(kind: str, channel: str, names: tuple[str, ...], told: dict[str, dict], odd: dict[str, frozenset[str]]) -> Column:
    numbers = _numbers(kind, channel, names, told)
    like = [value for c in _of(kind, names, told) for value, _, _ in _numbers(kind, c, names, told).values()]  # one unit for all channels
    unit = next(iter(numbers.values()))[2]
    cells = {n: bare(value, unit, std, like) for n, (value, std, _) in numbers.items()}
    return Column(_head(kind, channel, scale(like, unit)[1]), cells, frozenset(n for n in names if f"{kind}.{channel}" in odd[n]))


def _errors(channel: str, names: tuple[str, ...], told: dict[str, dict], odd: dict[str, frozenset[str]], v: View) -> Column:
    """The column of a channel's errors by session, before and after."""
    pairs = {n: [finite(mapping(mapping(told[n].get("rmse")).get(channel)).get(k)) for k in ("baseline", "extended")] for n in names}
    pairs = {n: pair if v.findings else pair[1:] for n, pair in pairs.items() if None not in pair}
    like = v.loudest or [x for pair in pairs.values() for x in pair]
    cells = {n: " → ".join(bare(x, "N", None, like) for x in pair) for n, pair in pairs.items()}
    return Column(f"{spoken(channel)}, {scale(like, 'N')[1]}", cells, frozenset(n for n in names if f"rmse.{channel}" in odd[n]))


def _head(kind: str, channel: str, unit: str) -> str:
    return f"{_what(kind, channel)}{', ' * bool(unit)}{unit}"


def _what(kind: str, channel: str) -> str:
    """The name of a number: `stiffness of the force`, `force over taxel 1`."""
    return f"force over {spoken(channel)}" if kind == "ratio" else f"{kind} of {_at(channel)}"


def _at(channel: str) -> str:
    return "the force" if channel == "force" else spoken(channel)


def _goes(kind: str, channel: str, names: tuple[str, ...], told: dict[str, dict], least: float = 0.0) -> Iterator[str]:
    """A sentence on how a number changes from session to session, where it changes clearly and in a pattern."""
    numbers = _numbers(kind, channel, names, told)
    y, std = np.array([[value, std] for value, std, _ in numbers.values()]).T
    middle = float(np.median(y))
    if np.ptp(y) <= max(CLEARLY * float(np.median(std)), max(STANDS_OUT[kind], least) * abs(middle)):
        return
    shares, unit = (y / middle - 1.0, "1") if kind != ZERO and middle else (y, "N")
    if goes := pattern(dict(zip(numbers, shares.tolist(), strict=True)), unit):
        beside = " of its median" if unit == "1" else ""
        yield sentence(f"the {_what(kind, channel)} {goes}{beside}")


def goes_on_from_day_to_day(v: View) -> str:
    """A sentence for the first screen on how gain ratio or stiffness changes over the sessions, where no finding says it; else empty.

    A change in the ratio of force to taxel means that a sensor changes. A change of both stiffnesses alike means that the skin does.
    """
    told = {recording_name(r): mapping(r) for r in v.recordings if mapping(r).get("by_itself")}
    names = tuple(in_order(told))
    if len(told) < 2 or any(f.each_session or f.partly for f in v.findings):
        return ""
    gains = [s for c in _of("ratio", names, told) for s in _goes("ratio", c, names, told, WORTH_SAYING)]
    if gains:
        return f"{gains[0]} A stiffer skin would not change this ratio: the gain of one of the two sensors may have changed."
    stiffer = [s for c in _of("stiffness", names, told) for s in _goes("stiffness", c, names, told, WORTH_SAYING)]
    return f"{stiffer[0]} {NO_GAIN}" if len(stiffer) > 1 else stiffer[0] if stiffer else ""


def most_left(v: View) -> str:
    """In which sessions the residual is largest, in words; empty where none stand out, or where nothing systematic is left."""
    some, times = [text(n) for n in sequence(v.most_left.get("most_in"))], finite(v.most_left.get("times"))
    if v.verdict not in (PARTLY, UNEXPLAINED) or not some or times is None:
        return ""
    where = when(some, [recording_name(r) for r in v.recordings]).removesuffix(" alone")
    what = f"most of what is left of the {signal(text(v.most_left.get('channel')))} is {where}"
    return f"{what}: {plain(times, 2)} times as much as in the other sessions"


def sessions(v: View) -> Safe | None:
    """The section of the page; None where findings.json has nothing about single sessions."""
    told = by_session(v)
    if told is None:
        return None
    more = f"{told.hidden} more channels are in findings.json."
    return section(
        "sessions",
        "Session by session",
        el("p", NOTE, class_="note"),
        _table(told, told.own) if told.own else None,
        el("ul", [el("li", said) for said in told.said]) if told.said else None,
        [el("h3", "Zero of each session"), _table(told, told.zeros)] if told.zeros else None,
        el("h3", "Error of each session"),
        el("p", f"{ERRORS}{' Before → after.' if v.findings else ''}", class_="note"),
        _table(told, told.errors),
        el("p", more, class_="note") if told.hidden else None,
    )


def _table(told: BySession, columns: tuple[Column, ...]) -> Safe:
    rows = [[_name(n, told), *(_cell(n, c) for c in columns)] for n in told.names]
    return table(["session", *(c.head for c in columns)], rows, numeric=tuple(range(1, len(columns) + 1)), class_="by-session")


def _name(n: str, told: BySession) -> list:
    return [short(n), el("span", " held out", class_="aside") if n in told.held else None]


def _cell(n: str, c: Column) -> Any:
    cell = c.cells.get(n, UNKNOWN)
    return el("b", cell, class_="odd") if n in c.odd else cell


def in_markdown(v: View) -> list[tuple[list[str], list[list[str]]]]:
    """Head and rows of the three tables as text, for markdown."""
    told = by_session(v)
    if told is None:
        return []
    return [
        (
            ["session", *(c.head for c in columns)],
            [[n + " (held out)" * (n in told.held), *(_bold(n, c) for c in columns)] for n in told.names],
        )
        for columns in (told.own, told.zeros, told.errors)
    ]


def _bold(n: str, c: Column) -> str:
    return f"**{c.cells[n]}**" if n in c.odd and n in c.cells else c.cells.get(n, UNKNOWN)
