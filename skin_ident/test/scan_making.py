"""Spread scans with a known truth, from physics written out here and not from the package's kernels.

Shapes come from numerical convolution in the plane: plunger disc or Hertz's pressure, through the kernel of an elastic layer, over the
taxel's disc. What is hidden is mixed into the thesis's plain model until what that cannot absorb has the wanted size.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.signal import fftconvolve

from skin_ident.spread_scan import SpreadScan

SIDE = np.array([0.0, 1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]) * 1e-3
GRID = np.linspace(-40.0, 40.0, 641)  # mm


@dataclass(frozen=True)
class Truth:
    cause: str | None
    form: str
    noise: float
    clean: list


@cache
def convolved(form, radius=3.0):
    """Load of some radius (mm), spread by a layer, averaged by a taxel: value at r over the half-width at half maximum, tabulated."""
    r = np.hypot(*np.meshgrid(GRID, GRID))
    disc, hertz = (r < radius).astype(float), np.sqrt(np.maximum(1 - (r / radius) ** 2, 0))
    load, layer, taxel = {
        "punch": (disc, np.exp(-((r / 3.0) ** 2)), r < 1.5),
        "ball": (hertz, np.exp(-((r / 2.0) ** 2)), r < 1.5),
        "discs": (disc, np.exp(-((r / 1.5) ** 2)), r < 2.0),
        "boussinesq": (hertz, (1 + (r / 4.0) ** 2) ** -2.5, r < 2.0),
        "leaky": (hertz, np.exp(-r / 3.5), r < 2.0),
        "bell": (hertz, (1 + (r / 4.0) ** 2) ** -1.5, r < 4.77),
    }[form]
    shape = fftconvolve(fftconvolve(load, layer, mode="same"), taxel.astype(float), mode="same")[320, 320:]
    out, shape = GRID[320:], shape / shape[0]
    return out / np.interp(-0.5, -shape, out), shape


def curve(u, form, radius=3.0):
    """A convolved shape at u = r / c, with the half-width of exp(-u^2)."""
    r, s = convolved(form, radius)
    return np.interp(np.abs(u) / np.sqrt(np.log(2)), r, s, right=0.0)


def mixed(u, form, mix, radius=3.0):
    """exp(-u^2), a share of it replaced by another shape."""
    return (1 - mix) * np.exp(-(u**2)) + mix * curve(u, form, radius)


def wide(u, form, amount):
    """The shape under a load of radius 10 mm times `amount`, between tabulated radii."""
    low = np.floor(20 * amount) / 2 + 0.01
    share = 2 * (10 * amount + 0.01 - low)
    return (1 - share) * curve(u, form, low) + share * curve(u, form, low + 0.5)


def plain(z, r, k, c):
    return k * z * np.exp(-((r / c) ** 2))


HIDDEN = {  # (z relative, r m, k z, c m, amount) -> force
    "flat_punch": ("spread_shape", lambda z, r, a, c, s: a * wide(r / c, "punch", s)),
    "flat_ball": ("spread_shape", lambda z, r, a, c, s: a * wide(r / c, "ball", s)),
    "flat_edged": ("spread_shape", lambda z, r, a, c, s: a * mixed(r / c, "discs", s, 7.0)),
    "tail_boussinesq": ("spread_shape", lambda z, r, a, c, s: a * mixed(r / c, "boussinesq", s)),
    "tail_leaky": ("spread_shape", lambda z, r, a, c, s: a * mixed(r / c, "leaky", s)),
    "tail_bell": ("spread_shape", lambda z, r, a, c, s: a * mixed(r / c, "bell", s)),
    "growth_contact": ("spread_depth", lambda z, r, a, c, s: a * np.exp(-(r**2) / (c**2 * (1 + s * z)))),
    "growth_root": ("spread_depth", lambda z, r, a, c, s: a * np.exp(-((r / (c * (1 + s * np.sqrt(z)))) ** 2))),
    "beside": ("off_centre", lambda z, r, a, c, s: a * np.exp(-(((r - s * c) / c) ** 2))),
    "floor": ("force_offset", lambda z, r, a, c, s: a * np.exp(-((r / c) ** 2)) + 5 * s),
    "hertz_law": ("nonlinear_stiffness", lambda z, r, a, c, s: a * ((1 - s) + s * np.sqrt(z)) * np.exp(-((r / c) ** 2))),
    "fung_law": ("nonlinear_stiffness", lambda z, r, a, c, s: a * (1 + s * np.expm1(z)) * np.exp(-((r / c) ** 2))),
    "late": ("position_offset", lambda z, r, a, c, s: a / z * np.maximum(z - s, 0) * np.exp(-((r / c) ** 2))),
    "creep": ("drift", lambda z, r, a, c, s: a * np.exp(-((r / c) ** 2)) + 5 * s * (z - z[0])),
    "clips": ("saturation", lambda z, r, a, c, s: np.minimum(a * np.exp(-((r / c) ** 2)), a.max() * (1 - s))),
    "deaf": ("dead_zone", lambda z, r, a, c, s: np.maximum(a * np.exp(-((r / c) ** 2)) - 5 * s, 0)),
    "oval": ("anisotropy", None),
}
NOISES = ("white", "fine", "coarse", "growing", "heavy", "placing", "repeat")


def make(hidden=None, size=1.0, seed=0, noise="white", two_sided=False, depths=10, both=False, sigma=0.06, step=0.1):
    """Scans (a list) and the truth. `size` is the RMS of what k z exp(-(r/c)^2) cannot absorb over the RMS of the noise."""
    rng = np.random.default_rng([seed, 4711])
    c, k = rng.uniform(3.5e-3, 6.5e-3), rng.uniform(6e3, 14e3)
    z = np.arange(1, depths + 1)[:, None] / depths * rng.uniform(0.8e-3, 1.6e-3)
    r = np.r_[-SIDE[:0:-1], SIDE] if two_sided or hidden == "beside" else SIDE
    sigma, step = {"fine": (0.02, 0.01), "coarse": (sigma, 0.4)}.get(noise, (sigma, step))
    floor = float(np.hypot(sigma, step / np.sqrt(12)))
    cause, law = HIDDEN[hidden] if hidden else (None, None)

    def clean(s):
        if hidden == "oval":
            return [plain(z, r, k, c * f) for f in (np.exp(s / 2), np.exp(-s / 2))]
        one = law(z / z[-1], r, k * z, c, s) if hidden else plain(z, r, k, c)
        return [one] * (2 if both else 1)

    amount = amount_of(lambda s: unabsorbed(clean(s), z, r) / floor, size) if hidden else 0.0
    tables = [read(f, z, r, c, rng, noise, sigma, step) for f in clean(amount)]
    names = ["scan_x.csv", "scan_y.csv"] if len(tables) > 1 else ["scan.csv"]
    return [SpreadScan(z[:, 0], r, t, name=n) for t, n in zip(tables, names, strict=True)], Truth(cause, hidden or "", floor, clean(amount))


def read(f, z, r, c, rng, noise, sigma, step):
    """What the converter says: noise, then steps."""
    e = sigma * rng.normal(size=f.shape)
    if noise == "growing":
        e = np.hypot(sigma / 2, 0.02 * f) * rng.normal(size=f.shape)
    if noise == "heavy":
        e = sigma * rng.standard_t(3, size=f.shape) / np.sqrt(3)
    if noise == "placing":
        f = f * np.exp((r**2 - (r + 0.05e-3 * rng.normal(size=r.size)) ** 2) / c**2)
    if noise == "repeat":
        f = f * (1 + 0.02 * rng.normal(size=(f.shape[0], 1)))
    return np.round(np.round((f + e) / step) * step, 4)


def unabsorbed(tables, z, r):
    """RMS of what is left of the best k z exp(-(r/c)^2)."""
    f, best = np.concatenate(tables), np.inf
    zz = np.tile(z, (len(tables), 1))
    for c in np.geomspace(2e-3, 15e-3, 100):
        s = zz * np.exp(-((r / c) ** 2))
        best = min(best, np.sum((f - s * np.sum(s * f) / np.sum(s * s)) ** 2))
    return np.sqrt(best / f.size)


def amount_of(relative, size):
    """The amount at which the size is reached, by bisection; the largest sensible one where it never is."""
    low, high = 0.0, 0.02
    while relative(high) < size and high < 0.95:
        high = min(1.6 * high, 0.95)
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if relative(middle) < size else (low, middle)
    return high
