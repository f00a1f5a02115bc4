"""What is ruled out: the upper bound of each cause in words, as a share of what it could be at most, and whether that bound says little."""

from collections.abc import Iterable

import numpy as np

from skin_ident.criticism.telling.outcome import Trace
from skin_ident.criticism.vocabulary import spoken
from skin_ident.report.numbers import amount, finite, percent
from skin_ident.report.tolerant import mapping, place_in, text
from skin_ident.report.view import View
from skin_ident.report.words import effect_words, label

WEAK = 0.25  # share of the whole above which a bound rules out little
CLEARLY_LESS = 0.5  # the smallest bound over the shapes is shown where it is at most this share of the largest
SHARES = ("relative", "share", "gain", "lost", "loss", "softening", "creep")  # parameters without unit that are shares of a whole
OF_DEPTH = ("position_offset", "mount_compliance", "backlash")  # causes whose size in m is a depth
FORMS = {"step": "a step within a session"}  # words for forms whose names do not explain themselves
WHOLE = {"N/m": "of the skin's stiffness", "N": "of the largest reading", "m": "of the greatest depth", "1": "of the whole"}  # by unit


def reach(traces: Iterable[Trace]) -> dict[str, float]:
    """The greatest depth (m), as `depth`, and the largest reading of every channel, that were recorded; only those that are known."""
    most: dict[str, float] = {}
    for t in traces:
        rows = zip(t.channels, np.abs(t.measured[:, t.compared]), strict=True)
        for name, y in (*rows, *([("depth", t.depth)] if t.depth is not None else [])):
            most[name] = max(most.get(name, 0.0), float(np.nanmax(y, initial=0.0)))
    return {name: x for name, x in most.items() if x > 0.0}


def weakly(v: View) -> tuple[dict, ...]:
    """The entries of `excluded` whose bound is large, so that much of the cause may be there unseen."""
    return tuple(e for e in v.excluded if (_share(e, e.get("below"), v) or 0.0) > WEAK)


def strongly(v: View) -> tuple[dict, ...]:
    """The other entries."""
    weak = weakly(v)
    return tuple(e for e in v.excluded if e not in weak)


def bound(e: dict, v: View | None = None) -> str:
    """The upper bound of an excluded cause, in words, or why there is none. Where the bound depends much on the cause's other parameters,
    the smallest, too. With the view, a bound that is a stiffness, or weak, has its share of the whole."""
    if finite(e.get("below")) is None:
        return text(e.get("because")) or "not seen"
    form = f" ({FORMS.get(text(e['form']), spoken(text(e['form'])))})" if e.get("form") else ""
    words, shape = _words(e, mapping(e.get("at")))
    said = amount(e["below"], text(e.get("unit"))) + form + (f" – {words}{', at ' + shape if shape else ''}" if words else "")
    said += _of_the_whole(e, e["below"], v)
    least = mapping(e.get("least"))
    if finite(least.get("below")) is None or least["below"] > CLEARLY_LESS * e["below"]:
        return said
    shape = _words(e, mapping(least.get("at")))[1]
    return f"{said}; {amount(least['below'], text(e.get('unit')))} at {shape}{_of_the_whole(e, least['below'], v)}"


def _of_the_whole(e: dict, below: float, v: View | None) -> str:
    """The share of the whole that a bound is, in brackets, where the bound is a stiffness, or weak; else empty."""
    share, unit = v and _share(e, below, v), text(e.get("unit"))
    told = share is not None and (unit == "N/m" or share > WEAK)
    return f" ({percent(share)} {WHOLE[unit]})" if told else ""


def _words(e: dict, at: dict) -> tuple[str, str]:
    """Words for the parameter of an entry, and for the values of the others that it is `at`."""
    cause, where, name = text(e.get("cause")), place_in(e), text(e.get("parameter"))
    labels = effect_words(cause, where, (name, *at), (text(e.get("form")),))
    each = {k: mapping(q) for k, q in at.items()}
    shape = ", ".join(f"{labels.get(k) or label(k)} {amount(q.get('value'), text(q.get('unit')))}" for k, q in each.items())
    return labels.get(name) or label(name), shape


def _share(e: dict, below: object, v: View) -> float | None:
    """A bound as a share of the whole: of the skin's stiffness, of the largest reading of its sensor, of the greatest depth in the
    recordings, or of 1; None where no whole is known."""
    unit, size = text(e.get("unit")), finite(below)
    stiffness = sum(a.value or 0.0 for a in v.before if a.name in ("k1", "k2")) if e.get("where") == "skin" else 0.0
    depth = v.reach.get("depth", 0.0) if e.get("cause") in OF_DEPTH else 0.0
    share = 1.0 if text(e.get("parameter")) in SHARES else 0.0
    whole = {"N/m": stiffness, "N": _largest(v, text(e.get("where"))), "m": depth, "1": share}.get(unit, 0.0)
    return None if size is None or whole <= 0.0 else size / whole


def _largest(v: View, where: str) -> float:
    """The largest reading (N) of the sensor at a place, or of any."""
    readings = {name: x for name, x in v.reach.items() if name != "depth"}
    own = [x for name, x in readings.items() if name.startswith({"load_cell": "force"}.get(where, where))]
    return max(own or readings.values(), default=0.0)
