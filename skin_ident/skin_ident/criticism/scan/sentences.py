"""The sentences of a finding about a scan: why it was named, and which experiment would tell it from its rivals."""

from collections.abc import Iterable

import numpy as np

from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.extended import spread_at
from skin_ident.criticism.scan.family import level
from skin_ident.criticism.scan.fault import mm
from skin_ident.criticism.scan.fitting import Member
from skin_ident.criticism.vocabulary import BY_NAME

_BACKWARDS = "scan again from the deepest row to the shallowest"
_PAIRS = {
    "spread_shape off_centre": "scan across the taxel to both sides: a centre that is off shifts the curve, a shape stays symmetric",
    "nonlinear_stiffness position_offset": "press at more depths near the surface: below a late contact the force is zero, that of a "
    "stiffening skin is not",
    "drift force_offset": f"{_BACKWARDS}: drift follows time, a bias is always there",
    "drift spread_shape": f"{_BACKWARDS}, as far out as the table reaches: drift follows time, a tail follows depth",
    "force_offset spread_shape": "read the taxel in the air and far outside: a bias is there without a plunger, a tail is not",
    "parameters gain_error": "press the taxel with a known load: a wrong calibration shows at once",
    "dead_zone force_offset": "press lightly, right over the taxel: a dead zone answers late, a bias does not",
}
APART = {frozenset(pair.split()): words for pair, words in _PAIRS.items()}


def why(cause: str, before: Member, after: Member, cells: Cells) -> str:
    """One sentence that says how large the cause is, in newtons or millimetres; empty for other causes. `before` is a member without it."""
    if cause == "nonlinear_stiffness":
        return _law(before, after)
    if cause == "spread_shape":
        return _shape(before, after, cells)
    if cause == "spread_width":
        return f"the width of the spread is {mm(after.values['width'])} instead of {mm(before.values['width'])}"
    if cause == "spread_depth":
        return _depth(after, cells)
    if cause == "off_centre":
        return f"the force is greatest {1e3 * after.values['centre']:.2f} mm from where the taxel is said to be"
    if cause == "force_offset":
        return f"far from the taxel the readings stay at {after.values['offset']:.3g} N instead of zero"
    if cause == "drift":
        return f"from the first row to the last, the readings drift by {after.values['drift']:.3g} N, at all distances alike"
    if cause == "saturation":
        return f"readings are clipped at {after.values['ceiling']:.3g} N, whatever the depth"
    return ""


def _law(before: Member, after: Member) -> str:
    z = np.array([0.1, 1.0]) * after.scale.deepest
    size = float(np.mean(after.k))
    stiffness = size * level(after.values, z, after.scale) / z * 1e-3
    bent = size * level(after.values, z, after.scale)
    miss = np.abs(float(np.mean(before.k)) * level(before.values, z, before.scale) - bent)
    return (
        f"force per depth goes from {stiffness[0]:.3g} N/mm at {mm(z[0])} to {stiffness[1]:.3g} N/mm at {mm(z[1])}; one stiffness for all "
        f"depths is wrong by {miss[1]:.2g} N at the deepest and {miss[0] / max(bent[0], 1e-12):.0%} at a tenth of that"
    )


def _shape(before: Member, after: Member, cells: Cells) -> str:
    r = np.linspace(0.0, float(np.abs(cells.r).max()), 200)
    size = float(np.mean(after.k)) * float(level(after.values, np.array([after.scale.deepest]), after.scale)[0])
    gaussian = np.exp(-((r / before.values["width"]) ** 2)) if before.scale.shape is None else spread_at(before, r)
    real = spread_at(after, r)
    real = real / real[0]
    more = real - gaussian
    said = [f"{size * more[i]:+.2g} N at {1e3 * r[i]:.2g} mm" for i in _extremes(more)]
    half = [float(np.interp(-0.5, -s, r)) for s in (gaussian, real)]
    tail = real[-1] / max(gaussian[-1], 1e-9)
    tails = f"; at {1e3 * r[-1]:.3g} mm the tail is {tail:.2g} times the Gaussian's" if real[-1] > 0.004 and tail > 1.5 else ""
    reached = f"half the force is reached at {1e3 * half[1]:.2f} mm instead of {1e3 * half[0]:.2f} mm"
    return f"against the Gaussian, the deepest row has {' and '.join(said)}; {reached}{tails}"


def _extremes(y: np.ndarray) -> list[int]:
    """Indices of a curve's maximum and minimum in the order of distance; one is left out where it is small beside the other."""
    both = {int(np.argmax(y)), int(np.argmin(y))}
    return sorted(i for i in both if abs(y[i]) > 0.2 * np.abs(y).max())


def _depth(after: Member, cells: Cells) -> str:
    z = np.array([cells.z.min(), cells.z.max()])
    v = after.values
    c = v["width"] * (1.0 + v["growth"] * (z - after.scale.mean)) * (z / after.scale.mean) ** v["depth_power"]
    return f"the width goes from {1e3 * c[0]:.3g} mm at {1e3 * z[0]:.2g} mm depth to {1e3 * c[1]:.3g} mm at {1e3 * z[1]:.3g} mm"


def separating(causes: Iterable[str], placing: bool = False) -> str:
    """The experiment that tells the first of `causes` from its rivals; empty where there are none. `placing` says that placing errors of
    the plunger are a rival."""
    names = list(dict.fromkeys(causes))
    if placing:
        return "scan again with the plunger set anew at every distance: placing errors change, a shape of the skin stays"
    if len(names) < 2:
        return ""
    known = [APART[frozenset({names[0], other})] for other in names[1:] if frozenset({names[0], other}) in APART]
    return "; and ".join(known) or "record " + "; and ".join(dict.fromkeys(BY_NAME[n].needs for n in names))
