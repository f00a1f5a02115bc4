"""Where the taxels lie under a contact, for effects that depend on it."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from skin_models.spread.kernels import Kernel

_NEXT = 1.2  # of the distance to the nearest: still a neighbour, so that a grid has four and a hexagonal patch six


@dataclass(frozen=True, eq=False)
class Places:
    """Positions (T, 2) or (T, 3) of the taxels, m."""

    positions: np.ndarray

    @cached_property
    def neighbours(self) -> Any:
        """Sparse (T, T): a row averages the nearest neighbours of its taxel; empty for a lone one."""
        count = len(self.positions)
        if count < 2:
            return csr_array((count, count))
        tree = cKDTree(self.positions)
        nearest = tree.query(self.positions, k=2)[0][:, 1]
        near = tree.query_ball_point(self.positions, _NEXT * nearest)
        pairs = [(i, j) for i, found in enumerate(near) for j in found if j != i]
        rows, columns = np.array(pairs).T
        return csr_array((1.0 / np.bincount(rows, minlength=count)[rows], (rows, columns)), shape=(count, count))


@dataclass(frozen=True, eq=False)
class Footprint:
    """The taxels as one contact sees them.

    `offset` (2, T), or (2, T, N) for a contact that moves: from the contact, across its normal, m. Effects of the spread shift and stretch
    it to say where in the undisturbed kernel a taxel would feel what it feels.
    """

    places: Places
    offset: np.ndarray
    kernel: Kernel
    width: float = field(init=False)  # m, where the kernel has fallen to 1 / e: the c of a Gaussian

    def __post_init__(self) -> None:
        object.__setattr__(self, "width", self.kernel.reach(float(np.exp(-1.0))))

    def at(self, i: int) -> "Footprint":
        """At one sample."""
        return self if self.offset.ndim == 2 else replace(self, offset=self.offset[..., i])

    def shape(self) -> np.ndarray:
        """The kernel on the taxels, 1 right under the contact: (T,), or (T, N)."""
        return self.kernel.shape(self.kernel.distance(*self.offset))
