"""What effects of the spread have in common: each says where in the undisturbed kernel a taxel would feel the same.

    share' = share * K(offset') / K(offset) / scale^2,        offset' = seen(offset)

Over a recording and step by step they change the shares that reach the taxels; in a patch of skin they bend the kernel itself (`Bent`), and
both come to the same. Several act in the order in which they stand between contact and kernel, whatever the order they are listed in: first
`off_centre`, in real lengths, then direction, width and shape. They need to know where the taxels are (`Model.positions`, or a layout).

They are simulated and not proposed: one recording under one contact cannot tell them from the taxels' gains. An analysis of several taxels
or several places at once decides on them.
"""

import math
from abc import abstractmethod
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from skin_models.effect import Memoryless
from skin_models.errors import ModelError
from skin_models.signals import Motion, Sample
from skin_models.spread.footprint import Footprint
from skin_models.spread.kernels import Wrapped


class Bending(Memoryless):
    """An effect of the spread. `rank` orders them from the contact inwards; `radial`: the same in all directions."""

    finds_taxels: ClassVar[bool] = True
    proposed: ClassVar[bool] = False
    rank: ClassVar[int]
    radial: ClassVar[bool] = True
    deep: ClassVar[bool] = False  # depends on the depth

    @abstractmethod
    def seen(self, offset: np.ndarray, x: Any, width: float) -> np.ndarray:
        """The offset in the undisturbed kernel, (2, T) or (2, T, N) m, where a taxel would feel what it feels at `offset`, `x` m deep."""

    @abstractmethod
    def reach(self, r: float, x: float, width: float) -> float:
        """A distance (m) beyond which `seen` is nowhere nearer than `r`."""

    def scale(self, x: Any) -> Any:
        """How much wider the kernel is at depth `x`; a share right under the contact falls with its square."""
        return 1.0

    def matrix(self) -> np.ndarray | None:
        """The matrix by which `seen` multiplies an offset at any depth, (2, 2); None where `seen` does more than stretch and turn."""
        return None

    def shift(self) -> tuple[float, float]:
        """Where the contact is, along the skin's x and y, m, from where it was said to be."""
        return 0.0, 0.0

    def bent(self, f: Footprint, x: Any) -> Footprint:
        """The footprint as the next effect sees it."""
        return replace(f, offset=self.seen(f.offset, np.maximum(x, 0.0), f.width))

    def apply(self, y, s: Sample | Motion):
        """share * K(seen(p)) / K(p) / scale^2, 0 where K(p) is. Raises `ModelError` where nobody knows where the taxels are."""
        if s.footprint is None:
            raise ModelError(f"{self.cause} needs to know where the taxels are: give the model their positions, or a layout")
        before, after = (_over_time(f.shape(), np.ndim(y)) for f in (s.footprint, self.bent(s.footprint, s.x)))
        felt = np.broadcast_to(before > 0.0, np.broadcast_shapes(before.shape, after.shape))
        return y * np.divide(after, before, out=np.zeros(felt.shape), where=felt) * self.scale(np.maximum(s.x, 0.0)) ** -2.0


def _over_time(a: np.ndarray, ndim: int) -> np.ndarray:
    return a[:, None] if a.ndim < ndim else a


def in_order(effects: tuple) -> tuple:
    """Effects of the spread from the contact inwards."""
    return tuple(sorted(effects, key=lambda e: getattr(e, "rank", 0)))


@dataclass(frozen=True)
class Bent(Wrapped):
    """`kernel` with the effects of the spread in it, under a contact `depth` (m) deep.

    Its `area` stays that of the kernel: effects of the spread change the shape around a height that was measured.
    """

    effects: tuple[Bending, ...]
    depth: float = field(default=0.0)

    @cached_property
    def _width(self) -> float:
        return self.kernel.reach(float(np.exp(-1.0)))

    @property
    def radial(self) -> bool:
        """Whether kernel and all effects are the same in all directions."""
        return self.kernel.radial and all(e.radial for e in self.effects)

    @property
    def deep(self) -> bool:
        """Whether it depends on the depth."""
        return self.kernel.deep or any(e.deep for e in self.effects)

    def straightened(self):
        """The product of the effects' matrices, and the kernel bent by the radial effects alone.

        None where an effect does more than stretch and turn, or the kernel inside is not radial.
        """
        turning = [e for e in in_order(self.effects) if not e.radial]
        if not self.kernel.radial or any(e.matrix() is None for e in turning):
            return None
        matrix = np.eye(2)
        for e in turning:
            matrix = e.matrix() @ matrix
        return matrix, replace(self, effects=tuple(e for e in self.effects if e.radial))

    def scale(self, depth):
        """The product of all scales."""
        x = np.maximum(np.nan_to_num(depth), 0.0)
        return math.prod((e.scale(x) for e in self.effects), start=self.kernel.scale(depth))

    def shape(self, r):
        """The kernel's shape / scale^2. Where an effect is not radial `r` is what `distance` gives; else it is bent here."""
        if self.radial:
            r = self._seen(np.asarray(r), np.zeros_like(r))
        return float(math.prod(e.scale(self.depth) for e in self.effects)) ** -2.0 * self.kernel.shape(r)

    def distance(self, u, v):
        """The distance of a taxel at these offsets: after all effects where one of them is not radial, else that of the kernel inside."""
        return super().distance(u, v) if self.radial else self._seen(u, v)

    def _seen(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        offset = np.array([u, v])
        for e in in_order(self.effects):
            offset = e.seen(offset, self.depth, self._width)
        return self.kernel.distance(*offset)

    def reach(self, tolerance):
        """The kernel's reach, widened by every effect from the kernel outwards."""
        r = self.kernel.reach(tolerance)
        for e in reversed(in_order(self.effects)):
            r = e.reach(r, self.depth, self._width)
        return r

    def at_depth(self, depth):
        """Kernel and effects at `depth`; at the surface where that is negative or unknown."""
        return replace(self, kernel=self.kernel.at_depth(depth), depth=max(float(np.nan_to_num(depth)), 0.0))
