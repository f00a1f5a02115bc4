"""The thesis as measured data: what its spread model gets wrong on its own scan, and every entry of its tables that cannot be right."""

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

RISE = 2.5  # steps of the converter by which a force may rise with distance before it is told


def thesis_findings() -> list[Disagreement]:
    """`data_error` in the thesis: every printed entry that its own data cannot give, whatever was rounded.

    Averages and texts against the runs, fits against the scans, copied rows, readings on no level of the converter, and forces that rise
    with distance. Source: thesis Tables 3-1, 3-2, 4-1 to 4-11.
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
    """Neighbouring readings of one depth of which the farther one is greater by several steps."""
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
    """RMSE (N) on distances not fitted, of depths not used for the shape (but for the first, which has a shape of its own).

    table_4_8   a Gaussian with a and c of its own at every depth, as Table 4-8, fitted to every other distance
    gaussian    one width for all depths, fitted to the other depths; a fitted to every other distance
    extended    the extended shape likewise
    `linear` and `nonlinear` predict whole depths left out, with one stiffness for all and with the extended level and shape.
    """

    table_4_8: float
    gaussian: float
    extended: float
    linear: float
    nonlinear: float


def thesis_spread() -> tuple[Outcome, SpreadGain]:
    """The diagnosis of Table 4-10, and what the extension gains held out by depth."""
    scan = thesis_scan("4-10")
    outcome = diagnose_scans([scan])
    shape = next(f for f in outcome.findings["findings"] if f["cause"] == "spread_shape")["gain"]
    whole = [outcome.findings[part]["rmse"]["taxel_0"]["held_out"] for part in ("baseline", "extended")]
    own = _own_gaussians(scan)
    return outcome, SpreadGain(own, shape["held_out_rmse_before"], shape["held_out_rmse_after"], *whole)


def _own_gaussians(scan: SpreadScan) -> float:
    """RMSE of a Gaussian per depth, fitted to every other distance, at the distances between; N."""
    e = []
    for force in scan.force:
        for half in (0, 1):
            fitted = np.arange(force.size) % 2 == half
            f = fit_gaussian(scan.distance[fitted], force[fitted])
            e.append(force[~fitted] - f(scan.distance[~fitted]))
    return float(np.sqrt(np.mean(np.concatenate(e) ** 2)))
