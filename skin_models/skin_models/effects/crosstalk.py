"""Crosstalk: a taxel repeats its neighbours beyond what the spread through the skin explains.

    y'[i] = y[i] + c mean(y[i-1], y[i+1])        in the order of the taxels; a taxel at the end has one neighbour, a lone one none

Source: T. D'Alessio, Measurement errors in the scanning of piezoresistive sensor arrays, Sensors and Actuators A 72 (1999) 71-76.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Memoryless, Place
from skin_models.parameter import quantity


@dataclass(frozen=True)
class Crosstalk(Memoryless):
    """Electrical leakage from a taxel's neighbours in the row."""

    cause: ClassVar[str] = "crosstalk"
    places: ClassVar = {"taxel": Place.TAXEL}
    source: ClassVar[str] = "D'Alessio 1999"
    linear: ClassVar[bool] = True

    share: float = quantity("1", 0.0, lower=-1.0, upper=1.0, typical=0.1, doc="share c of the neighbours' mean")

    def apply(self, y, s):
        """y + share * (mean of the neighbours in the row)."""
        return self.put_back(y, self.mine(y) + self.share * self.mine(_neighbours_mean(y)))


def _neighbours_mean(y):
    if len(y) < 2:
        return np.zeros_like(y, float)
    mean = np.empty(np.shape(y))
    mean[0], mean[-1] = y[1], y[-2]
    mean[1:-1] = 0.5 * (y[:-2] + y[2:])
    return mean
