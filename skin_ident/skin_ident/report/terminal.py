"""The findings as text for a terminal: what the page says first, with names as they are in files and options."""

from collections.abc import Iterator
from typing import Any

from skin_ident.criticism.vocabulary import place_of
from skin_ident.report.counsel import unsure
from skin_ident.report.numbers import amount
from skin_ident.report.reading import LONE, view
from skin_ident.report.sessions import most_left
from skin_ident.report.sizes import AT_END
from skin_ident.report.tolerant import mapping, place_in, text
from skin_ident.report.view import EXPLAINED, NOTHING, PARTLY, UNEXPLAINED, Amount, Finding, Gain, View

VERDICTS = {
    NOTHING: "nothing wrong: what is left looks like noise",
    EXPLAINED: "explained: with these causes, what is left looks like noise",
    PARTLY: "partly explained: something systematic is left",
    UNEXPLAINED: "unexplained: the simulation is wrong, and no cause of the catalogue explains it",
}

SHORT_OF_NOISE = {
    NOTHING: "nothing wrong that could be named: what is left",
    EXPLAINED: "explained as far as causes could be named: what is left",
}


def summary(findings: dict[str, Any]) -> str:
    """The content of findings.json (schema 1) as lines of text."""
    v = view(findings)
    lines = [_verdict(v)]
    if names := mapping(v.other.get("taxels")):
        lines.append(f"  ({', '.join(f'{i} is {name}' for i, name in names.items())})")
    for f in v.findings:
        lines += _told(f)
    lines += [f"\n  in doubt: {_placed(text(d.get('cause')), place_in(d))}: {text(d.get('because'))}" for d in v.doubts]
    lines += _left_open(v)
    if most := most_left(v):
        lines.append(f"\n  {most}")
    lines += [f"\n  {a.name} held at {_size(a)}: {because}" for a, because in v.held if a.value is not None]
    lines += [f"\nwarning: {w}" for w in v.warnings]
    return "\n".join(lines)


def _verdict(v: View) -> str:
    if v.above and v.verdict in SHORT_OF_NOISE:
        channel, times = v.above
        open_ = ", and something is not settled" if v.unsettled else ""
        return f"{_surely(SHORT_OF_NOISE[v.verdict], v)} of {channel} is {times:.2f} times what noise alone leaves{open_}"
    if v.verdict == NOTHING and v.doubts:
        return "nothing could be named with certainty"
    if v.left_open:
        return "nothing named, but something is not settled"
    return _surely(VERDICTS.get(v.verdict, v.verdict), v)


def _surely(verdict: str, v: View) -> str:
    """The verdict, with a caveat where it says that something is explained and that is not sure."""
    said = unsure(v)
    return verdict.replace("explained", f"explained, but {said}", 1) if said and v.verdict in (EXPLAINED, PARTLY) else verdict


def _told(f: Finding) -> Iterator[str]:
    """The lines of a finding: its name, its sizes, its gain, and its rivals."""
    yield f"\n  {_placed(f.cause, f.where)}{f.in_some}: {f.means}"
    yield from (f"    {a.name} = {_size(a)}" for a in f.amounts if not a.is_rounding)
    if f.each_session:
        yield from [f"    {f.goes}"] if f.goes else []
        yield from (f"    {session}: {course}" for session, course in f.each_session.items())
    elif why := text(dict(f.evidence).get("why")):
        yield f"    {why}"
    yield from _worth(f.gain)
    for i, (cause, where, _) in enumerate(f.alternatives):
        size = ", ".join(f"{a.name} = {_size(a)}" for a in (f.rival_amounts[i] if f.rival_amounts else ()) if not a.is_rounding)
        yield f"    cannot be told from: {_placed(cause, where)}{f' ({size})' if size else ''}"
    if f.separating:
        yield f"    {f.separating}"


def _left_open(v: View) -> Iterator[str]:
    """Lines on departures that several causes could explain: why they are open, the causes, and what would settle it."""
    for because, needs in dict.fromkeys((text(e.get("because")), text(e.get("needs"))) for e in v.left_open):
        alike = [e for e in v.left_open if (text(e.get("because")), text(e.get("needs"))) == (because, needs)]
        yield f"\n  not settled: {because}"
        yield f"    may be any of: {', '.join(text(e.get('cause')) for e in alike)}"
        yield f"    would settle it: {needs}"


def _placed(cause: str, where: str) -> str:
    """A cause and its place, named as in findings.json."""
    if where.startswith("clock"):
        return f"{cause} in {place_of(cause, where)}"
    return f"{cause} in {({'taxel': 'all taxels', LONE: 'the taxel'}).get(where, f'the {where}')}"


def _size(a: Amount) -> str:
    """A number with its standard error, where it has one, in the same unit as on the page; plain spaces make it easy to search."""
    return amount(a.value, a.unit, a.std).replace("\u00a0", " ").replace("\u202f", "") + f" ({AT_END})" * a.at_end


def _worth(g: Gain) -> Iterator[str]:
    """The fall of the held-out error, where it was measured."""
    if None not in (g.before, g.after, g.low, g.high) and g.before != g.after:
        by = f"at least {g.low:.3g}" if g.high > g.before else f"{g.low:.3g} to {g.high:.3g}"  # an error cannot fall by more than itself
        chance = f"may be chance: the 95 % interval also allows a rise by {abs(g.low):.3g} {g.unit}"
        interval = f"falls by {by} {g.unit}, 95 %" if g.low > 0.0 else chance
        yield f"    held-out error of {g.channel}: {g.before:.3g} -> {g.after:.3g} {g.unit} ({interval})"
