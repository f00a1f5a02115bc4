"""The static forces that this criticism can describe: one parametric family of curves, with the thesis's model as its simplest member.

    force(r, z) = min( max(A(z) S(r, z) - threshold, 0) + offset + drift * order, ceiling )

    A(z)   level     k z' (1 + square z' + cube z'^2), or k z'^exponent;  z' = (z - shift) / deepest, zero above the surface
    S      spread    (1 + tail u^power)^(-1 / tail), which is exp(-u^power) for tail = 0;  or a Gaussian averaged over a disc;
                     or a Gaussian times a polynomial;  u = |r - centre| / c,
    c      width     width (1 + growth (z - mean depth)) (z / mean depth)^depth_power exp(along ratio)

The thesis's model is A = k z' (a linear skin) times exp(-(r / c)^2); the simulated skin does the same.

Sources: thesis eq 27 and section 4.3.4; S. Nadarajah, J. Applied Statistics 32 (2005) 685-694 (generalised Gaussian); K. L. Johnson,
Contact Mechanics, 1985, ch. 3 (tails of an elastic layer); E. Kreyszig, Advanced Engineering Mathematics, 10th ed., section 11.6 (the
polynomials of Laguerre, which are orthogonal over a Gaussian's disc).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import ive

from skin_ident.criticism.scan.cells import Cells


@dataclass(frozen=True)
class Quantity:
    """One parameter of the family: its unit, the neutral value that removes it, and its bounds. `sizes` gives its typical magnitude."""

    name: str
    unit: str
    neutral: float
    lower: float
    upper: float


_INF = float("inf")
QUANTITIES = {
    q.name: q
    for q in (
        Quantity("width", "m", np.nan, 1e-7, 10.0),
        Quantity("power", "1", 2.0, 0.6, 12.0),
        Quantity("tail", "1", 0.0, 0.0, 0.95),
        Quantity("disc", "m", 0.0, 0.0, 10.0),
        Quantity("bend2", "1", 0.0, -0.6, 0.6),
        Quantity("bend3", "1", 0.0, -0.6, 0.6),
        Quantity("bend4", "1", 0.0, -0.6, 0.6),
        Quantity("growth", "1/m", 0.0, -1e6, 1e6),
        Quantity("depth_power", "1", 0.0, -1.0, 1.0),
        Quantity("centre", "m", 0.0, -1.0, 1.0),
        Quantity("ratio", "1", 0.0, -2.0, 2.0),
        Quantity("offset", "N", 0.0, -_INF, _INF),
        Quantity("drift", "N", 0.0, -_INF, _INF),
        Quantity("threshold", "N", 0.0, 0.0, _INF),
        Quantity("ceiling", "N", _INF, 0.0, _INF),
        Quantity("square", "1", 0.0, -5.0, 20.0),
        Quantity("cube", "1", 0.0, -20.0, 20.0),
        Quantity("exponent", "1", 1.0, 0.1, 6.0),
        Quantity("shift", "m", 0.0, -0.1, 0.1),
    )
}
Values = dict[str, float]


def plain(width: float) -> Values:
    """The thesis's model with a width (m): every other parameter at its neutral value."""
    return {name: q.neutral for name, q in QUANTITIES.items()} | {"width": width}


def sizes(cells: Cells, width: float) -> Values:
    """A typical magnitude of each parameter in these scans: the unit of derivative steps, and what `limits` must be able to detect."""
    deepest = cells.depth_span[1]
    force = float(np.percentile(np.abs(cells.y), 98.0))
    relative = {"power": 0.5, "tail": 0.1, "bend2": 0.05, "bend3": 0.05, "bend4": 0.05, "depth_power": 0.1, "ratio": 0.1}
    level = {"square": 0.2, "cube": 0.2, "exponent": 0.2, "shift": 0.1 * deepest, "growth": 0.2 / max(deepest, 1e-9)}
    lengths = {"width": 0.1 * width, "disc": 0.8 * width, "centre": 0.15 * width}
    return relative | level | lengths | dict.fromkeys(("offset", "drift", "threshold", "ceiling"), 0.04 * force)


