"""Dead taxel: it is stuck at one reading, or fades towards it.

    y' = (1 - d) y + d L        d = 1: wholly dead

Source: the stuck-at fault; R. Isermann, Fault-Diagnosis Systems, Springer 2006.
"""

from dataclasses import dataclass
from typing import ClassVar

from skin_models.effect import Memoryless, Place
from skin_models.parameter import SHAPE, quantity


@dataclass(frozen=True)
class DeadTaxel(Memoryless):
    """A taxel that answers with a constant."""

    cause: ClassVar[str] = "dead_taxel"
    places: ClassVar = {"taxel": Place.TAXEL}
    source: ClassVar[str] = "Isermann 2006, stuck-at fault"
    linear: ClassVar[bool] = True

    lost: float = quantity("1", 0.0, lower=0.0, upper=1.0, typical=1.0, doc="share d of the signal that is lost")
    level: float = quantity("N", 0.0, role=SHAPE, typical=0.0, scan=(0.0,), doc="reading L at which it is stuck")

    def apply(self, y, s):
        """(1 - d) y + d L."""
        return self.put_back(y, (1.0 - self.lost) * self.mine(y) + self.lost * self.level)
