"""Where taxels are: positions, normals and sensing areas, checked once.

Grids, rows and hexagonal patches lie in the plane z = 0 about the origin, normals along +z (out of the skin, REP 103). Arbitrary
positions with normals describe skin on a curved surface.
"""

from dataclasses import dataclass, field
from numbers import Real

import numpy as np
from scipy.spatial import cKDTree

from skin_models.arrays import numbers
from skin_models.errors import SkinError

A201_DIAMETER = 9.53e-3  # m, sensing disc of the FlexiForce A201 (thesis section 3.3.1)
A201_AREA = np.pi / 4 * A201_DIAMETER**2


class LayoutError(SkinError):
    """A layout that cannot be used."""


@dataclass(frozen=True, eq=False)
class Layout:
    """T taxels.

    positions (T, 3)  m, centres of the sensing areas
    normals   (T, 3)  unit vectors out of the skin
    area      (T,)    m^2, sensing area
    names     T       unique

    Raises `LayoutError` for no taxels, NaN, two taxels closer than a nanometre, normals that are not unit, areas that are not positive.
    """

    positions: np.ndarray
    normals: np.ndarray
    area: np.ndarray
    names: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        for name in ("positions", "normals", "area"):
            value = np.array(numbers(getattr(self, name), f"{name} of a layout", LayoutError))
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        object.__setattr__(self, "names", self.names or tuple(f"taxel_{i}" for i in range(len(self.positions))))
        _check(self)

    def __len__(self) -> int:
        return len(self.positions)

    @property
    def pitch(self) -> float:
        """Median distance to the nearest neighbour, m; infinite for a single taxel."""
        if len(self) < 2:
            return float("inf")
        return float(np.median(cKDTree(self.positions).query(self.positions, k=2)[0][:, 1]))


def _check(layout: Layout) -> None:
    p, n, a = layout.positions, layout.normals, layout.area
    if p.ndim != 2 or p.shape[1:] != (3,) or p.shape[0] == 0:
        raise LayoutError(f"a layout needs one or more taxel positions of 3 coordinates, not an array of shape {p.shape}")
    if n.shape != p.shape or a.shape != (len(p),):
        raise LayoutError(f"{len(p)} taxels need as many normals and areas, not arrays of shape {n.shape} and {a.shape}")
    for what, value in (("position", p), ("normal", n), ("area", a)):
        bad = np.flatnonzero(~np.isfinite(value).reshape(len(p), -1).all(axis=1))
        if bad.size:
            raise LayoutError(f"the {what} of {layout.names[bad[0]]} is not finite")
    if np.any(np.abs(np.linalg.norm(n, axis=1) - 1.0) > 1e-6):
        raise LayoutError("every normal must have length 1")
    if np.any(a <= 0.0):
        raise LayoutError("every sensing area must be positive")
    _check_distinct(layout)


def _check_distinct(layout: Layout) -> None:
    if len(layout.names) != len(layout) or len(set(layout.names)) != len(layout):
        raise LayoutError(f"{len(layout)} taxels need as many names, all different")
    twins = cKDTree(layout.positions).query_pairs(1e-9, output_type="ndarray") if len(layout) > 1 else np.empty((0, 2), int)
    if len(twins):
        i, j = twins[0]
        raise LayoutError(f"{layout.names[i]} and {layout.names[j]} are at the same place")


def _flat(xy: np.ndarray, area: float) -> Layout:
    """Taxels in the plane z = 0, centred on the origin."""
    xy = xy - (xy.min(axis=0) + xy.max(axis=0)) / 2.0
    return Layout(np.column_stack([xy, np.zeros(len(xy))]), np.tile([0.0, 0.0, 1.0], (len(xy), 1)), np.full(len(xy), area))


def _check_size(pitch: float, *counts: int) -> None:
    if not (isinstance(pitch, Real) and np.isfinite(pitch) and pitch > 0.0):
        raise LayoutError(f"the pitch must be a positive length in m, not {pitch}")
    if not all(isinstance(count, Real) and count >= 1 and float(count).is_integer() for count in counts):
        raise LayoutError(f"a layout needs a whole number, at least one taxel in every direction, not {' x '.join(map(str, counts))}")


def grid(columns: int, rows: int, pitch: float, area: float | None = None) -> Layout:
    """`columns` along x times `rows` along y, `pitch` (m) apart, row by row. `area` defaults to the whole cell."""
    _check_size(pitch, columns, rows)
    x, y = np.meshgrid(np.arange(columns) * pitch, np.arange(rows) * pitch)
    return _flat(np.column_stack([x.ravel(), y.ravel()]), pitch**2 if area is None else area)


def row(count: int, pitch: float, area: float = A201_AREA) -> Layout:
    """`count` taxels along x, `pitch` (m) apart. The thesis's array is `row(3, 14e-3)`."""
    _check_size(pitch, count)
    return _flat(np.column_stack([np.arange(count) * pitch, np.zeros(count)]), area)


def row_from_origin(count: int, pitch: float = 14e-3, area: float = A201_AREA) -> Layout:
    """The same row with its first taxel at the origin, where the thesis's rig starts; its pitch by default."""
    centred = row(count, pitch, area)
    return Layout(centred.positions - centred.positions[0], centred.normals, centred.area)


def hexagonal(columns: int, rows: int, pitch: float, area: float | None = None) -> Layout:
    """Rows along x, every other one shifted by half a pitch: six neighbours at `pitch` (m). `area` defaults to the hexagonal cell."""
    _check_size(pitch, columns, rows)
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    x, y = (i + 0.5 * (j % 2)) * pitch, j * pitch * np.sqrt(0.75)
    return _flat(np.column_stack([x.ravel(), y.ravel()]), np.sqrt(0.75) * pitch**2 if area is None else area)


def arbitrary(positions: np.ndarray, normals: np.ndarray, area: np.ndarray | float | None = None, names: tuple[str, ...] = ()) -> Layout:
    """Any positions (T, 3) m and normals (T, 3) of any length. `area` (m^2) defaults to a disc that touches the nearest neighbour's."""
    positions, normals = numbers(positions, "positions of taxels", LayoutError), numbers(normals, "normals of taxels", LayoutError)
    if positions.ndim != 2 or positions.shape[1:] != (3,) or normals.shape != positions.shape:
        raise LayoutError(f"positions and normals must both be (T, 3) arrays, not {positions.shape} and {normals.shape}")
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    if not np.all(length > 0.0):  # also for NaN
        raise LayoutError("every normal must be a direction, not zero or NaN")
    if area is None:
        area = _touching_discs(positions)
    return Layout(positions, normals / length, np.broadcast_to(area, len(positions)), tuple(names))


def flat(positions: np.ndarray, area: float = A201_AREA) -> Layout:
    """Taxels at (T, 2) m in the plane z = 0, as a model that knows its taxels' positions has them."""
    xy = numbers(positions, "positions of taxels", LayoutError)
    if xy.ndim != 2 or xy.shape[1:] != (2,):
        raise LayoutError(f"flat positions must be a (T, 2) array, not one of shape {xy.shape}")
    return Layout(np.column_stack([xy, np.zeros(len(xy))]), np.tile([0.0, 0.0, 1.0], (len(xy), 1)), np.full(len(xy), area))


def _touching_discs(positions: np.ndarray) -> np.ndarray | float:
    if len(positions) < 2 or not np.all(np.isfinite(positions)):
        return A201_AREA
    nearest = cKDTree(positions).query(positions, k=2)[0][:, 1]
    return np.pi / 4 * np.maximum(nearest, 1e-9) ** 2
