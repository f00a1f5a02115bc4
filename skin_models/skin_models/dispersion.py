"""The dispersion model of the thesis: two springs, two dashpots, a mass (eqs 27 and 28, figure 4-9).

    sensed     F_FF = b1 v + k1 x
    dispersed  F_d  = b2 v + k2 x
    applied    F_LC = m (a - g) + F_FF + F_d

with depth x (m), positive into the skin, zero at its surface. The thesis writes it for x > 0; here a plunger in the air (x <= 0) feels
nothing, and skin that is left faster than it recovers does not pull (`never_pulling`).
"""

from dataclasses import dataclass

import numpy as np

from skin_models.parameter import check_parameters, quantity
from skin_models.signals import GRAVITY, Motion, Sample


@dataclass(frozen=True)
class Dispersion:
    """Parameters of the dispersion model; all are those of the skin under the plunger."""

    m: float = quantity("kg", 0.0, lower=0.0, doc="mass of skin that moves with the plunger")
    b1: float = quantity("N*s/m", lower=-1e6, doc="damping between plunger and taxel")
    k1: float = quantity("N/m", lower=0.0, doc="stiffness between plunger and taxel")
    b2: float = quantity("N*s/m", lower=-1e6, doc="damping of the force that is dispersed past the taxel")
    k2: float = quantity("N/m", lower=-1e6, doc="stiffness of the force that is dispersed past the taxel")

    def __post_init__(self) -> None:
        check_parameters(self)

    def branches(self, s: Motion | Sample) -> np.ndarray:
        """Sensed and dispersed force, shape (2,) or (2, N), N. Zero in the air."""
        contact = np.asarray(s.x) > 0.0
        sensed, dispersed = self.b1 * s.v + self.k1 * s.x, self.b2 * s.v + self.k2 * s.x
        return np.array([sensed * contact, dispersed * contact])

    def inertial(self, s: Motion | Sample) -> np.ndarray:
        """Force of the moving skin, m (a - g) in contact, N."""
        return self.m * (s.a - GRAVITY) * (np.asarray(s.x) > 0.0)

    @property
    def sensed_share(self) -> float:
        """Static share of the applied force that reaches the taxel, k1 / (k1 + k2)."""
        return self.k1 / (self.k1 + self.k2)


def never_pulling(branches: np.ndarray) -> np.ndarray:
    """The contact rule: where the skin's total force would pull on the plunger they have parted, and both branches carry nothing."""
    return branches * (branches.sum(axis=0) > 0.0)
