"""Force offset: a constant bias of a sensor.

    y' = y + F

Source: zero balance in the data sheets of load cells; thesis 3.3.3 (1 % of the rated output for the MLP-25).
"""

from dataclasses import dataclass
from typing import ClassVar

from skin_models.effect import Memoryless, Place
from skin_models.parameter import quantity


@dataclass(frozen=True)
class ForceOffset(Memoryless):
    """A constant bias."""

    cause: ClassVar[str] = "force_offset"
    places: ClassVar = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "zero balance of load cells"
    linear: ClassVar[bool] = True

    offset: float = quantity("N", 0.0, lower=-1e3, upper=1e3, typical=0.3, doc="bias F")

    def apply(self, y, s):
        """y + F."""
        return self.put_back(y, self.mine(y) + self.offset)
