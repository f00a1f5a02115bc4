"""Fits the thesis's own spread scans again and reports where Tables 4-8 and 4-9 do not follow from Tables 4-10 and 4-11."""

from collections.abc import Iterator

import numpy as np

from skin_ident.spread_fit import GaussianFit, fit_gaussian
from skin_ident.spread_scan import SpreadScan
from skin_models.thesis.comparison import Comparison, Disagreement, compare, disagreements_of
from skin_models.thesis.tables import scan, table

CENTRE = 12e-3  # m, where the thesis puts the taxel
SCANS = {"4-8": "4-10", "4-9": "4-11"}  # table of fits: table of the scan that was fitted
NAMES = {"4-10": "silicone 4 mm (thesis Table 4-10)", "4-11": "Frubber 4 mm (thesis Table 4-11)"}

_TYPO = "a of 9.28 goes with the printed c and R^2; no rounding of the scan gives 9.23: one digit misprinted"
_COPIED = "Table 4-11's row is a copy of a silicone row of Table 4-10, not the scan that was fitted"


def thesis_scan(name: str) -> SpreadScan:
    """Table `4-10` (silicone) or `4-11` (Frubber) as a scan."""
    return SpreadScan(*scan(name), name=NAMES[name])


def spread_comparisons() -> list[Comparison]:
    """Printed and recomputed a, c and R^2 for every depth of Tables 4-8 and 4-9. Rows printed as NA are left out."""
    return [c for fits, scans in SCANS.items() for c in _rows(fits, scans)]


def spread_disagreements() -> list[Disagreement]:
    """The entries of Tables 4-8 and 4-9, and of the text about them, that do not follow from their scans."""
    return disagreements_of([*spread_comparisons(), _centre_error()])


def _rows(fits: str, scans: str) -> Iterator[Comparison]:
    distance = scan(scans)[1]
    for depth, printed in table(fits).rows.items():
        if printed["a"] is None:
            continue
        forces = list(table(scans).rows[depth].values())
        for entry, unit in (("a", 1.0), ("c", 1e3), ("r2", 1.0)):
            note = _COPIED if scans == "4-11" else _TYPO if (depth, entry) == ("0.90", "a") else ""
            recompute = lambda f, key=entry, u=unit: u * getattr(_fit(distance, f), key)  # noqa: E731
            yield compare(fits, f"{depth} mm {entry}", printed[entry], recompute, forces, note)


def _fit(distance: np.ndarray, force: np.ndarray) -> GaussianFit:
    return fit_gaussian(distance, force, centre=CENTRE)


def _centre_error() -> Comparison:
    """Section 4.3.4: the fitted a of Table 4-9 falls short of the force at the centre by 12.6 % on average."""
    rows = [depth for depth, cells in table("4-9").rows.items() if cells["a"] is not None]
    fitted = [table("4-9").cell(depth, "a") for depth in rows]
    centre = [table("4-11").cell(depth, "0") for depth in rows]

    def shortfall(x: np.ndarray) -> float:
        a, f = np.split(x, 2)
        return 100.0 * float(np.mean((f - a) / f))

    note = f"Table 4-9's a exceeds Table 4-11's force at the centre, which the text excludes; {_COPIED}"
    return compare("text", "centre_error_frubber, %", table("text").cell("centre_error_frubber", "value"), shortfall, fitted + centre, note)
