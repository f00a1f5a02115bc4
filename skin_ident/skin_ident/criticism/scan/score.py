"""The score of a cause: a log-likelihood ratio (twice nats), corrected for noise estimated from few rows or columns, less a charge.

The estimate of a cause's size is a weighted sum of the cells. Its variance has three parts: independent noise of the cells, placing errors
of the columns and repeat errors of the rows. Each is estimated with its own number of degrees of freedom. By Satterthwaite's rule the sum
has about

    nu = (v_cells + v_columns + v_rows)^2 / (v_cells^2 / nu_cells + v_columns^2 / nu_columns + v_rows^2 / nu_rows)

degrees of freedom. A fall of the cost then counts as nu log(1 + fall / nu): the likelihood ratio when the variance is estimated too.

Source: F. E. Satterthwaite, Biometrics Bulletin 2 (1946) 110-114.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.fitting import Fit, jacobian
from skin_ident.criticism.scan.whitening import Noise, Whitener

CHARGE = 5.0  # twice nats, subtracted once per cause: before the gate, about one false name in a hundred scans is left
COARSE = 8.0  # twice nats, subtracted too where converter steps are most of the noise: they repeat with the force, as a cause does
USED = 5  # the most degrees of freedom of columns or rows that the family's parameters use up


@dataclass(frozen=True, eq=False)
class Judge:
    """Scores fits in one noise, whose overall scale is estimated with `spare` degrees of freedom. `coarse` says whether converter steps are
    most of that noise."""

    noise: Noise
    whitener: Whitener
    cells: Cells
    spare: int
    coarse: bool = False

    def score(self, fall: float, after: Fit, names: tuple[str, ...], count: int) -> float:
        """Score (twice nats) of a fall of the cost in the fit `after`, brought by `count` more unknowns, `names` among them."""
        if fall <= 0.0 or count == 0:
            return -self.charge
        return worth(fall, self.degrees(after, names)) - count * float(np.log(len(self.cells))) - self.charge

    @property
    def charge(self) -> float:
        """Charge of a cause (twice nats), besides the charge log N for each of its parameters."""
        return CHARGE + COARSE * self.coarse

    def degrees(self, after: Fit, names: tuple[str, ...]) -> float:
        """The smallest number of degrees of freedom of the variance of any estimate of `names` (of the sizes where none is free)."""
        n, m = self.noise, after.member
        if n.placing == 0.0 and n.repeat == 0.0:
            return float(self.spare)
        J = jacobian(m, self.cells)
        W = self.whitener.apply(J)
        weights = self.whitener.solve(J) @ np.linalg.pinv(W.T @ W)  # (N, unknowns): each estimate is weights.T @ y
        picked = [m.free.index(name) for name in names if name in m.free] or list(range(len(m.free), weights.shape[1]))
        return min(self._degrees(weights[:, i]) for i in picked) if picked else float(self.spare)

    def _degrees(self, w: np.ndarray) -> float:
        n = self.noise
        parts = [float(w @ (n.variance() * w)), _grouped(w * n.placing * n.slope, n.column), _grouped(w * n.repeat * n.through, n.row)]
        known = [self.spare, max(np.unique(n.column).size - USED, 2), max(np.unique(n.row).size - USED, 2)]
        return sum(parts) ** 2 / max(sum(p * p / k for p, k in zip(parts, known, strict=True)), 1e-300)


def _grouped(x: np.ndarray, group: np.ndarray) -> float:
    return float(np.sum(np.bincount(group, x) ** 2))


def worth(fall: float, degrees: float) -> float:
    """Log-likelihood ratio (twice nats) of a fall of the cost, in a noise whose variance is estimated with `degrees` of freedom."""
    degrees = max(degrees, 1.0)
    return degrees * float(np.log1p(max(fall, 1e-9) / degrees))
