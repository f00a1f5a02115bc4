"""Fits a member of the family to cells: Levenberg-Marquardt on whitened residuals, the sizes k (one per scan) among the unknowns."""

from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.family import QUANTITIES, Scale, Values, level, sensed, spread
from skin_ident.criticism.scan.whitening import Whitener

STEP = 1e-4  # finite-difference step, as a share of a parameter's typical magnitude


@dataclass(frozen=True, eq=False)
class Member:
    """One member of the family: parameter values, size k of every scan (N at the deepest depth), and the names free in a fit.

    `steps` are typical magnitudes of the parameters (see `family.sizes`). `k_free` is False where a given model's level is kept as it is.
    """

    values: Values
    k: np.ndarray
    free: tuple[str, ...]
    scale: Scale
    steps: Values
    k_free: bool = True

    def predict(self, cells: Cells) -> np.ndarray:
        """Force of every cell, N."""
        return sensed(self.values, self.through(cells), cells)[0]

    def through(self, cells: Cells) -> np.ndarray:
        """Force that reaches the taxel, N."""
        return self.k[cells.scan] * level(self.values, cells.z, self.scale) * spread(self.values, cells, self.scale)

    def moved(self, **values: float) -> "Member":
        """The same with these parameter values changed."""
        return replace(self, values=self.values | values)

    def freeing(self, *names: str) -> "Member":
        """The same with more parameters free."""
        free = tuple(dict.fromkeys((*self.free, *names)))
        return replace(self, free=free)

    @property
    def unknowns(self) -> np.ndarray:
        """Values of the free parameters, the sizes last."""
        return np.array([self.values[n] for n in self.free] + (list(self.k) if self.k_free else []))

    def at(self, x: np.ndarray) -> "Member":
        """The member whose unknowns are x, clipped to their bounds."""
        cut = {n: float(np.clip(v, QUANTITIES[n].lower, QUANTITIES[n].upper)) for n, v in zip(self.free, x, strict=False)}
        k = x[len(self.free) :] if self.k_free else self.k
        return replace(self, values=self.values | cut, k=k)


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted member. `cost` is the sum of squared whitened residuals; `covariance` is that of the unknowns."""

    member: Member
    cost: float
    covariance: np.ndarray

    def std(self, name: str) -> float:
        """Standard error of a free parameter."""
        i = self.member.free.index(name)
        return float(np.sqrt(max(self.covariance[i, i], 0.0)))

    def k_std(self, scan: int) -> float | None:
        """Standard error of a size; None where it is not fitted."""
        i = len(self.member.free) + scan
        return float(np.sqrt(max(self.covariance[i, i], 0.0))) if self.member.k_free else None


def tangents(m: Member, cells: Cells, names: tuple[str, ...]) -> np.ndarray:
    """Derivatives (N, n) of the prediction by the parameters `names`: forward differences, backward at an upper bound."""
    here = m.predict(cells)
    columns = [_derivative(m, cells, here, name) for name in names]
    return np.array(columns).T.reshape(len(cells), len(names))


def _derivative(m: Member, cells: Cells, here: np.ndarray, name: str) -> np.ndarray:
    h = STEP * m.steps[name]
    value, q = m.values[name], QUANTITIES[name]
    h = -h if value + h > q.upper else h
    return (m.moved(**{name: value + h}).predict(cells) - here) / h


def by_size(m: Member, cells: Cells) -> np.ndarray:
    """Derivatives (N, scans) of the prediction by the sizes."""
    s = level(m.values, cells.z, m.scale) * spread(m.values, cells, m.scale)
    slope = sensed(m.values, m.k[cells.scan] * s, cells)[1]
    J = np.zeros((len(cells), m.k.size))
    J[np.arange(len(cells)), cells.scan] = s * slope
    return J


def jacobian(m: Member, cells: Cells) -> np.ndarray:
    """Derivatives (N, n) by all unknowns."""
    J = tangents(m, cells, m.free)
    return np.hstack([J, by_size(m, cells)]) if m.k_free else J


def fit(start: Member, cells: Cells, noise: Whitener, iterations: int = 40, tolerance: float = 1e-7) -> Fit:
    """Least-squares fit from `start`. It returns the best member found, converged or not."""
    m, damping = start, 1e-3
    e = noise.apply(cells.y - m.predict(cells))
    cost = float(e @ e)
    for _ in range(iterations):
        J = noise.apply(jacobian(m, cells))
        better = _step(m, cells, noise, J, e, cost, damping)
        if better is None:
            break
        m, e, new, damping = better
        done = cost - new <= tolerance * (cost + 1e-300)
        cost = new
        if done:
            break
    J = noise.apply(jacobian(m, cells))
    return Fit(m, cost, np.linalg.pinv(J.T @ J) if J.shape[1] else np.zeros((0, 0)))


def _step(m: Member, cells: Cells, noise: Whitener, J: np.ndarray, e: np.ndarray, cost: float, damping: float):
    """One accepted step as (member, whitened residual, cost, damping), or None where no step lowers the cost."""
    if J.shape[1] == 0:
        return None
    H, g, x = J.T @ J, J.T @ e, m.unknowns
    lift = np.maximum(np.diag(H), 1e-12 * max(np.max(np.diag(H)), 1e-300))
    for _ in range(8):
        moved = m.at(x + np.linalg.solve(H + np.diag(damping * lift), g))
        left = noise.apply(cells.y - moved.predict(cells))
        new = float(left @ left)
        if np.isfinite(new) and new < cost:
            return moved, left, new, max(damping / 10.0, 1e-9)
        damping *= 10.0
    return None
