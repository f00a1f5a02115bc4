"""From applied to sensed force: the dispersion model driven by a force instead of a depth (thesis eq 32).

    m v' + (b1 + b2) v + (k1 + k2) x = F        sensed = b1 v + k1 x

    sensed / F = (b1 s + k1) / (m s^2 + (b1 + b2) s + (k1 + k2))

Discretised exactly for a force that is linear between samples (first-order hold), with the recursion arranged so that it needs the
present force alone:

    sensed[n] = C z[n] + d F[n],        z[n+1] = A z[n] + g F[n].

The weight of the skin, -m g of eq 27, is no part of a transfer function and is left out.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import expm

from skin_models.dispersion import Dispersion
from skin_models.errors import ModelError


@dataclass(frozen=True)
class Transmission:
    """The filter at one sample period `dt` (s). Raises `ModelError` for parameters whose response does not settle."""

    dispersion: Dispersion
    dt: float

    def __post_init__(self) -> None:
        d = self.dispersion
        if not (np.isfinite(self.dt) and self.dt > 0.0):
            raise ModelError(f"the sample period must be a positive time in s, not {self.dt}")
        if d.k1 + d.k2 <= 0.0 or d.b1 + d.b2 < 0.0 or (d.m > 0.0 and d.b1 + d.b2 == 0.0):
            raise ModelError("a skin driven by force needs k1 + k2 > 0 and b1 + b2 > 0, or it never settles")

    @cached_property
    def matrices(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
        """(A (S, S), g (S,), C (S,), d) of the recursion; S = 0, 1 or 2 states."""
        a, b, c, direct = self._continuous()
        step, held, ramp = _first_order_hold(a, b, self.dt)
        # x[n+1] = step x[n] + held F[n] + ramp F[n+1]; with z = x - ramp F the future force drops out.
        return step, held + step @ ramp, c, direct + float(c @ ramp)

    def _continuous(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
        d = self.dispersion
        b, k = d.b1 + d.b2, d.k1 + d.k2
        if d.m > 0.0:
            return np.array([[0.0, 1.0], [-k / d.m, -b / d.m]]), np.array([0.0, 1.0 / d.m]), np.array([d.k1, d.b1]), 0.0
        if b > 0.0:
            return np.array([[-k / b]]), np.array([1.0 / b]), np.array([d.k1 - d.b1 * k / b]), d.b1 / b
        return np.empty((0, 0)), np.empty(0), np.empty(0), d.k1 / k

    def initial(self, channels: int = 1) -> np.ndarray:
        """The state at rest, (S, channels)."""
        return np.zeros((self.matrices[1].size, channels))

    def step(self, state: np.ndarray, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """One sample of all channels: force (channels,) N in, sensed (channels,) N out. `state` is not changed."""
        a, g, c, d = self.matrices
        return a @ state + np.multiply.outer(g, force), c @ state + d * force


def _first_order_hold(a: np.ndarray, b: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Exact step for an input linear between samples: x[n+1] = P x[n] + q0 u[n] + q1 u[n+1].

    The exponential of [[A, b, 0], [0, 0, 1 / dt], [0, 0, 0]] dt holds P and both integrals.
    Source: Franklin, Powell, Workman, Digital Control of Dynamic Systems, 3rd ed., section 6.3.2.
    """
    n = b.size
    block = np.zeros((n + 2, n + 2))
    block[:n, :n], block[:n, n], block[n, n + 1] = a * dt, b * dt, 1.0
    e = expm(block)
    return e[:n, :n], e[:n, n] - e[:n, n + 1], e[:n, n + 1]
