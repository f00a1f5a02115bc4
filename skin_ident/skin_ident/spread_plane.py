"""Fits the Gaussian spread over taxels in a plane to what each of them feels of one contact, weighted by the standard errors.

f(x, y) = a exp(-((x - bx)^2 + (y - by)^2) / c^2)
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

FEWEST_TAXELS = 5  # taxels needed for four unknowns


@dataclass(frozen=True)
class PlaneFit:
    """a (in the unit of f), bx, by, c (m) with their standard errors; weighted r2. `reason` is empty, or says why there is no fit."""

    a: float
    bx: float
    by: float
    c: float
    std: tuple[float, float, float, float]
    r2: float
    reason: str = ""

    def as_dict(self) -> dict[str, object]:
        """The fit as a dictionary, with units in the names."""
        if self.reason:
            return {"reason": self.reason}
        names = ("a", "x_mm", "y_mm", "c_mm")
        values = (self.a, 1e3 * self.bx, 1e3 * self.by, 1e3 * self.c)
        errors = (self.std[0], *(1e3 * s for s in self.std[1:]))
        return {n: {"value": v, "std": s} for n, v, s in zip(names, values, errors, strict=True)} | {"r2": self.r2}


def fit_plane(positions: np.ndarray, felt: np.ndarray, std: np.ndarray) -> PlaneFit:
    """Weighted least squares over (T, 2) positions (m) and (T,) values with their standard errors.

    Where the residuals are larger than `std` says, the standard errors are enlarged to match. Where they are smaller, as for values on a
    coarse grid, the standard errors are kept.
    """
    nan = float("nan")
    if felt.size < FEWEST_TAXELS or np.linalg.matrix_rank(positions - positions.mean(axis=0), tol=1e-9) < 2:
        return PlaneFit(nan, nan, nan, nan, (nan,) * 4, nan, f"needs {FEWEST_TAXELS} taxels that lie not all on one line")
    if not felt.max() > 0.0:
        return PlaneFit(nan, nan, nan, nan, (nan,) * 4, nan, "nothing is felt")
    weight = 1.0 / np.maximum(std, 1e-6 * np.abs(felt).max())

    def residual(p: np.ndarray) -> np.ndarray:
        return weight * (p[0] * np.exp(-np.sum((positions - p[1:3]) ** 2, axis=1) / p[3] ** 2) - felt)

    found = least_squares(residual, _start(positions, felt), x_scale="jac")
    scatter = 2.0 * found.cost / max(1, felt.size - 4)
    errors = np.sqrt(np.diag(np.linalg.pinv(found.jac.T @ found.jac)) * max(1.0, scatter))
    mean = np.average(felt, weights=weight**2)
    r2 = 1.0 - 2.0 * found.cost / float(np.sum((weight * (felt - mean)) ** 2))
    a, bx, by, c = (float(v) for v in found.x)
    if abs(c) > 10.0 * np.ptp(positions, axis=0).max():
        return PlaneFit(nan, nan, nan, nan, (nan,) * 4, nan, "what is felt does not fall with distance")
    return PlaneFit(a, bx, by, abs(c), tuple(float(e) for e in errors), float(r2))


def _start(positions: np.ndarray, felt: np.ndarray) -> np.ndarray:
    """Initial values: centre and width from moments."""
    share = np.maximum(felt, 0.0) / np.maximum(felt, 0.0).sum()
    centre = share @ positions
    width = np.sqrt(max(float(share @ np.sum((positions - centre) ** 2, axis=1)), 1e-12))
    return np.array([felt.max(), *centre, width])
