"""What the thesis's own Tables 4-4 to 4-7 say about its dispersion model, beyond what the thesis says about them.

The free mass. In eq 27 the mass multiplies (a - g). On a slow sine a is a ten-thousandth of g, so the "mass" is in fact a constant force
-m g: 2.65, 2.08 and 1.96 N for 2, 4 and 6 mm. Where the mass is held at its true 0.2 to 0.6 g, another parameter must take up that force.
On a sine x = A sin(B t) + C, least squares puts it into the stiffness of the load cell's equation alone:

    k2 falls by  m g C / (C^2 + A^2 / 2)

The printed falls of k2 (7016, 2645 and 1669 N/m) then tell how deep the thesis pressed, which it does not say.

The speed. From 0.25 to 1 mm/s, the coefficients of eq 32 in Table 4-7 grow as speed^1 (dampings) and about speed^2 (stiffnesses), at
constant shares. Material constants would not change at all. A response that depends on the path, and not on the time taken, changes in just
this way.
"""

from dataclasses import dataclass

import numpy as np

from skin_models.signals import GRAVITY
from skin_models.thesis.tables import estimates, table, transfer_functions

THICKNESSES = (2, 4, 6)  # mm


@dataclass(frozen=True)
class FreeMass:
    """One thickness: the free and the known mass (kg), the constant force that their difference stands for (N), and `depth`, the
    (C^2 + A^2 / 2) / C of the motion (m)."""

    thickness_mm: int
    mass: float
    known: float
    force: float
    depth: float

    @property
    def amplitude(self) -> float:
        """A = C (m), for a sine that just reaches the surface."""
        return self.depth / 1.5


def free_masses() -> tuple[FreeMass, ...]:
    """The free mass of every thickness, from Tables 4-4 (mass free) and 4-5 (mass fixed)."""
    return tuple(_free_mass(mm) for mm in THICKNESSES)


def _free_mass(mm: int) -> FreeMass:
    free, fixed = estimates("4-4", f"{mm}mm"), estimates("4-5", f"{mm}mm")
    known = 1e-3 * table("text").cell(f"mass_{mm}mm", "value").value
    force = (free["m"].value - known) * GRAVITY
    return FreeMass(mm, free["m"].value, known, force, force / (free["k2"].value - fixed["k2"].value))


@dataclass(frozen=True)
class SpeedExponents:
    """The exponents with which damping and stiffness in the denominator of eq 32 grow with speed between two experiments, and the shares
    k1 / (k1 + k2) of both."""

    damping: float
    stiffness: float
    shares: tuple[float, float]


def speed_exponents() -> tuple[SpeedExponents, ...]:
    """The exponents between experiment 1 of Table 4-7 and each other experiment, which is faster."""
    slow, *fast = transfer_functions()

    def exponents(f) -> SpeedExponents:
        steps = np.log(f.speed / slow.speed)
        damping = np.log((f.b1 + f.b2) / (slow.b1 + slow.b2)) / steps
        stiffness = np.log((f.k1 + f.k2) / (slow.k1 + slow.k2)) / steps
        return SpeedExponents(float(damping), float(stiffness), (slow.k1 / (slow.k1 + slow.k2), f.k1 / (f.k1 + f.k2)))

    return tuple(exponents(f) for f in fast)
