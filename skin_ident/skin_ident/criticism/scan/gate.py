"""The gate: a cause is named only where depths and distances that were not used to fit it are predicted better.

Every depth is left out in turn, then every distance (or, where scans are held out, those scans are predicted instead).

-   Where the cause bends the level or the reading, all cells of a depth that was left out are predicted.
-   Where it bends the spread, the size of that depth is first fitted to every other column, and the columns between are predicted. Where
    the cause does not pass this test, it may pass by predicting the depth without that fit.
-   All cells of a distance that was left out are predicted.

The squared errors are resampled in blocks, one per depth (or distance): B. Efron, R. Tibshirani, An Introduction to the Bootstrap, 1993,
ch. 8.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from skin_ident.criticism.scan.candidates import Candidate
from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.fitting import Member, fit
from skin_ident.criticism.scan.whitening import Noise

RESAMPLES = 1000  # bootstrap draws of the groups (depths or distances)
DOUBT = 10.0  # percentile of the resampled gain that must be above zero
FEWEST_GROUPS = 4  # groups needed for a meaningful bootstrap
ITERATIONS, TOLERANCE = 4, 1e-3  # of a fit without one group, which begins at the fit to all cells
SIZED_AGAIN, WHOLE = "spread", "whole"  # a depth left out: its size is fitted to every other distance, or all of it is predicted


@dataclass(frozen=True, eq=False)
class Test:
    """How to hold out: `held` are cells of scans never used to fit; without them depths and distances are left out in turn. `start` is
    the baseline from which the search begins."""

    __test__ = False  # tells pytest that this is no test class

    start: Member
    held: Cells | None = None
    known: dict = field(default_factory=dict)  # cache of held-out errors, by model


@dataclass(frozen=True)
class Gain:
    """Held-out RMSE before and after, N, and the 95 % interval of its fall. `relative` is the relative fall of the weighted mean square
    over depths left out, `lower` its lower bound (percentile DOUBT), `across` the fall over distances left out (NaN where there are too
    few). `held_out` says in words what was left out."""

    before: float
    after: float
    ci95: tuple[float, float]
    relative: float
    lower: float
    across: float
    held_out: str

    @property
    def passed(self) -> bool:
        """Whether depths left out are predicted better (at the percentile DOUBT), distances left out too, and the RMSE in newtons falls."""
        across_too = not np.isfinite(self.across) or self.across > 0.0
        return self.lower > 0.0 and across_too and self.after < self.before


def gain_of(before: Member, after: Member, c: Candidate, noise: Noise, cells: Cells, test: Test) -> Gain:
    """The gain of `after` over `before` on cells that neither was fitted to."""
    if c.bends != "spread":
        return _gain_by(before, after, WHOLE, noise, cells, test)
    gain = _gain_by(before, after, SIZED_AGAIN, noise, cells, test)
    whole = gain if gain.passed else _gain_by(before, after, WHOLE, noise, cells, test)
    return whole if whole.passed else gain


def _gain_by(before: Member, after: Member, how: str, noise: Noise, cells: Cells, test: Test) -> Gain:
    if test.held is not None:
        errors = [held_scans(m, test.held, how) for m in (before, after)]
        return _gain(errors, np.ones(len(test.held)), test.held.row, np.nan, "the scans held out")
    weight = 1.0 / noise.total() ** 2
    errors = [left_out(m, cells, noise, cells.row, how, test) for m in (before, after)]
    across = [left_out(m, cells, noise, cells.column, WHOLE, test) for m in (before, after)]
    fall = _fall(across, weight) if np.unique(cells.column).size >= FEWEST_GROUPS else np.nan
    words = "each depth in turn" + (", its size fitted to every other distance" if how == SIZED_AGAIN else "")
    if np.unique(cells.row).size < FEWEST_GROUPS:
        return _gain(across, weight, cells.column, fall, "each distance in turn")
    return _gain(errors, weight, cells.row, fall, words)


def left_out(m: Member, cells: Cells, noise: Noise, groups: np.ndarray, how: str, test: Test | None = None) -> np.ndarray:
    """Errors (N,), in N, of cells predicted by a fit to all other groups."""
    key = (m.free, m.k_free, tuple(m.values.items()), how, groups is cells.row, id(noise))
    if test is not None and key in test.known:
        return test.known[key][1]
    e = np.empty(len(cells))
    for g in np.unique(groups):
        out = groups == g
        fitted = fit(m, cells.only(~out), noise.whitener(~out), ITERATIONS, TOLERANCE).member
        e[out] = _errors(fitted, cells.only(out), how)
    if test is not None:
        test.known[key] = (noise, e)  # the noise is kept alive, so that its id stays its own
    return e


def held_scans(m: Member, held: Cells, how: str) -> np.ndarray:
    """Errors (N,), in N, in scans that were not fitted. The skin's stiffness there is unknown, so the size is fitted to every other column
    and the columns between are predicted: per depth for SIZED_AGAIN, per scan for WHOLE."""
    group = held.row if how == SIZED_AGAIN else held.scan
    as_first = replace(held, scan=np.zeros(len(held), int))  # which fitted size it begins with does not matter: each part is scaled to fit
    e = np.empty(len(held))
    for part in (group == g for g in np.unique(group)):
        e[part] = _errors(m, as_first.only(part), SIZED_AGAIN)
    return e


def _errors(m: Member, out: Cells, how: str) -> np.ndarray:
    if how == WHOLE:
        return out.y - m.predict(out)
    e = np.empty(len(out))
    by_distance = np.argsort(np.argsort(out.column, kind="stable"), kind="stable") % 2
    for half in (0, 1):
        seen, asked = out.only(by_distance == half), out.only(by_distance != half)
        e[by_distance != half] = asked.y - resized(m, seen).predict(asked)
    return e


def resized(m: Member, seen: Cells) -> Member:
    """`m` with all sizes multiplied by the factor, never negative, that fits the cells `seen` best."""
    factor = 1.0
    for _ in range(3 if m.values["threshold"] or np.isfinite(m.values["ceiling"]) else 1):
        now = replace(m, k=m.k * factor)
        through = now.through(seen)
        e = seen.y - now.predict(seen)
        factor = max(factor * (1.0 + float(e @ through) / max(float(through @ through), 1e-300)), 0.0)
    return replace(m, k=m.k * factor)


def _fall(errors: list[np.ndarray], weight: np.ndarray) -> float:
    before, after = ((e**2 * weight).sum() for e in errors)
    return float(1.0 - after / max(before, 1e-300))


def _gain(errors: list[np.ndarray], weight: np.ndarray, groups: np.ndarray, across: float, words: str) -> Gain:
    index = np.unique(groups, return_inverse=True)[1]
    n = index.max() + 1
    draws = np.random.default_rng(0).integers(0, n, (RESAMPLES, n))
    weighted = [np.bincount(index, e**2 * weight)[draws].sum(axis=1) for e in errors]
    count = np.bincount(index)[draws].sum(axis=1)
    rms = [np.sqrt(np.bincount(index, e**2)[draws].sum(axis=1) / count) for e in errors]
    falls = 1.0 - weighted[1] / np.maximum(weighted[0], 1e-300)
    low, high = np.percentile(rms[0] - rms[1], [2.5, 97.5])
    before, after = (float(np.sqrt(np.mean(e**2))) for e in errors)
    return Gain(before, after, (float(low), float(high)), _fall(errors, weight), float(np.percentile(falls, DOUBT)), across, words)
