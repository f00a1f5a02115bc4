"""The gallery's page: one HTML file that needs nothing else."""

import base64
import html
import inspect
from collections.abc import Callable
from itertools import groupby

from skin_models.gallery import TITLE
from skin_models.gallery.drawing import overview, png, title
from skin_models.gallery.scene import Picture
from skin_models.parameter import parameters_of

STYLE = """
:root { color-scheme: light dark; --bg: #fff; --ink: #111827; --soft: #4b5563; --rule: #e5e7eb; --code: #f6f7f9; --link: #1f5fa8 }
@media screen and (prefers-color-scheme: dark) {
  :root { --bg: #14161a; --ink: #e8eaee; --soft: #a3aab6; --rule: #343943; --code: #1c1f25; --link: #6db3ff }
  img { filter: invert(.91) hue-rotate(180deg) } }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--bg); max-width: 1180px; margin: 2rem auto;
  padding: 0 1.2rem; overflow-wrap: anywhere }
h1 { margin-bottom: .2rem } h2 { margin: 3rem 0 .4rem; border-top: 1px solid var(--rule); padding-top: 1.2rem }
h3 { margin: 1.6rem 0 .2rem; font-size: 1rem }
p.lead, .source { color: var(--soft) } .source { font-size: .85rem }
img { width: 100%; height: auto } .wide { overflow-x: auto } .wide img { min-width: 900px }
pre { background: var(--code); padding: .8rem 1rem; overflow-x: auto; font-size: .82rem; white-space: pre-wrap }
table { border-collapse: collapse; font-size: .85rem; display: block; overflow-x: auto; overflow-wrap: normal }
td:last-child { min-width: 14rem } td, th { padding: .15rem .9rem .15rem 0; text-align: left; font-weight: normal }
th { color: var(--soft) } nav { columns: 4 9rem; font-size: .88rem } nav a { display: block; color: var(--link); text-decoration: none }
"""


def page(shown: list[Picture], say: Callable[[str], None] = lambda stage: None) -> str:
    """The whole page; `say` hears of each picture."""
    shown = sorted(shown, key=lambda p: p.effect.cause)
    causes = [(cause, list(group)) for cause, group in groupby(shown, lambda p: p.effect.cause)]
    links = "".join(f'<a href="#{cause}">{cause}</a>' for cause, _ in causes)
    sections = []
    for n, (cause, group) in enumerate(causes, 1):
        say(f"drawing {n} of {len(causes)} causes: {cause}")
        sections.append(_section(cause, group))
    say("drawing all at a glance")
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'
        f"{TITLE}<style>{STYLE}</style><h1>What every effect does</h1>"
        f'<p class="lead">One press of a 4 mm silicone skin, simulated with an effect of ordinary size (red) and without it (grey). '
        f"{len(shown)} effects of {len(causes)} causes; the noise is that of a fair sensor, and the same in both. "
        f"Blue is the difference between the two, shown alone where they look alike.</p>"
        f"<nav>{links}</nav><h2>All at a glance</h2>{_wide(overview(shown), 'every effect')}{''.join(sections)}</html>"
    )


def _section(cause: str, group: list[Picture]) -> str:
    about, bodies = [], []
    for p in group:
        text = inspect.getmodule(type(p.effect)).__doc__ or ""
        if text not in about:
            about.append(text)
        rows = "".join(_row(parameter) for parameter in parameters_of(p.effect))
        bodies.append(
            f"<h3>{html.escape(title(p))}</h3>{_wide(png(p), title(p))}"
            f"<table><tr><th>parameter</th><th>value shown</th><th>bounds</th><th>role</th><th></th></tr>{rows}</table>"
        )
    equations = "".join(f"<pre>{html.escape(text.strip())}</pre>" for text in about)
    return f'<h2 id="{cause}">{cause}</h2>{equations}{"".join(bodies)}'


def _row(p) -> str:
    cells = (p.name, f"{p.value:g} {'' if p.unit == '1' else p.unit}", f"{p.lower:g} … {p.upper:g}", p.role, p.doc)
    return "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in cells) + "</tr>"


def _wide(picture: bytes, name: str) -> str:
    """A picture that a phone scrolls sideways, rather than make its words too small to read."""
    return f'<div class="wide">{_image(picture, name)}</div>'


def _image(picture: bytes, name: str) -> str:
    return f'<img alt="{html.escape(name)}" src="data:image/png;base64,{base64.b64encode(picture).decode()}">'
