"""`fit` of static spread scans: the Gaussian of every depth (thesis section 4.3.4, Tables 4-8 and 4-9), as a table and as JSON."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skin_ident.cli import common
from skin_ident.criticism.usable import named_apart
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.figures import plus_minus
from skin_ident.spread_fit import GaussianFit, fit_spread
from skin_ident.spread_scan import SpreadScan

GOOD = 0.9  # R² below which the Gaussian is called poor


def fit_scans(scans: Sequence[SpreadScan], out: str | None) -> int:
    """Print a, c and, where both sides were scanned, b of every depth; write fit.json, with scans of one name numbered in
    the order given. Raises `FitError` where no depth can be fitted."""
    found = {}
    for scan in named_apart(list(scans)):
        step = scan.declared.of_taxel("taxel_step_n", 0) or 0.0
        both = bool(np.any(scan.distance < 0.0))
        fits = fit_spread(scan, step=step, noise=scan.declared.of_taxel("taxel_noise_n", 0) or 0.0, free_centre=both)
        if all(f.reason for f in fits):
            raise FitError(f"{scan.name}: {fits[0].reason}, at any depth")
        print("\n".join(_table(scan, fits, both, step)))
        found[scan.name] = [_entry(float(depth), f, both) for depth, f in zip(scan.depth, fits, strict=True)]
    if out:
        path = common.output_folder(out) / "fit.json"
        common.write_json(path, {"schema": 1, "method": "Gaussian spread, least squares", "scans": found})
        common.say(f"wrote {path}")
    return 0


def _table(scan: SpreadScan, fits: Sequence[GaussianFit], both: bool, step: float) -> list[str]:
    steps = f", converter steps of {step:g} N" if step else ""
    lines = [f"{scan.name}: Gaussian spread f(x) = a exp(-((x - b) / c)²), {len(fits)} depths{steps} (± 95 %)"]
    lines.append(f"  {'depth mm':>9} {'a N':>16} {'c mm':>16} {'b mm' if both else '':>16} {'R²':>8}")
    for depth, f in zip(scan.depth, fits, strict=True):
        if f.reason:
            lines.append(f"  {1e3 * depth:>9.3g} no fit: {f.reason}")
            continue
        a, b, c = _pair(f, "a", 1.0), _pair(f, "b", 1e3) if both else "", _pair(f, "c", 1e3)
        poor = "  poor: the spread is no Gaussian, or mostly noise" if f.r2 < GOOD else ""
        lines.append(f"  {1e3 * depth:>9.3g} {a:>16} {c:>16} {b:>16} {f.r2:>8.4f}{poor}")
    return lines


def _pair(f: GaussianFit, name: str, unit: float) -> str:
    return plus_minus(unit * getattr(f, name), unit * f.half_width(name))


def _entry(depth: float, f: GaussianFit, both: bool) -> dict[str, Any]:
    head = {"depth_mm": 1e3 * depth}
    if f.reason:
        return head | {"reason": f.reason}
    known = {"a_n": {"value": f.a, "std": f.a_std}, "c_mm": {"value": 1e3 * f.c, "std": 1e3 * f.c_std}}
    known |= {"r2": f.r2, "degrees_of_freedom": f.dof}
    return head | known | ({"b_mm": {"value": 1e3 * f.b, "std": 1e3 * f.b_std}} if both else {})
