"""Effects of an array that change while it is pressed: they bend the ratios of the taxels over depth or time.

All act on the share of every taxel, exp(-(r / c)^2) with r from the contact, and all but the last keep the total:

    Leaning    the contact moves by `shift` along `axis` from the surface to the greatest depth          off_centre
    Walking    the contact moves by `shift` along `axis` from the first to the last moment               off_centre
    Widening   the width is (1 + growth (x - x_0)) c at depth x                                          spread_depth
    Reaching   the same, with the share right under the contact as it was                                spread_depth

Both spread most in the first depth h as `Settling` and `SettlingReaching`, with h (1 - exp(-x / h)) in place of x.

They need to know where the taxels are, so they are made for one layout and are not in the catalogue.
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
        """Readings y (T,) or (T, N), N, under a contact that is `shift` x / `deepest` aside."""
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
        """Readings y (T,) or (T, N), N, under a contact that is `shift` t / `seconds` aside, t the time `elapsed`, s."""
        return y * _moved(self.taxels, self.axis, self.width, self.shift * elapsed / self.seconds)


@dataclass(frozen=True)
class Widening(OverTaxels, Memoryless):
    """A spread that is wider the deeper the skin is pressed; what a wider spread adds aside it takes from the centre."""

    cause: ClassVar[str] = "spread_depth"
    places: ClassVar = {"skin": Place.SPREAD}
    source: ClassVar[str] = "thesis Table 4-8, whose width changes from depth to depth"

    taxels: Pairs = ()
    width: float = 5.25e-3
    usual: float = 0.0  # m, the depth x_0 at which the shares are as measured on the whole
    growth: float = quantity("1/m", 0.0, lower=-2000.0, upper=2000.0, typical=100.0, doc="relative growth of the width per metre of depth")

    def apply(self, y, s):
        """Readings y (T,) or (T, N), N, times exp((r / c)^2 (1 - w^-2)) / w^2, w how many times as wide the spread is."""
        wider = self.wider(s.x)
        square = np.sum(np.square(self.taxels), axis=1) / self.width**2
        return y * np.exp(np.multiply.outer(square, 1.0 - wider**-2.0)) * wider**-2.0

    def wider(self, x):
        """The width at depth `x` (m) over c, at least 0.2."""
        return np.maximum(1.0 + self.growth * (self.reached(np.maximum(x, 0.0)) - self.reached(self.usual)), 0.2)

    def reached(self, x):
        """What the width follows at a depth x >= 0, m."""
        return x


@dataclass(frozen=True)
class Reaching(Widening):
    """A spread that is wider the deeper the skin is pressed, and as strong in the centre: more of the force reaches the taxels."""

    form: ClassVar[str] = "reaching"

    def apply(self, y, s):
        """What Widening makes of it, less its loss in the centre."""
        return super().apply(y, s) * self.wider(s.x) ** 2


@dataclass(frozen=True)
class Settling(Widening):
    """The same, less the deeper it is, as a round tip grows into its footprint."""

    form: ClassVar[str] = "settling"

    settling: float = quantity("m", 3e-4, lower=1e-6, upper=0.05, role=SHAPE, typical=3e-4, doc="depth h within which most of it comes")

    def reached(self, x):
        """h (1 - exp(-x / h))."""
        return settled(x, self.settling)


@dataclass(frozen=True)
class SettlingReaching(Reaching, Settling):
    """The same of a spread that is as strong in the centre."""

    form: ClassVar[str] = "settling_reaching"
