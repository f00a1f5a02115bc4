"""The page: first screen, sections, and the style and script it carries inside, so that it opens offline."""

from importlib.resources import files

from skin_ident.criticism.telling.outcome import Outcome
from skin_ident.report import appendix, sections
from skin_ident.report.charts import cut_off, key, overlay, scan_picture
from skin_ident.report.evidence import evidence
from skin_ident.report.focus import Focus
from skin_ident.report.markup import Safe, el
from skin_ident.report.reading import recording_name
from skin_ident.report.sessions import sessions
from skin_ident.report.story import Story, Told, Wrong
from skin_ident.report.view import View
from skin_ident.report.words import capital, role, sentence, short

SIGNS = {"good": "✓", "found": "!", "part": "~", "bad": "?"}


def page(told: Told) -> str:
    """The whole report as one HTML document."""
    outcome, v, seen = told.outcome, told.view, told.seen
    parts = [
        sections.measured(outcome, v, seen),
        sections.left(outcome, v, seen),
        evidence(outcome, v),
        sessions(v),
        appendix.parameters(v),
        appendix.excluded(v),
        appendix.untestable(v),
        appendix.recordings(v),
        appendix.reading(v, told.folder),
    ]
    main = el("main", _first_screen(told.story, _picture(outcome, v, seen)), _contents([p for p in parts if p]), [p for p in parts if p])
    head = el(
        "head",
        el("meta", charset="utf-8"),
        el("meta", name="viewport", content="width=device-width, initial-scale=1"),
        el("title", f"Skin diagnosis – {told.story.headline.title}"),
        el("style", Safe(_asset("style.css"))),
    )
    body = el(
        "body", el("header", el("p", "What the simulated skin gets wrong", class_="kicker"), el("p", _names(v), class_="names")), main
    )
    script = el("script", Safe(_asset("script.js")))
    return "<!doctype html>\n" + el("html", head, Safe(body[: -len("</body>")] + script + "</body>"), lang="en")


def _asset(name: str) -> str:
    return (files("skin_ident") / "data" / "report" / name).read_text(encoding="utf-8")


def _names(v: View) -> str:
    names = [recording_name(r) for r in v.recordings]
    shown = ", ".join(short(name) for name in names[:3])
    return shown + (f" and {len(names) - 3} more" if len(names) > 3 else "")


def _first_screen(told: Story, picture: Safe | None) -> list[Safe]:
    h = told.headline
    banner = el(
        "div",
        el("span", SIGNS[h.tone], class_="sign", aria_hidden="true"),
        el("div", el("h1", h.title), el("p", h.line)),
        class_=f"banner {h.tone}",
    )
    b = told.better
    tiles = [
        _tile("better", "How much better is the model?", b.number, b.caption, b.sentences),
        _tile("sure", "How sure are we?", told.sure, "", told.sure_because),
        _tile("rebuild", "Rebuild a sensor?", told.rebuild, "", (sentence(f"because {told.rebuild_because}"),)),
    ]
    answers = [
        el("div", el("h2", "What is wrong"), _list(told.wrong), class_="wrong"),
        el("div", el("h2", "Why we think so"), el("ul", [el("li", s) for s in told.why]), class_="why") if told.why else None,
    ]
    next_ = el("div", el("h2", "What to do next"), el("ol", [el("li", s) for s in told.next]), class_="next") if told.next else None
    below = el("div", el("div", answers, class_="answers"), picture, class_="first")
    return [banner, el("div", el("div", tiles, class_="tiles"), next_, below, class_="screen")]


def _tile(kind: str, title: str, answer: str, caption: str, said: tuple[str, ...]) -> Safe:
    return el(
        "div", el("h2", title), el("p", el("b", answer), " ", caption, class_="big"), [el("p", s) for s in said], class_=f"tile {kind}"
    )


def _list(wrong: tuple[Wrong, ...]) -> Safe:
    """The list of what is wrong, with entries that belong to another one (`of_last`) nested below it."""
    groups: list[tuple[Wrong, list[Wrong]]] = []
    for w in wrong:
        groups[-1][1].append(w) if w.of_last else groups.append((w, []))
    return el("ul", [el("li", _wrong(w), el("ul", [el("li", _wrong(o)) for o in own]) if own else None) for w, own in groups])


def _wrong(w: Wrong) -> list:
    size = el("div", f"Size: {w.size}", class_="size") if w.size else None
    return [el("b", w.name), ". " if w.name and w.means else None, w.means, size]


def _picture(outcome: Outcome, v: View, seen: Focus | None) -> Safe | None:
    if seen is None:
        return el("div", key(outcome.scans[0]), scan_picture(outcome.scans[0]), class_="picture") if outcome.scans else None
    cut = slice(seen.start, seen.stop)
    beyond = "; its axis is cut: samples that were not compared (shaded) go beyond it" if cut_off(seen.trace, seen.row, v, cut) else ""
    caption = f"{seen.words} of {short(seen.trace.session)} ({role(seen.trace.held_out)}); below, what is left{beyond}"
    chart = overlay(seen.trace, seen.row, v, cut, 900)
    return el("div", key(seen.trace), chart, el("p", capital(caption), class_="note"), class_="picture")


def _contents(parts: list[Safe]) -> Safe:
    """Links to the sections that the page has."""
    names = {
        "measured": "Measured against simulated", "left": "What is left", "evidence": "Evidence", "sessions": "Session by session",
        "parameters": "Parameters", "excluded": "Ruled out", "untestable": "Not tested", "recordings": "Recordings",
        "reading": "How to read this",
    }  # fmt: skip
    return el(
        "nav", [el("a", name, href=f"#{key}") for key, name in names.items() if any(p.startswith(f'<section id="{key}"') for p in parts)]
    )
