"""Effects of an array that change the ratios of the taxels over depth or time.

All act on the share of every taxel, exp(-(r / c)^2) with r the distance from the contact; all but the last keep the total:

    Leaning    the contact moves by `shift` along `axis` from the surface to the greatest depth          off_centre
    Walking    the contact moves by `shift` along `axis` from the first to the last moment               off_centre
    Widening   the width is (1 + growth (x - x_0)) c at depth x                                          spread_depth
    Reaching   the same, with the share right under the contact as it was                                spread_depth

`Settling` and `SettlingReaching` are variants of the last two that change most within the first depth h: x is replaced by h (1 - exp(-x /
h)).

They need the positions of the taxels, so they are made for one layout and are not in the catalogue.
"""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from skin_models.effect import Memoryless, Place
from skin_models.effects.spread_depth import settled
from skin_models.operators.elapsed import Elapsed
from skin_models.parameter import SHAPE, quantity

Pairs = tuple[tuple[float, float], ...]


def _moved(places: Pairs, axis: tuple[float, float], width: float, by: Any) -> np.ndarray:
    """Factor on every taxel's share, (T,) or (T, N), if the contact moves `by` (m) along `axis`."""
    along = np.array(places) @ np.array(axis)
    return np.exp((2.0 * np.multiply.outer(along, by) - np.square(by)) / width**2)


class OverTaxels:
    """An effect that knows the positions of the `taxels` relative to the contact."""

    def seen_from(self, contact: np.ndarray) -> "OverTaxels":
        """The same effect with positions relative to `contact` (2,) m."""
        seen = np.array(self.taxels) - contact
        return replace(self, taxels=tuple((float(x), float(y)) for x, y in seen))


@dataclass(frozen=True)
class Leaning(OverTaxels, Memoryless):
    """A plunger or mount that leans: the contact moves sideways as it goes deeper."""

    cause: ClassVar[str] = "off_centre"
    form: ClassVar[str] = "lean"
    places: ClassVar = {"rig": Place.SPREAD}
    source: ClassVar[str] = "thesis section 4.3.4, its Gaussian moved aside"

    taxels: Pairs = ()
    axis: tuple[float, float] = (1.0, 0.0)
    width: float = 5.25e-3
    deepest: float = 1e-3
    shift: float = quantity("m", 0.0, lower=-0.01, upper=0.01, typical=2e-4, doc="sideways shift of the contact at the greatest depth")

    def apply(self, y, s):
        """Readings y (T,) or (T, N), N, under a contact that is displaced by `shift` x / `deepest`."""
        return y * _moved(self.taxels, self.axis, self.width, self.shift * np.maximum(s.x, 0.0) / self.deepest)


@dataclass(frozen=True)
class Walking(OverTaxels, Elapsed):
    """A specimen that creeps from under the plunger: the contact moves sideways with time."""

    cause: ClassVar[str] = "off_centre"
    form: ClassVar[str] = "walk"
    places: ClassVar = {"rig": Place.SPREAD}
    source: ClassVar[str] = "thesis section 4.3.4, its Gaussian moved aside"

    taxels: Pairs = ()
    axis: tuple[float, float] = (1.0, 0.0)
    width: float = 5.25e-3
    seconds: float = 60.0
    shift: float = quantity(
        "m", 0.0, lower=-0.01, upper=0.01, typical=2e-4, doc="sideways shift of the contact by the end of the longest session"
    )

    def apply(self, y, elapsed):
        """Readings y (T,) or (T, N), N, under a contact that is displaced by `shift` t / `seconds`, t the time `elapsed`, s."""
        return y * _moved(self.taxels, self.axis, self.width, self.shift * elapsed / self.seconds)


@dataclass(frozen=True)
class Widening(OverTaxels, Memoryless):
    """A spread whose width grows with depth; what outer taxels gain the centre loses."""

    cause: ClassVar[str] = "spread_depth"
    places: ClassVar = {"skin": Place.SPREAD}
    source: ClassVar[str] = "thesis Table 4-8, whose width changes from depth to depth"

    taxels: Pairs = ()
    width: float = 5.25e-3
    usual: float = 0.0  # m, the depth x_0 at which the shares equal those fitted over the whole record
    growth: float = quantity("1/m", 0.0, lower=-2000.0, upper=2000.0, typical=100.0, doc="relative growth of the width per metre of depth")

    def apply(self, y, s):
        """Readings y (T,) or (T, N), N, times exp((r / c)^2 (1 - w^-2)) / w^2, where w is the width over c."""
        wider = self.wider(s.x)
        square = np.sum(np.square(self.taxels), axis=1) / self.width**2
        return y * np.exp(np.multiply.outer(square, 1.0 - wider**-2.0)) * wider**-2.0

    def wider(self, x):
        """The width at depth `x` (m) relative to c, at least 0.2."""
        return np.maximum(1.0 + self.growth * (self.reached(np.maximum(x, 0.0)) - self.reached(self.usual)), 0.2)

    def reached(self, x):
        """The length, m, that the width is linear in, at a depth x >= 0."""
        return x


@dataclass(frozen=True)
class Reaching(Widening):
    """A spread whose width grows with depth while its centre keeps its strength: more of the force reaches the taxels."""

    form: ClassVar[str] = "reaching"

    def apply(self, y, s):
        """As Widening, without its loss in the centre."""
        return super().apply(y, s) * self.wider(s.x) ** 2


@dataclass(frozen=True)
class Settling(Widening):
    """Widening that slows down with depth, as when a round tip grows into its footprint."""

    form: ClassVar[str] = "settling"

    settling: float = quantity("m", 3e-4, lower=1e-6, upper=0.05, role=SHAPE, typical=3e-4, doc="depth h within which most of it comes")

    def reached(self, x):
        """h (1 - exp(-x / h))."""
        return settled(x, self.settling)


@dataclass(frozen=True)
class SettlingReaching(Reaching, Settling):
    """Reaching that slows down with depth in the same way."""

    form: ClassVar[str] = "settling_reaching"
