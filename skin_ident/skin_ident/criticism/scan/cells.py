"""All measurements of one or several spread scans as one flat list, so that lost, copied and held-out cells are simply left out."""

from dataclasses import dataclass, replace

import numpy as np

from skin_ident.spread_scan import SpreadScan

ALONG = {"x": 0.5, "y": -0.5, "": 0.0}  # factor of the parameter `ratio` in the logarithm of the width, by direction of the scan


@dataclass(frozen=True, eq=False)
class Cells:
    """N measurements. `row` (one depth of one scan) and `column` (one distance of one scan) are numbered through all scans.

    y, z, r (N,)  force N, depth m, signed distance m      along (N,)  +1/2 in x, -1/2 in y, 0 unknown
    order (N,)    position of the row in its scan, from 0 (first) to 1 (last)
    """

    y: np.ndarray
    z: np.ndarray
    r: np.ndarray
    along: np.ndarray
    order: np.ndarray
    row: np.ndarray
    column: np.ndarray
    scan: np.ndarray

    def __len__(self) -> int:
        return self.y.size

    def only(self, keep: np.ndarray) -> "Cells":
        """The cells of a mask (N,). Rows, columns and scans keep their numbers."""
        return Cells(*(getattr(self, name)[keep] for name in self.__dataclass_fields__))

    def reading(self, y: np.ndarray) -> "Cells":
        """The same cells with other forces (N,)."""
        return replace(self, y=y)

    @property
    def scans(self) -> np.ndarray:
        """The scans that have cells."""
        return np.unique(self.scan)

    @property
    def depth_span(self) -> tuple[float, float]:
        """Mean and largest depth, m."""
        return float(self.z.mean()), float(self.z.max())


def cells_of(scans: list[SpreadScan], directions: list[str], keep: list[np.ndarray] | None = None) -> Cells:
    """The finite cells of `scans`; `keep` holds a mask (D, R) of trusted cells per scan, default all."""
    parts, rows, columns = [], 0, 0
    for i, scan in enumerate(scans):
        D, R = scan.force.shape
        d, j = np.mgrid[0:D, 0:R]
        known = np.isfinite(scan.force) & (True if keep is None else keep[i])
        along, number = np.full((D, R), ALONG[directions[i]]), np.full((D, R), i)
        whole = (scan.force, scan.depth[d], scan.distance[j], along, d / max(D - 1, 1), d + rows, j + columns, number)
        parts.append([a[known] for a in whole])
        rows, columns = rows + D, columns + R
    return Cells(*(np.concatenate(group) for group in zip(*parts, strict=True)))


def as_tables(values: np.ndarray, cells: Cells, scans: list[SpreadScan]) -> list[np.ndarray]:
    """Values (N,) of `cells` arranged in the tables (D, R) of their scans; NaN where there is no cell."""
    tables = [np.full(s.force.shape, np.nan) for s in scans]
    rows = np.cumsum([0, *(s.depth.size for s in scans)])
    columns = np.cumsum([0, *(s.distance.size for s in scans)])
    for i, table in enumerate(tables):
        mine = cells.scan == i
        table[cells.row[mine] - rows[i], cells.column[mine] - columns[i]] = values[mine]
    return tables