@dataclass(frozen=True, eq=False)
class Scale:
    """Reference depths of the family, m: fixed once per diagnosis, so that parameter values keep their meaning. `law` maps depth to the
    level of a given model (N), and `shape` maps r / width to its spread. None stands for the thesis's level and spread: depth over the
    deepest depth, and a Gaussian."""

    mean: float
    deepest: float
    law: Callable[[np.ndarray], np.ndarray] | None = None
    shape: Callable[[np.ndarray], np.ndarray] | None = None


def level(p: Values, z: np.ndarray, scale: Scale) -> np.ndarray:
    """A(z) for a size k of 1: at the deepest depth, a linear skin has level 1."""
    tip = np.maximum(z - p["shift"], 0.0)
    d = tip / scale.deepest
    base = scale.law(tip) if scale.law is not None else d
    if p["exponent"] != 1.0:
        base = base * np.maximum(d, 1e-9) ** (p["exponent"] - 1.0)
    return base * (1.0 + p["square"] * d + p["cube"] * d * d)


def spread(p: Values, cells: Cells, scale: Scale) -> np.ndarray:
    """S(r, z), 1 at the centre. A given shape is multiplied by the ratio of the family's spread to the Gaussian."""
    s, u = _spread(p, cells, scale)
    return s if scale.shape is None else scale.shape(u) * s * np.exp(np.minimum(u * u, 50.0))


def _spread(p: Values, cells: Cells, scale: Scale) -> tuple[np.ndarray, np.ndarray]:
    c = p["width"] * np.maximum(1.0 + p["growth"] * (cells.z - scale.mean), 0.1) * np.exp(p["ratio"] * cells.along)
    if p["depth_power"]:
        c = c * (cells.z / scale.mean) ** p["depth_power"]
    r = np.abs(cells.r - p["centre"])
    if p["disc"] > 0.0 and np.ptp(c) == 0.0:
        few, which = np.unique(r, return_inverse=True)
        return disc_of_gaussian(few, c[: few.size], p["disc"])[which], r / c
    if p["disc"] > 0.0:
        return disc_of_gaussian(r, c, p["disc"]), r / c
    u = r / c
    return _radial(p, u), u


def _radial(p: Values, u: np.ndarray) -> np.ndarray:
    v = u * u if p["power"] == 2.0 else u ** p["power"]
    if p["tail"] > 1e-7:
        return np.exp(-np.log1p(p["tail"] * v) / p["tail"])
    s = np.exp(-v)
    if p["bend2"] or p["bend3"] or p["bend4"]:
        l2, l3 = 0.5 * v * v - 2.0 * v + 1.0, ((-v / 6.0 + 1.5) * v - 3.0) * v + 1.0
        l4 = (((v / 24.0 - 2.0 / 3.0) * v + 3.0) * v - 4.0) * v + 1.0
        bent = 1.0 + p["bend2"] * l2 + p["bend3"] * l3 + p["bend4"] * l4
        s = s * bent / max(1.0 + p["bend2"] + p["bend3"] + p["bend4"], 0.2)
    return s


_X, _W = np.polynomial.legendre.leggauss(16)


def disc_of_gaussian(r: np.ndarray, c: np.ndarray, radius: float) -> np.ndarray:
    """A Gaussian of width c averaged over a disc, at distance r from its centre, relative to the value at r = 0; all in m."""
    q = 0.5 * radius * (_X + 1.0)
    weight = _W * q
    c2 = np.maximum(np.asarray(c)[..., None], 0.05 * radius) ** 2  # a narrower Gaussian would make no visible difference to the disc's edge
    inner = np.exp(-((r[..., None] - q) ** 2) / c2) * ive(0, 2.0 * r[..., None] * q / c2)
    return (inner @ weight) / (np.exp(-(q**2) / c2) @ weight)


def sensed(p: Values, through: np.ndarray, cells: Cells) -> tuple[np.ndarray, np.ndarray]:
    """The taxel's reading (N,) for the force that reaches it, and the derivative of the reading by that force (N,)."""
    passed = through - p["threshold"]
    slope = np.ones_like(through)
    if p["threshold"] > 0.0:
        slope = (passed > 0.0).astype(float)
        passed = np.maximum(passed, 0.0)
    y = passed + p["offset"] + p["drift"] * cells.order
    if np.isfinite(p["ceiling"]):
        slope = slope * (y < p["ceiling"])
        y = np.minimum(y, p["ceiling"])
    return y, slope
