"""A cause in the ratios of the taxels in words, with numbers a person can check, and the experiment that separates rivals."""

from collections.abc import Iterable

import numpy as np

from skin_ident.criticism.array.bending import Leaning, Settling, Walking, Widening
from skin_ident.criticism.array.family import HALF_SPACE, Family, is_repeat
from skin_ident.criticism.array.judgement import Judged
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.array.smeared import Capacitive, Smeared
from skin_ident.criticism.vocabulary import BY_NAME
from skin_models.effect import Effect

ALIKE = 0.03  # relative difference within which two widths count as equal
SCAN = "press at three or more places along the taxels, a third of their distance apart (contact_position_mm tells where)"
_PAIRS = {
    "off_centre gain_error": f"{SCAN}: a wrong calibration stays with its taxel, a wrong place moves with the contact",
    "off_centre crosstalk": f"{SCAN}: crosstalk reaches as far as the wiring does, a wrong place only as far as the spread",
    "gain_error crosstalk": "press right over one taxel after the other: its neighbours then read only what they repeat",
    "gain_error spread_shape": f"{SCAN}: a wrong calibration stays with its taxel, a shape stays with the distance",
    "gain_error spread_width": f"{SCAN}: a wrong calibration stays with its taxel, a width stays with the distance",
    "gain_error gain_error": "press each taxel with the same known load, or right over it",
    "off_centre spread_shape": f"{SCAN}: a wrong place moves the maximum, another shape does not",
    "off_centre spread_width": f"{SCAN}: a wrong place moves the maximum, another width does not",
}
APART = {frozenset(pair.split()): words for pair, words in _PAIRS.items()}


def why(j: Judged, layout: Layout) -> str:
    """One sentence with the evidence for the cause."""
    return f"{_what(j, layout)}; {farthest(j, layout)}"


def farthest(j: Judged, layout: Layout) -> str:
    """The taxel whose reading differs most from the declared layout, as a clause."""
    far = _deviations(j, layout)
    session, i = np.unravel_index(np.argmax(np.abs(far)), far.shape)
    most = ", at the place where it shows most" if layout.several_contacts else ""
    return f"against the declared layout, taxel_{i} reads {far[session, i]:+.1%} of the sensed force{most}"


def _what(j: Judged, layout: Layout) -> str:
    """What the ratios show, from the fitted member of the family, as a clause."""
    p, n = j.fit.member, len(layout.taxels)
    if j.hypothesis.cause == "off_centre":
        if "axis" in j.hypothesis.free:
            turned = f"{np.degrees(p['axis']):+.2g}° against the declared ones"
            return f"the ratios of {n} taxels are those of a stage whose axes are turned by {turned}"
        shift = 1e3 * shift_of(p, layout)
        return f"the ratios of {n} taxels are those of a contact {np.hypot(*shift):.2g} mm off, by {_in_mm(shift)}"
    if j.hypothesis.cause == "gain_error":
        return f"{j.hypothesis.where} alone reads {p['gain_' + j.hypothesis.where.partition('_')[2]]:+.1%} against what neighbours imply"
    if j.hypothesis.cause == "crosstalk":
        return _repeated(next(iter(j.hypothesis.free)), p)
    if j.hypothesis.cause == "spread_width":
        return _wide(layout.width * np.exp(p["width"]), layout.width)
    if "tail" in j.hypothesis.free:
        fall = 2.0 * HALF_SPACE * np.exp(p["fall"])
        return f"{p['tail']:.1%} of the spread does not fall as a Gaussian but, far away, with the distance to the power -{fall:.2g}"
    if j.hypothesis.cause == "spread_shape":
        return f"the spread falls as exp(-(r/c)^{2.0 + p['power']:.2g}), not as a Gaussian"
    return f"the spread is {np.exp(p['ratio']):.2g} times as wide along x as along y"


def _wide(found: float, declared: float) -> str:
    said = f"the spread falls as exp(-(r/c)^2) with c = {1e3 * found:.3g} mm, not {1e3 * declared:.3g} mm"
    standard = abs(np.log(found / (np.sqrt(2.0) * declared))) < ALIKE
    return f"{said}; perhaps a standard deviation was declared: c is sqrt(2) times that" if standard else said


def _repeated(name: str, p: dict[str, float]) -> str:
    if is_repeat(name):
        _, hearing, heard = name.split("_")
        return f"taxel_{hearing} repeats {p[name]:.1%} of taxel_{heard}"
    in_order = {"previous": "the one with the number before its own", "next": "the one with the number after its own"}
    in_order |= {f"{name}_in_turn": f"{one}, in turn" for name, one in in_order.items()}
    heard = {"leak": "its neighbours", "common": "the mean of all"} | in_order
    return f"every taxel repeats {p[name]:.1%} of {heard[name]}"


def changing(e: Effect) -> str:
    """One sentence for an effect that changes the ratios while the array is pressed; empty for any other effect."""
    if isinstance(e, (Leaning, Walking)):
        when = "from the surface to the greatest depth" if isinstance(e, Leaning) else f"in {e.seconds:.0f} s"
        return f"the ratios of {len(e.taxels)} taxels change as if the contact moved by {_in_mm(1e3 * e.shift * np.array(e.axis))} {when}"
    if isinstance(e, Widening):
        where = f" at the surface, most of it within {1e3 * e.settling:.2g} mm" if isinstance(e, Settling) else ""
        return f"the spread grows by {1e-3 * e.growth:.1%} per mm of depth{where}"
    if isinstance(e, Capacitive):
        return f"every taxel repeats {e.share:.1%} of what changes in its neighbours within {1e3 * e.tau:.0f} ms"
    return f"every taxel repeats {e.share:.1%} of its neighbours, {1e3 * e.tau:.0f} ms late" if isinstance(e, Smeared) else ""


def _in_mm(shift: np.ndarray) -> str:
    """A shift (2,) mm in words, to the micrometre; no zero is negative."""
    x, y = np.round(shift, 3) + 0.0
    return f"({x:+.2g}, {y:+.2g}) mm"


def shift_of(p: dict[str, float], layout: Layout) -> np.ndarray:
    """Displacement of the first session's contact from its declared place, (2,) m."""
    return Family(layout).off(p)[0]


def _deviations(j: Judged, layout: Layout) -> np.ndarray:
    """Difference of every taxel's share from the declared one in every session, relative to the largest share, (S, T)."""
    own = {name: value for name, value in j.fit.member.items() if name in j.hypothesis.free}
    family = Family(layout)
    plain, now = family.shares({}), family.shares(own)
    return (now - plain) / plain.max()


def separating(causes: Iterable[str]) -> str:
    """The experiment that separates the first of `causes` from the others; empty for one alone."""
    first, *others = causes
    known = [APART[key] for other in others if (key := frozenset({first, other})) in APART]
    unknown = [BY_NAME[c].needs for c in [first, *others] if others and not known]
    return "; and ".join(dict.fromkeys(known)) or ("record " + "; and ".join(dict.fromkeys(unknown)) if unknown else "")
