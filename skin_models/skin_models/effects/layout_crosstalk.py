"""Crosstalk between neighbours in space: as `crosstalk`, for taxels that are no row.

    y'[i] = y[i] + c mean(y[j])        over the nearest taxels j of i: four in a grid, six in a hexagonal patch, none for a lone one

Simulated, not proposed: for a row it is `crosstalk` itself.

Source: T. D'Alessio, Measurement errors in the scanning of piezoresistive sensor arrays, Sensors and Actuators A 72 (1999) 71-76.
"""

from dataclasses import dataclass
from typing import ClassVar

from skin_models.effect import Memoryless, Place
from skin_models.errors import ModelError
from skin_models.parameter import quantity


@dataclass(frozen=True)
class LayoutCrosstalk(Memoryless):
    """Electrical leakage from the nearest taxels of a layout."""

    cause: ClassVar[str] = "crosstalk"
    form: ClassVar[str] = "layout"
    places: ClassVar = {"taxel": Place.TAXEL}
    source: ClassVar[str] = "D'Alessio 1999"
    linear: ClassVar[bool] = True
    finds_taxels: ClassVar[bool] = True
    proposed: ClassVar[bool] = False

    share: float = quantity("1", 0.0, lower=-1.0, upper=1.0, typical=0.1, doc="share c of the neighbours' mean")

    def apply(self, y, s):
        """y + share * (mean of the nearest taxels). Raises `ModelError` where nobody knows where the taxels are."""
        if s.footprint is None:
            raise ModelError("crosstalk of the form layout needs to know where the taxels are: give the model their positions, or a layout")
        return self.put_back(y, self.mine(y) + self.share * self.mine(s.footprint.places.neighbours @ y))
