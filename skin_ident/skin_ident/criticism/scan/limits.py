"""For every cause that was not named: an upper bound of its size, or that it is untestable and what would test it.

The size of a cause, jointly with everything in the model, is estimated to first order: z with standard error sd. The cause is testable
where a typical magnitude (`family.sizes`) is at least CLEAR standard errors; it is then excluded above |z| + 1.96 sd.
"""

from typing import Any

import numpy as np

from skin_ident.criticism.scan.candidates import CANDIDATES, Candidate, Excited
from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.family import QUANTITIES
from skin_ident.criticism.scan.fitting import Member, jacobian, tangents
from skin_ident.criticism.scan.whitening import Whitener
from skin_ident.criticism.vocabulary import CAUSES
from skin_ident.estimators.estimate import HALF_95

CLEAR = 3.0  # standard errors
_TIME = "a static scan has no time in it"
_ONE = "there is one taxel in these scans"
_STIFFNESS = "in a static scan it is the same as another stiffness"
NEVER = {
    "stress_relaxation": _TIME,
    "rate_dependence": _TIME,
    "hysteresis": "a static scan does not say from which side each depth was approached",
    "cyclic_softening": "a static scan does not say how the skin was loaded before",
    "adhesion": "a static scan does not withdraw the plunger",
    "friction": "a static scan has no reversals",
    "mount_compliance": _STIFFNESS,
    "backlash": "a static scan has no reversals",
    "inertia": _TIME,
    "lag": _TIME,
    "time_shift": _TIME,
    "interference": _TIME,
    "crosstalk": _ONE,
    "gain_error": _STIFFNESS,
}
NEEDS = {
    "off_centre": "a scan across the taxel, to both sides",
    "spread_width": "spread_width_mm in rig.yaml, or a given model (--model) with a width to compare with",
    "drift": "scans at three or more depths, best not in the order of depth",
}
PLAINEST = {"spread_shape": "power", "spread_depth": "growth", "nonlinear_stiffness": "square"}  # the parameter whose bound is reported


def limits(m: Member, cells: Cells, noise: Whitener, x: Excited, named: set[str], known: dict[str, str]) -> tuple[list[dict], list[dict]]:
    """Entries `excluded` and `untestable` of findings.json for all causes not in `named`. `known` is about causes that are looked for in
    the table itself: why that was not possible, or an empty text where the cause was looked for and not seen."""
    excluded: list[dict[str, Any]] = []
    untestable: list[dict[str, Any]] = []
    for cause in CAUSES:
        if cause.name in named:
            continue
        because = NEVER.get(cause.name) or known.get(cause.name) or x.why_not(cause.name) or _tied(cause.name, m, x)
        entry = None if because else _excluded(m, cells, noise, cause.name)
        if entry is not None:
            excluded.append(entry)
        else:
            because = because or "even an ordinary amount of it would not stand out from the noise here"
            untestable.append({"cause": cause.name, "because": because, "needs": NEEDS.get(cause.name, cause.needs)})
    return excluded, untestable


def _tied(cause: str, m: Member, x: Excited) -> str:
    """Why a cause, though excited, cannot be told from what is in the model; empty where it can."""
    if cause == "off_centre" and not x.both_sides:
        return "from one side of the taxel, a centre that is off looks like another shape of the spread"
    return "another shape was fitted, and it brings its own width" if cause == "spread_width" and "width" in m.free else ""


def _excluded(m: Member, cells: Cells, noise: Whitener, cause: str) -> dict[str, Any] | None:
    c = next((c for c in CANDIDATES if c.cause == cause), None)
    if c is None or cause == "saturation":
        return {"cause": cause, "below": None, "unit": "", "because": "looked for and not seen"}
    if cause == "parameters":
        return _size(m, cells, noise)
    return _limit(m, cells, noise, c)


def _limit(m: Member, cells: Cells, noise: Whitener, c: Candidate) -> dict[str, Any] | None:
    name = PLAINEST.get(c.cause, c.names[0])
    if name == "threshold":  # at zero its tangent equals that of an offset, so the bound is linearised about half a typical magnitude
        m = m.moved(threshold=0.5 * m.steps["threshold"])
    J = noise.apply(jacobian(m.freeing(name), cells))
    position = m.freeing(name).free.index(name)
    e = noise.apply(cells.y - m.predict(cells))
    covariance = np.linalg.pinv(J.T @ J)
    sd = float(np.sqrt(covariance[position, position]))
    z = float((covariance @ (J.T @ e))[position]) + (m.values[name] if name == "threshold" else 0.0)
    if not sd or CLEAR * sd > m.steps[name]:
        return None
    return {"cause": c.cause, "where": c.where, "parameter": name, "below": abs(z) + HALF_95 * sd, "unit": QUANTITIES[name].unit}


def _size(m: Member, cells: Cells, noise: Whitener) -> dict[str, Any]:
    """The entry `excluded` for `parameters`: the upper bound of the relative error of a given model's level."""
    J = noise.apply(np.hstack([tangents(m, cells, m.free), m.through(cells)[:, None]]))
    covariance = np.linalg.pinv(J.T @ J)
    z = float((covariance @ (J.T @ noise.apply(cells.y - m.predict(cells))))[-1])
    below = abs(z) + HALF_95 * float(np.sqrt(covariance[-1, -1]))
    return {"cause": "parameters", "where": "skin", "parameter": "k1", "below": below, "unit": "1"}
