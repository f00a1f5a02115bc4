"""The noise model of a scan, and how to whiten with it.

    independent in each cell    variance sigma^2 + (relative * force)^2, larger for outliers (Huber's weights)
    common to a column          the plunger stood `placing` m (rms) beside the distance that the column says
    common to a row             the plunger went `repeat` (relative, rms) deeper or less deep, or the skin was that much stiffer

A placing error bends every row alike, as another spread would. A repeat error changes the level, as another stiffness would. Taking them
for white noise would lead to causes that are not there.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve, cholesky, solve_triangular


@dataclass(frozen=True, eq=False)
class Whitener:
    """Whitens by `factor`, the lower Cholesky factor of the covariance (N, N), or by the standard deviations `sd` (N,) where it is None."""

    sd: np.ndarray
    factor: np.ndarray | None = None

    def apply(self, x: np.ndarray) -> np.ndarray:
        """Whitened residual (N,) or regressors (N, k)."""
        if self.factor is not None:
            return solve_triangular(self.factor, x, lower=True, check_finite=False)
        return x / self.sd if x.ndim == 1 else x / self.sd[:, None]

    def solve(self, x: np.ndarray) -> np.ndarray:
        """The inverse of the covariance times (N, k)."""
        if self.factor is not None:
            return cho_solve((self.factor, True), x, check_finite=False)
        return x / self.sd[:, None] ** 2


@dataclass(frozen=True, eq=False)
class Noise:
    """The noise of all cells. `slope` (N,) is d force / d distance, N/m; `through` (N,) is the force that reaches the taxel, N; `weight`
    (N,) is 1, less for an outlier."""

    sigma: float
    relative: float
    placing: float
    repeat: float
    slope: np.ndarray
    through: np.ndarray
    weight: np.ndarray
    row: np.ndarray
    column: np.ndarray

    def variance(self) -> np.ndarray:
        """Variance (N,) of the independent noise of every cell, N^2."""
        return (self.sigma**2 + (self.relative * self.through) ** 2) / self.weight

    def total(self) -> np.ndarray:
        """Standard deviation (N,) of every cell, placing and repeat errors included, N."""
        return np.sqrt(self.variance() + (self.placing * self.slope) ** 2 + (self.repeat * self.through) ** 2)

    def whitener(self, keep: np.ndarray | None = None) -> Whitener:
        """The whitener for the cells of a mask (N,), default all."""
        keep = np.ones(self.row.size, bool) if keep is None else keep
        v = self.variance()[keep]
        if self.placing == 0.0 and self.repeat == 0.0:
            return Whitener(np.sqrt(v))
        U = self.shared()[keep]
        return Whitener(np.sqrt(v), cholesky(np.diag(v) + U @ U.T, lower=True, check_finite=False))

    def shared(self) -> np.ndarray:
        """Matrix (N, columns + rows) such that shared() @ shared().T is the covariance due to placing and repeat errors."""
        return np.hstack([_blocks(self.placing * self.slope, self.column), _blocks(self.repeat * self.through, self.row)])


def _blocks(value: np.ndarray, group: np.ndarray) -> np.ndarray:
    """(N, groups) with each value in the column of its group; no column where all are zero."""
    names, index = np.unique(group, return_inverse=True)
    if not np.any(value):
        return np.zeros((value.size, 0))
    U = np.zeros((value.size, names.size))
    U[np.arange(value.size), index] = value
    return U
