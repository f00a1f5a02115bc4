"""Finite areas: what a disc-shaped taxel feels of a disc-shaped plunger, through a kernel of the skin alone.

Averaging a radial function f over a disc of radius a whose centre is r away gives

    F(r) = 1 / (pi a^2) * integral over 0 < p < a, 0 < t < 2 pi of f(|r + p e^(i t)|) p dp dt

It conserves the integral over the plane, and the order of taxel and plunger does not matter: the average is a kernel again.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from skin_models.errors import ModelError
from skin_models.spread.kernels import Kernel

_NODES = 24
_ROWS = 1500


@dataclass(frozen=True, eq=False)
class Finite(Kernel):
    """`kernel` as discs of the given radii see it: tabulated, linear between."""

    kernel: Kernel
    taxel_radius: float  # m; 0 is a point
    patch_radius: float = 0.0  # m; 0 is a point
    _r: np.ndarray = field(init=False, repr=False)
    _shape: np.ndarray = field(init=False, repr=False)
    _peak: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not (np.isfinite([self.taxel_radius, self.patch_radius]).all() and min(self.taxel_radius, self.patch_radius) >= 0.0):
            raise ModelError(f"radii must be lengths in m, not {self.taxel_radius} and {self.patch_radius}")
        r = _radii(self.kernel, self.taxel_radius + self.patch_radius)
        once = disc_average(self.kernel.shape, self.patch_radius, r)
        twice = disc_average(lambda q: np.interp(q, r, once, right=0.0), self.taxel_radius, r)
        for name, value in (("_r", r), ("_shape", twice / twice[0]), ("_peak", float(twice[0]))):
            object.__setattr__(self, name, value)

    def shape(self, r):
        """The average, relative to that in the middle; 0 beyond the table."""
        return np.interp(r, self._r, self._shape, right=0.0)

    @property
    def area(self):
        """Area of the kernel over the average in the middle."""
        return self.kernel.area / self._peak

    def reach(self, tolerance):
        """The entry of the table behind the last that is `tolerance` or more."""
        above = np.flatnonzero(self._shape >= tolerance)[-1]
        return float(self._r[min(above + 1, self._r.size - 1)])


def _radii(kernel: Kernel, radius: float) -> np.ndarray:
    """Distances for a table: even in the core, ever wider in the tail."""
    core = kernel.reach(0.5) + radius
    return core * np.sinh(np.linspace(0.0, np.arcsinh((kernel.reach(1e-10) + radius) / core), _ROWS))


def disc_average(f: Callable[[np.ndarray], np.ndarray], radius: float, r: np.ndarray) -> np.ndarray:
    """Average of the radial function `f` over a disc of `radius` (m) at distances `r` (m), by Gauss-Legendre; `f(r)` for radius 0."""
    if radius == 0.0:
        return f(r)
    x, w = np.polynomial.legendre.leggauss(_NODES)
    p, w_p = radius * (x + 1.0) / 2.0, radius * w / 2.0
    t, w_t = np.pi * (x + 1.0) / 2.0, np.pi * w / 2.0
    total = np.zeros_like(r)
    for ring, weight in zip(p, w_p * p, strict=True):
        q = np.sqrt(np.maximum(r[:, None] ** 2 + ring**2 + 2.0 * r[:, None] * ring * np.cos(t), 0.0))
        total += 2.0 * weight * (f(q) @ w_t)
    return total / (np.pi * radius**2)
