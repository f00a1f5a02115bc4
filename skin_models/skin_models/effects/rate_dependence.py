"""Rate dependence: the skin's damping is not proportional to speed. Four forms, added to b v in contact:

    power          f = F sign(v) |v / 10 mm/s|^p
    Eyring         f = F asinh(v / v_0)         damping b v up to the speed v_0, the logarithm of the speed beyond
    Hunt-Crossley  f = c x v                    damping that grows from zero with the contact
    one-sided      f = c |v|                    damping b + c on the way in, b - c on the way out

The second, added to b v, is thinning that sets in at a speed, as in Carreau and Cross fluids.

Sources: H. Eyring, J. Chem. Phys. 4 (1936) 283-291 (flow as an activated process); K. H. Hunt and F. R. E. Crossley, Coefficient of
restitution interpreted as damping in vibroimpact, J. Appl. Mech. 42 (1975) 440-445; R. B. Bird, R. C. Armstrong, O. Hassager, Dynamics of
Polymeric Liquids, vol. 1, Wiley 1987, ch. 4 (power law, Carreau); J. C. Dixon, The Shock Absorber Handbook, 2nd ed., Wiley 2007 (bump
and rebound).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Memoryless, Place
from skin_models.operators.contact import branches, depth_in_contact
from skin_models.parameter import SHAPE, quantity


@dataclass(frozen=True)
class PowerDamping(Memoryless):
    """Damping that follows a power of the speed: p < 1 thins, p > 1 thickens."""

    cause: ClassVar[str] = "rate_dependence"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "power law; Bird, Armstrong and Hassager 1987, ch. 4"
    linear: ClassVar[bool] = True

    reference: ClassVar[float] = 0.01  # m/s

    force_sensed: float = quantity("N", 0.0, typical=4.0, doc="force at 10 mm/s, sensed")
    force_dispersed: float = quantity("N", 0.0, typical=2.0, doc="force at 10 mm/s, dispersed")
    exponent: float = quantity(
        "1", 0.4, lower=0.05, upper=4.0, role=SHAPE, typical=0.4, scan=(0.15, 0.25, 0.4, 0.6, 1.5, 2.0, 3.0), doc="power of the speed"
    )

    def apply(self, y, s):
        """y + F sign(v) |v / 10 mm/s|^p on each branch."""
        f = np.sign(s.v) * np.abs(s.v / self.reference) ** self.exponent
        return y + branches(self.force_sensed, self.force_dispersed, f, s.x)


@dataclass(frozen=True)
class EyringDamping(Memoryless):
    """Damping that gives way above a speed."""

    cause: ClassVar[str] = "rate_dependence"
    form: ClassVar[str] = "eyring"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Eyring 1936"
    linear: ClassVar[bool] = True

    force_sensed: float = quantity("N", 0.0, typical=0.5, doc="force at 1.2 times v_0, sensed")
    force_dispersed: float = quantity("N", 0.0, typical=0.25, doc="force at 1.2 times v_0, dispersed")
    speed: float = quantity(
        "m/s", 5e-4, lower=1e-7, upper=1.0, role=SHAPE, typical=5e-4, scan=(3e-5, 1e-4, 5e-4, 2e-3), doc="speed v_0 at which it gives way"
    )

    def apply(self, y, s):
        """y + F asinh(v / v_0) on each branch in contact."""
        return y + branches(self.force_sensed, self.force_dispersed, np.arcsinh(s.v / self.speed), s.x)


@dataclass(frozen=True)
class HuntCrossley(Memoryless):
    """Damping proportional to depth times speed."""

    cause: ClassVar[str] = "rate_dependence"
    form: ClassVar[str] = "hunt_crossley"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Hunt and Crossley 1975"
    linear: ClassVar[bool] = True

    c_sensed: float = quantity("N*s/m^2", 0.0, lower=0.0, typical=4e5, doc="factor of x v, sensed")
    c_dispersed: float = quantity("N*s/m^2", 0.0, lower=0.0, typical=2e5, doc="factor of x v, dispersed")

    def apply(self, y, s):
        """y + c x v on each branch."""
        return y + branches(self.c_sensed, self.c_dispersed, depth_in_contact(s.x) * s.v, s.x)


@dataclass(frozen=True)
class OneSidedDamping(Memoryless):
    """Damping that differs between the way in and the way out."""

    cause: ClassVar[str] = "rate_dependence"
    form: ClassVar[str] = "one_sided"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Dixon 2007"
    linear: ClassVar[bool] = True

    c_sensed: float = quantity("N*s/m", 0.0, typical=200.0, doc="half the difference of damping between in and out, sensed")
    c_dispersed: float = quantity("N*s/m", 0.0, typical=100.0, doc="half the difference of damping between in and out, dispersed")

    def apply(self, y, s):
        """y + c |v| on each branch in contact."""
        return y + branches(self.c_sensed, self.c_dispersed, np.abs(s.v), s.x)
