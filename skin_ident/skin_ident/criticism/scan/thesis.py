"""The thesis's tables as measured data: what its spread model gets wrong on its own scan, and every entry that cannot be right."""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.scan.diagnose import diagnose_scans
from skin_ident.criticism.scan.levels import find_levels
from skin_ident.criticism.telling.outcome import Outcome
from skin_ident.spread_fit import fit_gaussian
from skin_ident.spread_scan import SpreadScan
from skin_ident.thesis_spread import spread_disagreements, thesis_scan
from skin_models.thesis import disagreements
from skin_models.thesis.comparison import Disagreement
from skin_models.thesis.tables import table

RISE = 2.5  # converter steps by which a force may rise with distance before that is reported


def thesis_findings() -> list[Disagreement]:
    """`data_error` in the thesis: every printed entry that contradicts the thesis's own data by more than rounding.

    Averages and texts are compared with the runs, and fits with the scans. Copied rows, readings on no level of the converter and forces
    that rise with distance are listed too. Source: thesis Tables 3-1, 3-2, 4-1 to 4-11.
    """
    found = [*disagreements(), *spread_disagreements(), *_off_level("4-10"), *_rising("4-10")]
    return [d for d in found if not d.within_rounding]


def _off_level(name: str) -> list[Disagreement]:
    scan, t = thesis_scan(name), table(name)
    levels = find_levels(scan.force.ravel())
    why = f"on no level of the converter, whose steps are {levels.step:.3g} N: misread or misprinted" if levels else ""
    cells = [divmod(int(i), scan.distance.size) for i in (levels.off if levels else ())]
    rows, columns = list(t.rows), t.columns
    return [Disagreement(name, f"{rows[d]} mm, {columns[j]} mm", str(t.cell(rows[d], columns[j])), "unknown", why, False) for d, j in cells]


def _rising(name: str) -> list[Disagreement]:
    """Pairs of neighbouring readings of one depth where the farther one is greater by more than RISE steps."""
    scan, t = thesis_scan(name), table(name)
    levels = find_levels(scan.force.ravel())
    rise = np.diff(scan.force, axis=1) / (levels.step if levels else np.inf)
    rows, columns = list(t.rows), t.columns
    return [
        Disagreement(
            name,
            f"{rows[d]} mm, {columns[j]} and {columns[j + 1]} mm",
            f"{t.cell(rows[d], columns[j])} {t.cell(rows[d], columns[j + 1])}",
            "falling",
            f"the force rises by {rise[d, j]:.1f} steps farther from the taxel: exchanged, they would fit their neighbours",
            False,
        )
        for d, j in zip(*np.nonzero(rise > RISE), strict=True)
    ]


@dataclass(frozen=True)
class SpreadGain:
    """Held-out RMSE (N) of five models. The first three predict distances that were not fitted:

    table_4_8   a Gaussian with amplitude a and width c at every depth, as in Table 4-8, both fitted to every other distance
    gaussian    one width for all depths, fitted to the other depths; only a is fitted to every other distance
    extended    the same with the extended shape

    The last two predict whole depths that were left out:

    linear      one stiffness for all depths, Gaussian spread
    nonlinear   the extended level and shape
    """

    table_4_8: float
    gaussian: float
    extended: float
    linear: float
    nonlinear: float


def thesis_spread() -> tuple[Outcome, SpreadGain]:
    """The diagnosis of Table 4-10, and the held-out errors of the models that it compares."""
    scan = thesis_scan("4-10")
    outcome = diagnose_scans([scan])
    shape = next(f for f in outcome.findings["findings"] if f["cause"] == "spread_shape")["gain"]
    whole = [outcome.findings[part]["rmse"]["taxel_0"]["held_out"] for part in ("baseline", "extended")]
    own = _own_gaussians(scan)
    return outcome, SpreadGain(own, shape["held_out_rmse_before"], shape["held_out_rmse_after"], *whole)


def _own_gaussians(scan: SpreadScan) -> float:
    """RMSE (N) of one Gaussian per depth, fitted to every other distance and evaluated at the distances between."""
    e = []
    for force in scan.force:
        for half in (0, 1):
            fitted = np.arange(force.size) % 2 == half
            f = fit_gaussian(scan.distance[fitted], force[fitted])
            e.append(force[~fitted] - f(scan.distance[~fitted]))
    return float(np.sqrt(np.mean(np.concatenate(e) ** 2)))
