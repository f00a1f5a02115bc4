"""Mount compliance: the rig bends under the force, and the encoder moves more than the tip.

    tip depth = x - C F,  F = K tip depth        hence tip depth = x / (1 + C K) in contact, x in the air

The force that bends the mount is that of a linear skin of stiffness K; K is a parameter because an effect sees motion, not force. Only the
product C K matters: from x and F alone a soft mount equals a softer skin. Damping and mass of skin are left out, which is right for
C b << 1 / omega.

Source: two springs in series; W. C. Oliver and G. M. Pharr, J. Materials Research 7 (1992) 1564-1583 (compliance of the load frame).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Memoryless, Place
from skin_models.parameter import SHAPE, quantity


@dataclass(frozen=True)
class MountCompliance(Memoryless):
    """A spring between encoder and tip."""

    cause: ClassVar[str] = "mount_compliance"
    places: ClassVar = {"rig": Place.DEPTH}
    source: ClassVar[str] = "Oliver and Pharr 1992"

    compliance: float = quantity("m/N", 0.0, lower=0.0, upper=1e-2, typical=1e-5, doc="compliance C of the mount")
    stiffness: float = quantity(
        "N/m", 1e4, lower=0.0, upper=1e7, role=SHAPE, typical=1e4, scan=(1e4,), doc="stiffness K of the specimen that loads it"
    )

    def apply(self, y, s):
        return np.where(y > 0.0, y / (1.0 + self.compliance * self.stiffness), y)
