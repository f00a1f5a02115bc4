"""Nonlinear stiffness: the skin's force is not proportional to depth. Five forms, all added to k x, all zero in the air:

    polynomial     f = q x^2 + c x^3
    power          f = F (x / 1 mm)^p
    densification  f = k max(x - x0, 0)                         a second stiffness from depth x0 on
    plateau        f = -k (x - x0 (1 - exp(-x / x0)))           the stiffness k fades beyond x0, as when the cells of a foam buckle
    foam           f = plateau + d max(x - x1, 0)^2 / x1        and comes back, steeper, where the cells close

Every size comes twice, for the sensed and for the dispersed branch.

Sources: L. J. Gibson and M. F. Ashby, Cellular Solids, 2nd ed., Cambridge 1997, ch. 5; M. Avalle, G. Belingardi, A. Ibba,
Int. J. Impact Engineering 34 (2007) 3-27 (plateau and densification as a sum); K. L. Johnson, Contact Mechanics, 1985, ch. 4 (p = 3/2).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Memoryless, Place
from skin_models.operators.contact import branches, depth_in_contact
from skin_models.parameter import SHAPE, quantity, scan_of
from skin_models.signals import Motion

ONSETS = (0.2e-3, 0.4e-3, 0.6e-3, 0.9e-3, 1.3e-3, 1.8e-3, 2.5e-3, 3.5e-3)  # m


@dataclass(frozen=True)
class PolynomialStiffness(Memoryless):
    """Square and cube of the depth: linear in all parameters."""

    cause: ClassVar[str] = "nonlinear_stiffness"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Taylor series of any smooth force-depth curve"
    linear: ClassVar[bool] = True

    square_sensed: float = quantity("N/m^2", 0.0, typical=1e6, doc="factor of x^2, sensed")
    square_dispersed: float = quantity("N/m^2", 0.0, typical=5e5, doc="factor of x^2, dispersed")
    cube_sensed: float = quantity("N/m^3", 0.0, typical=3e8, doc="factor of x^3, sensed")
    cube_dispersed: float = quantity("N/m^3", 0.0, typical=1e8, doc="factor of x^3, dispersed")

    def apply(self, y, s):
        """y + q x^2 + c x^3 on each branch."""
        x = depth_in_contact(s.x)
        square = branches(self.square_sensed, self.square_dispersed, x * x, s.x)
        return y + square + branches(self.cube_sensed, self.cube_dispersed, x * x * x, s.x)


@dataclass(frozen=True)
class PowerStiffness(Memoryless):
    """A power of the depth, such as Hertz's 3/2."""

    cause: ClassVar[str] = "nonlinear_stiffness"
    form: ClassVar[str] = "power"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Johnson 1985, ch. 4"
    linear: ClassVar[bool] = True

    reference: ClassVar[float] = 1e-3  # m

    force_sensed: float = quantity("N", 0.0, typical=3.0, doc="force at 1 mm, sensed")
    force_dispersed: float = quantity("N", 0.0, typical=1.0, doc="force at 1 mm, dispersed")
    exponent: float = quantity(
        "1", 1.5, lower=0.2, upper=6.0, role=SHAPE, typical=1.5, scan=(0.5, 0.75, 1.5, 2.0, 2.5, 3.0, 4.0), doc="power of the depth"
    )

    def apply(self, y, s):
        """y + F (x / 1 mm)^p on each branch."""
        f = (depth_in_contact(s.x) / self.reference) ** self.exponent
        return y + branches(self.force_sensed, self.force_dispersed, f, s.x)


