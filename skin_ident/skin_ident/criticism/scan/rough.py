"""A rough, robust fit of a table, made before any reading is trusted, and good enough to see which readings do not belong in it."""

from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.scan.candidates import FEWEST_DISTANCES
from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.fitting import Member, fit
from skin_ident.criticism.scan.start import zeroed_start
from skin_ident.criticism.scan.whitening import Whitener
from skin_ident.estimators.scale import normal_scale

ROUNDS = 6  # of iterative reweighting
TUKEY = 4.7  # standard deviations beyond which a reading has practically no weight (Tukey's biweight)
OF_FORCE = 0.03  # model error of any spread, as a share of the force
WILD = 3.0  # a row or column that is this many times larger or smaller than the others is not fitted


@dataclass(frozen=True, eq=False)
class Rough:
    """Expected force (N,) and noise `sigma` (N), from a fit that is robust against single bad rows, columns and cells."""

    member: Member
    expected: np.ndarray
    sigma: float
    relative: float = OF_FORCE
    floor: float = 0.0  # lower bound of sigma from the converter's step, N

    def strangeness(self, cells: Cells) -> np.ndarray:
        """Residual over its tolerance, (N,)."""
        return (cells.y - self.expected) / self.tolerance

    def only(self, keep: np.ndarray) -> "Rough":
        """The same for the cells of a mask (N,)."""
        return replace(self, expected=self.expected[keep])

    @property
    def tolerance(self) -> np.ndarray:
        """Standard deviation of a reading about the expected force (N,), in N: the noise and the model error."""
        return np.hypot(self.sigma, self.relative * np.abs(self.expected))


def rough(cells: Cells, floor: float) -> Rough:
    """A robust fit of level, shape, offset, centre and anisotropy, as far as the scans excite them, with Tukey's weights. `floor` is the
    lower bound of sigma, N."""
    calm = ~_wild_rows(cells)
    calm[calm] = ~_wild_columns(cells.only(calm))
    believed = cells.only(calm)
    m = zeroed_start(believed).freeing("exponent", "offset")
    m = m.freeing("power", "tail") if np.unique(np.abs(cells.r)).size >= FEWEST_DISTANCES else m
    m = m.freeing("centre") if cells.r.min() < 0.0 < cells.r.max() else m
    m = m.freeing("ratio") if np.unique(cells.along[cells.along != 0.0]).size > 1 else m
    m = replace_sizes_for(m, cells)
    weight, sigma = np.ones(len(believed)), 1.0
    for _ in range(ROUNDS):
        m = fit(m, believed, Whitener(1.0 / np.sqrt(weight)), 15, 1e-4).member
        e = believed.y - m.predict(believed)
        sigma = max(normal_scale(e), floor, 1e-9)
        allowed = np.hypot(sigma, OF_FORCE * np.abs(m.through(believed)))
        weight = np.maximum(1.0 - (e / (TUKEY * allowed)) ** 2, 0.0) ** 2 + 1e-6
    return Rough(m, m.predict(cells), sigma, floor=floor)


def replace_sizes_for(m: Member, cells: Cells) -> Member:
    """`m` with a size for every scan of `cells`; a scan that was not fitted gets the median size."""
    scans = int(cells.scan.max()) + 1
    k = np.array([m.k[i] if i < m.k.size and m.k[i] else np.median(m.k) for i in range(scans)])
    return replace(m, k=k)


def _wild_rows(cells: Cells) -> np.ndarray:
    """Mask (N,) of cells in rows whose force per depth differs from the scan's median by more than a factor WILD."""
    wild = np.zeros(len(cells), bool)
    for s in cells.scans:
        rows = np.unique(cells.row[cells.scan == s])
        size = np.array([_top(cells.y[cells.row == d]) / cells.z[cells.row == d][0] for d in rows])
        usual = np.median(size)
        with np.errstate(divide="ignore", invalid="ignore"):
            far = np.abs(np.log(np.abs(size / usual))) > np.log(WILD)
        if rows.size >= 4 and far.mean() < 0.4:
            wild |= np.isin(cells.row, rows[far])
    return wild


def _top(y: np.ndarray) -> float:
    """The reading with the third largest magnitude of a row (the smallest of a shorter row), with its sign."""
    order = np.argsort(-np.abs(y))
    return float(y[order[min(2, y.size - 1)]])


def _wild_columns(cells: Cells) -> np.ndarray:
    """Mask (N,) of cells in columns whose median force per depth is more than a factor WILD above, or below, both neighbours'."""
    wild = np.zeros(len(cells), bool)
    for s in cells.scans:
        mine = cells.scan == s
        columns = np.unique(cells.column[mine])
        if columns.size < 5:
            continue
        size = np.array([np.median(cells.y[cells.column == j] / cells.z[cells.column == j]) for j in columns])
        ends = np.r_[size[1], size, size[-2]]
        beside = np.array([ends[:-2], ends[2:]])
        second, most = np.partition(np.abs(size), -2)[-2:]
        floor = 0.05 * (most if most < WILD * second else second)
        above = size > WILD * np.maximum(beside.max(axis=0), floor)
        below = (size * WILD < beside.min(axis=0)) & (beside.min(axis=0) > floor)
        wild |= np.isin(cells.column, columns[above | below])
    return wild
