"""The elements of the thesis, with their closed forms: eqs 1 to 8 and figure 2-3."""

from dataclasses import dataclass

from skin_models.elements.creeping import Creeping
from skin_models.elements.element import Element
from skin_models.elements.relaxing import Relaxing
from skin_models.parameter import check_parameters, quantity

SMALLEST = 1e-12  # of a stiffness (N/m) or a damping (N s/m) that must not be zero


class _Basic(Element):
    def __post_init__(self) -> None:
        check_parameters(self)


@dataclass(frozen=True)
class Spring(_Basic):
    """f = k x (eq 1)."""

    k: float = quantity("N/m", lower=SMALLEST, doc="stiffness")

    @property
    def relaxing(self) -> Relaxing:
        """G(t) = k."""
        return Relaxing(k=self.k)

    @property
    def creeping(self) -> Creeping:
        """J(t) = 1 / k."""
        return Creeping(j=1.0 / self.k)


@dataclass(frozen=True)
class Dashpot(_Basic):
    """f = b x' (eq 2)."""

    b: float = quantity("N*s/m", lower=SMALLEST, doc="damping")

    @property
    def relaxing(self) -> Relaxing:
        """G(t) = b delta(t)."""
        return Relaxing(b=self.b)

    @property
    def creeping(self) -> Creeping:
        """J(t) = t / b."""
        return Creeping(fluidity=1.0 / self.b)


@dataclass(frozen=True)
class KelvinVoigt(_Basic):
    """Spring and dashpot in parallel: x' + (k / b) x = f / b (eq 3)."""

    k: float = quantity("N/m", lower=SMALLEST, doc="stiffness")
    b: float = quantity("N*s/m", lower=SMALLEST, doc="damping")

    @property
    def relaxing(self) -> Relaxing:
        """G(t) = k + b delta(t)."""
        return Relaxing(k=self.k, b=self.b)

    @property
    def creeping(self) -> Creeping:
        """J(t) = (1 - exp(-k t / b)) / k (eq 4); after unloading at t1, exp(-k t / b) (exp(k t1 / b) - 1) / k (eq 5)."""
        return Creeping(compliance=(1.0 / self.k,), delay=(self.b / self.k,))


@dataclass(frozen=True)
class Maxwell(_Basic):
    """Spring and dashpot in series: x' = f' / k + f / b (eq 6)."""

    k: float = quantity("N/m", lower=SMALLEST, doc="stiffness")
    b: float = quantity("N*s/m", lower=SMALLEST, doc="damping")

    @property
    def relaxing(self) -> Relaxing:
        """G(t) = k exp(-k t / b) (eq 8)."""
        return Relaxing(stiffness=(self.k,), tau=(self.b / self.k,))

    @property
    def creeping(self) -> Creeping:
        """J(t) = 1 / k + t / b (eq 7)."""
        return Creeping(j=1.0 / self.k, fluidity=1.0 / self.b)


@dataclass(frozen=True)
class StandardSolid(_Basic):
    """A spring k beside a Maxwell arm k1, b1: the standard viscoelastic solid of figure 2-3 (c)."""

    k: float = quantity("N/m", lower=SMALLEST, doc="stiffness that stays")
    k1: float = quantity("N/m", lower=SMALLEST, doc="stiffness of the arm")
    b1: float = quantity("N*s/m", lower=SMALLEST, doc="damping of the arm")

    @property
    def relaxing(self) -> Relaxing:
        """G(t) = k + k1 exp(-k1 t / b1)."""
        return Relaxing(k=self.k, stiffness=(self.k1,), tau=(self.b1 / self.k1,))

    @property
    def creeping(self) -> Creeping:
        """J(t) = 1 / k - k1 / (k (k + k1)) exp(-t / lambda), lambda = b1 (k + k1) / (k k1)."""
        at_once = 1.0 / (self.k + self.k1)
        return Creeping(j=at_once, compliance=(at_once * self.k1 / self.k,), delay=(self.b1 / (self.k * self.k1 * at_once),))
