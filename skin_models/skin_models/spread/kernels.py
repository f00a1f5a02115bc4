"""Spread kernels: the shape of the force that passes the skin, over the distance r from where it is pressed.

    Gaussian              exp(-(r / c)^2)                    thesis section 4.3.4
    GeneralisedGaussian   exp(-(r / c)^p)                    flat top for p > 2, pointed for p < 2
    HeavyTail             (1 + (r / c)^2)^-q                 c deep in an elastic half space: pressure q = 1.5, normal stress q = 2.5
    DepthWidth            any of them, c grows with the depth
    Anisotropic           any of them, c differs by direction

`shape` has peak 1; `area` is its integral over the plane, so that shape / area is a density that conserves force. Where a width was
fitted to the readings of a real taxel under a real plunger (c = 5.25 mm of the thesis) the kernel contains both their areas; to see
the skin through another taxel, take a narrower kernel and `spread.finite`.

Source of the heavy tails: Boussinesq's point force; K. L. Johnson, Contact Mechanics, 1985, ch. 3.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import gamma

from skin_models.errors import ModelError
from skin_models.parameter import SHAPE, check_parameters, quantity


@dataclass(frozen=True)
class Kernel(ABC):
    """A radial shape, unless `radial` says otherwise; `deep`: it depends on the depth of the contact."""

    @property
    def radial(self) -> bool:
        """Whether it is the same in all directions."""
        return True

    @property
    def deep(self) -> bool:
        """Whether it depends on the depth."""
        return False

    def straightened(self) -> tuple[np.ndarray, "Kernel"] | None:
        """A matrix (2, 2) and a radial kernel that has the same shape at offsets multiplied by the matrix; None where there are none."""
        return np.eye(2), self

    def scale(self, depth: np.ndarray) -> np.ndarray:
        """How much wider it is under contacts of these depths (m, NaN if unknown) than at the surface; its height falls with the square."""
        return np.ones_like(depth)

    def distance(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """The distance that counts, for tangential offsets u (along x) and v, m."""
        return np.hypot(u, v)

    def __post_init__(self) -> None:
        check_parameters(self)

    @abstractmethod
    def shape(self, r: np.ndarray) -> np.ndarray:
        """Peak-1 shape at distance r (m)."""

    @property
    @abstractmethod
    def area(self) -> float:
        """Integral of the shape over the plane, m^2."""

    @abstractmethod
    def reach(self, tolerance: float) -> float:
        """The distance (m) beyond which the shape stays below `tolerance`."""

    def at_depth(self, depth: float) -> "Kernel":
        """The kernel of a contact that is `depth` (m) deep; the same one unless the width depends on it."""
        return self


@dataclass(frozen=True)
class Gaussian(Kernel):
    """exp(-(r / width)^2)."""

    width: float = quantity("m", lower=1e-6, upper=1.0, role=SHAPE, doc="c of the Gaussian")

    def shape(self, r):
        """exp(-(r / c)^2)."""
        return np.exp(-((np.asarray(r) / self.width) ** 2))

    @property
    def area(self):
        """pi c^2."""
        return math.pi * self.width**2

    def reach(self, tolerance):
        """c sqrt(-ln tolerance)."""
        return self.width * math.sqrt(-math.log(tolerance))


@dataclass(frozen=True)
class GeneralisedGaussian(Kernel):
    """exp(-(r / width)^power)."""

    width: float = quantity("m", lower=1e-6, upper=1.0, role=SHAPE, doc="c")
    power: float = quantity("1", 2.0, lower=0.5, upper=20.0, role=SHAPE, doc="2 is the Gaussian, more is a flat top")

    def shape(self, r):
        """exp(-(r / c)^p)."""
        return np.exp(-((np.asarray(r) / self.width) ** self.power))

    @property
    def area(self):
        """pi c^2 Gamma(1 + 2 / p)."""
        return math.pi * self.width**2 * float(gamma(1.0 + 2.0 / self.power))

    def reach(self, tolerance):
        """c (-ln tolerance)^(1 / p)."""
        return self.width * (-math.log(tolerance)) ** (1.0 / self.power)


@dataclass(frozen=True)
class HeavyTail(Kernel):
    """(1 + (r / width)^2)^-power, power > 1 so that the force is finite."""

    width: float = quantity("m", lower=1e-6, upper=1.0, role=SHAPE, doc="where the shape has fallen to 2^-power")
    power: float = quantity("1", 1.5, lower=1.05, upper=20.0, role=SHAPE, doc="half the exponent of the tail")

    def shape(self, r):
        """(1 + (r / c)^2)^-q."""
        return (1.0 + (np.asarray(r) / self.width) ** 2) ** -self.power

    @property
    def area(self):
        """pi c^2 / (q - 1)."""
        return math.pi * self.width**2 / (self.power - 1.0)

    def reach(self, tolerance):
        """c sqrt(tolerance^(-1 / q) - 1)."""
        return self.width * math.sqrt(tolerance ** (-1.0 / self.power) - 1.0)


@dataclass(frozen=True)
class Wrapped(Kernel):
    """A kernel around another one: what a subclass does not override is that of the kernel inside."""

    kernel: Kernel

    @property
    def radial(self) -> bool:
        """As the kernel inside."""
        return self.kernel.radial

    @property
    def deep(self) -> bool:
        """As the kernel inside."""
        return self.kernel.deep

    def distance(self, u, v):
        """As the kernel inside."""
        return self.kernel.distance(u, v)

    def shape(self, r):
        """As the kernel inside."""
        return self.kernel.shape(r)

    @property
    def area(self):
        """As the kernel inside."""
        return self.kernel.area

    def reach(self, tolerance):
        """As the kernel inside."""
        return self.kernel.reach(tolerance)

    def scale(self, depth):
        """As the kernel inside."""
        return self.kernel.scale(depth)

    def at_depth(self, depth):
        """The same around the kernel inside at that depth."""
        return replace(self, kernel=self.kernel.at_depth(depth))


@dataclass(frozen=True)
class DepthWidth(Wrapped):
    """A kernel that is `1 + growth * depth` as wide at depth as at the surface; never narrower than a tenth.

    Raises `ModelError` around a kernel without a `width`: wrap this in that instead.
    """

    growth: float = quantity("1/m", 0.0, lower=-1e4, upper=1e4, doc="relative growth of the width per metre of depth")

    def __post_init__(self) -> None:
        super().__post_init__()
        if not hasattr(self.kernel, "width"):
            raise ModelError(f"{type(self.kernel).__name__} has no width that grows with the depth: put it around DepthWidth, not inside")

    @property
    def deep(self) -> bool:
        """True."""
        return True

    def straightened(self):
        """Itself: radial at any depth."""
        return np.eye(2), self

    def scale(self, depth):
        """1 + growth * depth, at least 0.1; 1 for a depth that is negative or unknown."""
        return np.maximum(1.0 + self.growth * np.maximum(np.nan_to_num(depth), 0.0), 0.1)

    def at_depth(self, depth):
        """The kernel inside, `scale` times as wide."""
        return replace(self.kernel, width=self.kernel.width * float(self.scale(np.float64(depth))))


@dataclass(frozen=True)
class Anisotropic(Wrapped):
    """A kernel stretched by sqrt(ratio) along `angle` and by 1 / sqrt(ratio) across it; the area stays.

    The angle counts from the skin's x axis, counter-clockwise about the normal.
    """

    ratio: float = quantity("1", 1.0, lower=0.1, upper=10.0, role=SHAPE, doc="width along the angle over width across it")
    angle: float = quantity("rad", 0.0, lower=-math.pi, upper=math.pi, role=SHAPE, doc="direction of the first width")

    @property
    def radial(self) -> bool:
        """False."""
        return False

    def reach(self, tolerance):
        """That of the kernel inside, along the wider direction."""
        return self.kernel.reach(tolerance) * math.sqrt(max(self.ratio, 1.0 / self.ratio))

    def straightened(self):
        """The stretch and turn, in front of what the kernel inside needs."""
        inner = self.kernel.straightened()
        return inner and (inner[0] @ self._matrix, inner[1])

    @property
    def _matrix(self) -> np.ndarray:
        c, s = math.cos(self.angle), math.sin(self.angle)
        return np.diag([self.ratio**-0.5, self.ratio**0.5]) @ np.array([[c, s], [-s, c]])

    def distance(self, u, v):
        """|(a u + b v, c u + d v)|, ((a, b), (c, d)) the stretch by 1 / sqrt(ratio) along the angle and by sqrt(ratio) across it."""
        (a, b), (c, d) = self._matrix
        return self.kernel.distance(a * u + b * v, c * u + d * v)
