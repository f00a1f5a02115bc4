"""A robust fit of a table that is as precise as its readings, to find outliers within the tolerance of the rough fit.

All excited parameters of the family are fitted with Tukey's weights. The tolerance of a reading is the scatter of the other readings:
sigma from the smaller half of the forces, and an error proportional to the force from the larger half.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.scan.candidates import excited, rich
from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.fitting import fit
from skin_ident.criticism.scan.rough import ROUNDS, TUKEY, Rough
from skin_ident.criticism.scan.whitening import Whitener
from skin_ident.estimators.scale import normal_scale

SPARE = 3  # cells per unknown; with fewer the fit follows single readings, and the scatter says nothing


def sharpened(cells: Cells, table: Rough) -> Rough | None:
    """The more precise fit, started from the rough one `table`; None where there are too few cells."""
    m = table.member.freeing(*rich(excited(cells, False, False)))
    if len(cells) < SPARE * m.unknowns.size:
        return None
    found = replace(table, member=m)
    for _ in range(ROUNDS):
        weight = np.maximum(1.0 - (found.strangeness(cells) / TUKEY) ** 2, 0.0) ** 2 + 1e-6
        m = fit(m, cells, Whitener(1.0 / np.sqrt(weight)), 15, 1e-4).member
        expected = m.predict(cells)
        sigma, relative = _scatter(cells.y - expected, expected, table.floor, m.unknowns.size)
        found = replace(table, member=m, expected=expected, sigma=sigma, relative=relative)
    return found


def _scatter(e: np.ndarray, expected: np.ndarray, floor: float, unknowns: int) -> tuple[float, float]:
    """Standard deviation of residuals `e` (N,): the part that does not depend on the force, in N, and the part proportional to it."""
    size = np.abs(expected)
    large = size > np.median(size)
    inflated = np.sqrt(e.size / (e.size - unknowns))
    sigma = max(inflated * normal_scale(e[~large]), floor, 1e-9)
    above = inflated * normal_scale(e[large]) if large.any() else 0.0
    return sigma, float(np.sqrt(max(above**2 - sigma**2, 0.0)) / max(np.median(size[large]), 1e-12)) if large.any() else 0.0
