"""Whether the residual is still systematic when every named cause is in the model.

The tangents of all excited parameters are fitted to the residual of all depths but one, and predict the residual of that one; then the
same over distances. If both predictions succeed, something systematic is left that no named cause explains. A residual that repeats at
the same distances, but cannot be predicted from neighbouring distances, is explained as well by placing errors of the plunger.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.scan.fitting import by_size, tangents
from skin_ident.criticism.scan.gate import FEWEST_GROUPS, RESAMPLES
from skin_ident.criticism.scan.search import Search
from skin_ident.criticism.scan.trials import Setting
from skin_ident.criticism.scan.whitening import Noise

SYSTEMATIC = 0.03  # relative fall of the held-out mean square above which the residual counts as systematic
DOUBT = 1.0  # percentile of the bootstrapped fall that must be above zero


@dataclass(frozen=True)
class Rest:
    """Relative fall of the held-out mean square and its lower 99 % bound, over depths and over distances; NaN where there are too few."""

    depths: tuple[float, float]
    distances: tuple[float, float]

    @property
    def is_systematic(self) -> bool:
        """Whether the residual can be predicted over depths and over distances, so that something is unexplained."""
        tested = [t for t in (self.depths, self.distances) if np.isfinite(t[0])]
        return bool(tested) and all(lower > 0.0 and fall > SYSTEMATIC for fall, lower in tested)


def systematic_rest(found: Search, s: Setting) -> Rest:
    """How much of the residual the tangents of the family predict on depths and distances left out."""
    m, cells = found.extended.member, s.cells
    names = tuple(dict.fromkeys((*m.free, *s.rich)))
    J = np.hstack([tangents(m, cells, names), by_size(m, cells)])
    J = J / np.maximum(np.linalg.norm(J, axis=0), 1e-300)
    e = cells.y - m.predict(cells)
    return Rest(*(_predicted(J, e, found.noise.noise, group) for group in (cells.row, cells.column)))


def _predicted(J: np.ndarray, e: np.ndarray, noise: Noise, group: np.ndarray) -> tuple[float, float]:
    names, index = np.unique(group, return_inverse=True)
    if names.size < FEWEST_GROUPS:
        return float("nan"), float("nan")
    after = np.empty_like(e)
    for g in range(names.size):
        out = index == g
        whitener = noise.whitener(~out)
        z = np.linalg.lstsq(whitener.apply(J[~out]), whitener.apply(e[~out]), rcond=1e-6)[0]
        after[out] = e[out] - J[out] @ z
    weight = 1.0 / noise.total() ** 2
    sums = [np.bincount(index, x**2 * weight) for x in (e, after)]
    draws = np.random.default_rng(0).integers(0, names.size, (RESAMPLES, names.size))
    falls = 1.0 - sums[1][draws].sum(axis=1) / np.maximum(sums[0][draws].sum(axis=1), 1e-300)
    return float(1.0 - sums[1].sum() / max(sums[0].sum(), 1e-300)), float(np.percentile(falls, DOUBT))
