"""Effects of an array that change while it is pressed: they bend the ratios of the taxels over depth or time.

All act on the share of every taxel, exp(-(r / c)^2) with r from the contact, and keep the total:

    Leaning    the contact moves by `shift` along `axis` from the surface to the greatest depth          off_centre
    Walking    the contact moves by `shift` along `axis` from the first to the last moment               off_centre
    Widening   the width is (1 + growth x) c at depth x, c at the surface                                spread_depth

They need to know where the taxels are, so they are made for one layout and are not in the catalogue.
"""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from skin_models.effect import Memoryless, Place
from skin_models.operators.elapsed import Elapsed
from skin_models.parameter import quantity

Pairs = tuple[tuple[float, float], ...]


def _moved(places: Pairs, axis: tuple[float, float], width: float, by: Any) -> np.ndarray:
    """Factor on every taxel's share when the contact moves `by` (m) along `axis`: (T,) or (T, N)."""
    along = np.array(places) @ np.array(axis)
    return np.exp((2.0 * np.multiply.outer(along, by) - np.square(by)) / width**2)


class OverTaxels:
    """An effect that knows where the `taxels` are, as seen from the contact."""

    def seen_from(self, contact: np.ndarray) -> "OverTaxels":
        """The same effect with its taxels as they are seen from `contact` (2,) m."""
        seen = np.array(self.taxels) - contact
        return replace(self, taxels=tuple((float(x), float(y)) for x, y in seen))


@dataclass(frozen=True)
class Leaning(OverTaxels, Memoryless):
    """A plunger or a mount that leans: the contact moves aside as it goes deeper."""

    cause: ClassVar[str] = "off_centre"
    form: ClassVar[str] = "lean"
    places: ClassVar = {"rig": Place.SPREAD}
    source: ClassVar[str] = "thesis section 4.3.4, its Gaussian moved aside"

    taxels: Pairs = ()
    axis: tuple[float, float] = (1.0, 0.0)
    width: float = 5.25e-3
    deepest: float = 1e-3
    shift: float = quantity("m", 0.0, lower=-0.01, upper=0.01, typical=2e-4, doc="at the greatest depth")

    def apply(self, y, s):
        return y * _moved(self.taxels, self.axis, self.width, self.shift * np.maximum(s.x, 0.0) / self.deepest)


@dataclass(frozen=True)
class Walking(OverTaxels, Elapsed):
    """A specimen that creeps from under the plunger: the contact moves aside as time goes on."""

    cause: ClassVar[str] = "off_centre"
    form: ClassVar[str] = "walk"
    places: ClassVar = {"rig": Place.SPREAD}
    source: ClassVar[str] = "thesis section 4.3.4, its Gaussian moved aside"

    taxels: Pairs = ()
    axis: tuple[float, float] = (1.0, 0.0)
    width: float = 5.25e-3
    seconds: float = 60.0
    shift: float = quantity("m", 0.0, lower=-0.01, upper=0.01, typical=2e-4, doc="after `seconds`, the length of the first session")

    def apply(self, y, elapsed):
        return y * _moved(self.taxels, self.axis, self.width, self.shift * elapsed / self.seconds)


@dataclass(frozen=True)
class Widening(OverTaxels, Memoryless):
    """A spread that is wider the deeper the skin is pressed; what a wider spread adds aside it takes from the centre."""

    cause: ClassVar[str] = "spread_depth"
    places: ClassVar = {"skin": Place.SPREAD}
    source: ClassVar[str] = "thesis Table 4-8, whose width changes from depth to depth"

    taxels: Pairs = ()
    width: float = 5.25e-3
    growth: float = quantity("1/m", 0.0, lower=-2000.0, upper=2000.0, typical=100.0, doc="relative growth of the width per metre of depth")

    def apply(self, y, s):
        wider = np.maximum(1.0 + self.growth * np.maximum(s.x, 0.0), 0.2)
        square = np.sum(np.square(self.taxels), axis=1) / self.width**2
        return y * np.exp(np.multiply.outer(square, 1.0 - wider**-2.0)) * wider**-2.0
