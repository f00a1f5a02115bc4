"""Where a search sets out: the thesis's model fitted to the cells, or a given model as it is."""

from collections.abc import Callable

import numpy as np

from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.family import Scale, plain, sizes
from skin_ident.criticism.scan.fitting import Member, fit
from skin_ident.criticism.scan.noise import white

WIDTHS = 60


def plain_start(cells: Cells) -> Member:
    """k z exp(-(r / c)^2) by least squares, one k per scan and one c for all."""
    mean, deepest = cells.depth_span
    d = cells.z / deepest
    reach = float(np.abs(cells.r).max())
    best = min((_linear(cells, d, c) for c in np.geomspace(reach / 50.0, 5.0 * reach, WIDTHS)), key=lambda found: found[0])
    width = best[1]
    m = Member(plain(width), best[2], ("width",), Scale(mean, deepest), _steps(cells, width))
    return fit(m, cells, white(cells).whitener()).member


def given_start(cells: Cells, width: float, law: Callable[[np.ndarray], np.ndarray]) -> Member:
    """A given model: its width, and its level `law(depth)` in N, both taken as they are."""
    mean, deepest = cells.depth_span
    k = np.ones(int(cells.scan.max()) + 1)
    return Member(plain(width), k, (), Scale(mean, deepest, law), _steps(cells, width), k_free=False)


def _linear(cells: Cells, d: np.ndarray, width: float) -> tuple[float, float, np.ndarray]:
    """Squared error, width and sizes for one width."""
    s = d * np.exp(-((cells.r / width) ** 2))
    scans = int(cells.scan.max()) + 1
    top, below = (np.bincount(cells.scan, a, scans) for a in (s * cells.y, s * s))
    k = top / np.maximum(below, 1e-300)
    return float(np.sum((cells.y - k[cells.scan] * s) ** 2)), width, k


def _steps(cells: Cells, width: float) -> dict[str, float]:
    return sizes(cells, width) | {"largest": float(cells.y.max())}
