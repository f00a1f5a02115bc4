"""The report as markdown: for a mail, a wiki or a pull request. Same words as the page, without the charts."""

from collections.abc import Iterator

from skin_ident.report.appendix import ONLY_WEAKLY, SPREAD, WEAK_HEAD, WEAK_NOTE, held_at, size_ruled_out, untestable_rows, weak_rows
from skin_ident.report.gains import error, fall, quieter
from skin_ident.report.numbers import UNKNOWN, change
from skin_ident.report.reading import recording_name, warning_sentences
from skin_ident.report.ruled_out import strongly
from skin_ident.report.sessions import by_session, in_markdown
from skin_ident.report.sizes import number
from skin_ident.report.story import Told, Wrong
from skin_ident.report.tolerant import named_at
from skin_ident.report.view import Amount, View
from skin_ident.report.words import capital, channel, sentence

TABLES = ("Session by session", "Zero of each session", "Error of each session")


def markdown(all_: Told, pictures: tuple[str, ...] = ()) -> str:
    """The whole text; `pictures` are file names beside it."""
    v, told = all_.view, all_.story
    parts = [
        [f"# {told.headline.title}", "", told.headline.line],
        [f"![{name.partition('.')[0].replace('_', ' ')}]({name})" for name in pictures[:1]],
        ["## What is wrong", "", *map(_wrong, told.wrong)],
        ["## Why we think so", "", *(f"- {s}" for s in told.why)] if told.why else [],
        [
            "## How much better is the model",
            "",
            f"**{told.better.number}**{f' {told.better.caption}' if told.better.caption else ''}.",
            "",
            *(f"- {s}" for s in told.better.sentences),
        ],
        ["## How sure are we", "", f"**{told.sure}.**", "", *(f"- {s}" for s in told.sure_because)],
        ["## Rebuild a sensor?", "", f"**{told.rebuild}**, because {told.rebuild_because}."],
        ["## What to do next", "", *(f"{i}. {s}" for i, s in enumerate(told.next, 1))] if told.next else [],
        _errors(v),
        *_sessions(v),
        _parameters(v),
        *_excluded(v),
        _untestable(v),
        [f"![{name.partition('.')[0].replace('_', ' ')}]({name})" for name in pictures[1:]],
        _recordings(v),
    ]
    return "\n\n".join("\n".join(p) for p in parts if p) + "\n"


def _wrong(w: Wrong) -> str:
    said = f"**{w.name}**: {w.means}" if w.name and w.means else w.means or f"**{w.name}**"
    return f"{'  ' * w.of_last}- {said}" + (f" Size: {w.size}." if w.size else "")


def _rows(title: str, head: list[str], rows: list[list[str]]) -> list[str]:
    if not rows:
        return []
    lines = [" | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in row) for row in rows]
    return [f"## {title}", "", f"| {' | '.join(head)} |", f"|{' --- |' * len(head)}", *(f"| {line} |" for line in lines)]


def _errors(v: View) -> list[str]:
    note = ["", said] if (said := quieter(v)) else []
    if not v.findings:
        rows = [[channel(e.channel), error(e.pair[1], e, v), error(e.floor, e, v)] for e in v.errors]
        return _rows("Error of every channel", ["channel", "error", "noise alone"], rows) + note
    rows = [[channel(e.channel), *(error(x, e, v) for x in e.pair), change(-fall(e)), error(e.floor, e, v)] for e in v.errors]
    return _rows("Error of every channel", ["channel", "before", "after", "change", "noise alone"], rows) + note


def _sessions(v: View) -> Iterator[list[str]]:
    told = by_session(v)
    for title, (head, rows) in zip(TABLES, in_markdown(v), strict=False):
        yield _rows(title, head, rows) if len(head) > 1 else []
    if told and told.said:
        yield [f"- {said}" for said in told.said]


def _parameters(v: View) -> list[str]:
    before, after = {a.name: a for a in v.before}, {a.name: a for a in v.after}

    def cell(a: Amount | None) -> str:
        return number(a, v) if a else UNKNOWN

    names = dict.fromkeys([*before, *after])
    rows = [[capital((before.get(n) or after[n]).words), f"`{n}`", cell(before.get(n)), cell(after.get(n))] for n in names]
    table = _rows("Parameters before and after", ["parameter", "name", v.begun, "after"], rows)
    return [*table, *(line for said in (SPREAD, *held_at(v)) for line in ("", sentence(said)))] if table else []


def _excluded(v: View) -> Iterator[list[str]]:
    yield _rows("Ruled out", ["cause", "smaller than"], [[named_at(e), size_ruled_out(e, v)] for e in strongly(v)])
    weak = _rows(ONLY_WEAKLY, WEAK_HEAD, weak_rows(v))
    yield [*weak, "", WEAK_NOTE] if weak else []


def _untestable(v: View) -> list[str]:
    return _rows("Could not be tested", ["cause", "because", "would need"], [list(row) for row in untestable_rows(v)])


def _recordings(v: View) -> list[str]:
    names = [f"- {recording_name(r)}" for r in v.recordings]
    warned = [f"- Warning: {w}" for w in warning_sentences(v)]
    return ["## Recordings", "", *names, *warned] if names or warned else []