@dataclass(frozen=True)
class Densification(Memoryless):
    """A second spring that is met at depth x0."""

    cause: ClassVar[str] = "nonlinear_stiffness"
    form: ClassVar[str] = "densification"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Gibson and Ashby 1997, ch. 5, as a hinge"
    linear: ClassVar[bool] = True

    k_sensed: float = quantity("N/m", 0.0, typical=6000.0, doc="stiffness added beyond the onset, sensed")
    k_dispersed: float = quantity("N/m", 0.0, typical=2000.0, doc="stiffness added beyond the onset, dispersed")
    onset: float = quantity("m", 1e-3, lower=0.0, upper=0.05, role=SHAPE, typical=1e-3, scan=ONSETS, doc="depth x0")

    def apply(self, y, s):
        """y + k max(x - x0, 0) on each branch."""
        return y + branches(self.k_sensed, self.k_dispersed, np.maximum(s.x - self.onset, 0.0), s.x)


def _plateau(x, onset):
    return onset * -np.expm1(-x / onset) - x


@dataclass(frozen=True)
class Plateau(Memoryless):
    """Stiffness that fades with depth."""

    cause: ClassVar[str] = "nonlinear_stiffness"
    form: ClassVar[str] = "plateau"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Avalle et al. 2007, first term"
    linear: ClassVar[bool] = True

    k_sensed: float = quantity("N/m", 0.0, lower=0.0, typical=4000.0, doc="stiffness lost on the plateau, sensed")
    k_dispersed: float = quantity("N/m", 0.0, lower=0.0, typical=1000.0, doc="stiffness lost on the plateau, dispersed")
    onset: float = quantity("m", 0.5e-3, lower=1e-5, upper=0.05, role=SHAPE, typical=0.5e-3, scan=ONSETS, doc="depth x0")

    def apply(self, y, s):
        """y - k (x - x0 (1 - exp(-x / x0))) on each branch."""
        return y + branches(self.k_sensed, self.k_dispersed, _plateau(depth_in_contact(s.x), self.onset), s.x)


@dataclass(frozen=True)
class Foam(Memoryless):
    """A foam's plateau, then densification."""

    cause: ClassVar[str] = "nonlinear_stiffness"
    form: ClassVar[str] = "foam"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Avalle et al. 2007; Gibson and Ashby 1997, ch. 5"
    linear: ClassVar[bool] = True

    lost_sensed: float = quantity("N/m", 0.0, lower=0.0, typical=5000.0, doc="stiffness lost on the plateau, sensed")
    lost_dispersed: float = quantity("N/m", 0.0, lower=0.0, typical=1500.0, doc="stiffness lost on the plateau, dispersed")
    dense_sensed: float = quantity("N/m", 0.0, lower=0.0, typical=20000.0, doc="scale of the densification d, sensed")
    dense_dispersed: float = quantity("N/m", 0.0, lower=0.0, typical=6000.0, doc="scale of the densification d, dispersed")
    yields: float = quantity(
        "m", 0.4e-3, lower=1e-5, upper=0.05, role=SHAPE, typical=0.4e-3, scan=ONSETS[:5], doc="depth x0 of the plateau"
    )
    closes: float = quantity(
        "m", 1.3e-3, lower=1e-4, upper=0.05, role=SHAPE, typical=1.3e-3, scan=ONSETS[3:], doc="depth x1 of densification"
    )

    @classmethod
    def shapes(cls, s: Motion) -> Iterator[dict[str, float]]:
        """The two grids in parallel, not their product: the loss on the plateau does not depend on where cells close, nor vice versa."""
        for yields, closes in zip(scan_of(cls, "yields"), scan_of(cls, "closes"), strict=True):
            yield {"yields": yields, "closes": closes}

    def apply(self, y, s):
        """y - k (x - x0 (1 - exp(-x / x0))) + d max(x - x1, 0)^2 / x1 on each branch."""
        lost = branches(self.lost_sensed, self.lost_dispersed, _plateau(depth_in_contact(s.x), self.yields), s.x)
        closed = np.maximum(s.x - self.closes, 0.0)
        return y + lost + branches(self.dense_sensed, self.dense_dispersed, closed * closed / self.closes, s.x)
