"""The spread field: which share of every contact's force reaches which taxel.

    w[c, i] = peak * area[i] / reference_area * shape(r[c, i]) * max(0, n[i] . n[c])

with r the distance in the tangent plane of the contact. `peak` is the share that a taxel of the reference area right under a contact
collects; without one it is area / kernel.area, the share that a density of total 1 gives. Force is conserved: the shares of a contact
never sum to more than 1 (where taxels overlap, or a coarse layout is hit on its taxels, they are scaled down to 1), and what reaches
no taxel is the explicit `dispersed` part, beyond the edges and between the taxels alike.

Taxels farther than `reach` get nothing: there the shape has fallen below `tolerance`, so no taxel lacks more than tolerance * peak
of the total force pressed. What is cut off counts as dispersed.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from skin_models.errors import ModelError
from skin_models.layout import Layout
from skin_models.spread.contacts import Contacts, disc_points
from skin_models.spread.kernels import Kernel


@dataclass(frozen=True, eq=False)
class Spreading:
    """Where the force of all contacts went, N."""

    taxels: np.ndarray  # (T,)
    dispersed: float  # reaches no taxel
    outside: int = 0  # contacts that no taxel is near


@dataclass(frozen=True, eq=False)
class Shares:
    """The shares in sparse form: entry k says that `value[k]` of contact `contact[k]`'s force reaches taxel `taxel[k]`."""

    contact: np.ndarray
    taxel: np.ndarray
    value: np.ndarray


class SpreadField:
    """The kernel over one layout. It holds no state; contacts may move as they like."""

    def __init__(
        self,
        layout: Layout,
        kernel: Kernel,
        peak: float | None = None,
        reference_area: float | None = None,
        tolerance: float = 1e-6,
    ) -> None:
        """See the module for `peak`, `reference_area` (m^2, default each taxel's own) and `tolerance`. Raises `ModelError`."""
        if not 0.0 < tolerance < 0.1:
            raise ModelError(f"the tolerance of the spread must lie between 0 and 0.1, not {tolerance}")
        if peak is not None and not 0.0 <= peak <= 1.0:
            raise ModelError(f"a taxel can collect a share between 0 and 1 of the force above it, not {peak}")
        if reference_area is not None and not 0.0 < reference_area < np.inf:
            raise ModelError(f"the reference area must be positive, in m^2, not {reference_area}")
        self.layout, self.kernel, self.tolerance = layout, kernel, tolerance
        self.gain = layout.area / kernel.area if peak is None else peak * layout.area / (reference_area or layout.area)
        self.tree = cKDTree(layout.positions)

    def spread(self, contacts: Contacts) -> Spreading:
        """Force that every taxel collects, and what is dispersed."""
        shares = self.shares(contacts)
        taxels = np.bincount(shares.taxel, shares.value * contacts.force[shares.contact], len(self.layout))
        hit = np.zeros(len(contacts), bool)
        hit[shares.contact] = True
        return Spreading(taxels, max(float(contacts.force.sum() - taxels.sum()), 0.0), int(np.count_nonzero(~hit)))

    def shares(self, contacts: Contacts) -> Shares:
        """The shares of every contact; see the module."""
        normals = self.normals(contacts)
        parts = [self._shares(i, contacts, normals[i]) for i in range(len(contacts))]
        taxel = np.concatenate([p[0] for p in parts]) if parts else np.empty(0, int)
        value = np.concatenate([p[1] for p in parts]) if parts else np.empty(0)
        return Shares(np.repeat(np.arange(len(parts)), [p[0].size for p in parts]), taxel, value)

    def normals(self, contacts: Contacts) -> np.ndarray:
        """Unit normals of the contacts, (C, 3)."""
        if contacts.normal is None:
            return self.layout.normals[self.tree.query(contacts.position)[1]].reshape(-1, 3)
        return contacts.normal

    def _shares(self, i: int, contacts: Contacts, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        kernel, radius = self.kernel.at_depth(contacts.depth[i]), float(contacts.radius[i])
        reach = kernel.reach(self.tolerance)
        near = np.array(self.tree.query_ball_point(contacts.position[i], reach + radius), dtype=int)
        near.sort()  # the same sum in the same order, whatever the tree looks like
        across = self.layout.positions[near] - contacts.position[i]
        facing = np.maximum(self.layout.normals[near] @ normal, 0.0)
        x_axis, y_axis = tangent(normal)
        shape = _shape(kernel, (across @ x_axis, across @ y_axis, across @ normal), radius, reach)
        value = self.gain[near] * (self.kernel.area / kernel.area) * shape * facing
        kept = value > 0.0
        near, value = near[kept], value[kept]
        return near, value / max(value.sum(), 1.0)


def tangent(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors across `normal`: the first along the frame's x axis as far as possible (along y where the normal is x)."""
    axis = np.array([1.0, 0.0, 0.0]) if abs(normal[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    u = axis - (axis @ normal) * normal
    u /= np.linalg.norm(u)
    return u, np.cross(normal, u)


def _shape(kernel: Kernel, offset: tuple[np.ndarray, np.ndarray, np.ndarray], radius: float, reach: float) -> np.ndarray:
    """The shape at offsets (two tangential, one normal), averaged over a disc of `radius`, cut off at `reach` from the disc's points."""
    if radius == 0.0:
        return _point_shape(kernel, *offset, reach)
    u, v, w = offset
    offsets, weights = disc_points()
    return sum(f * _point_shape(kernel, u - radius * p, v - radius * q, w, reach) for (p, q), f in zip(offsets, weights, strict=True))


def _point_shape(kernel: Kernel, u: np.ndarray, v: np.ndarray, w: np.ndarray, reach: float) -> np.ndarray:
    tangential = u**2 + v**2
    return kernel.shape(kernel.distance(u, v)) * (tangential + w**2 <= reach**2)
