"""Dead zone: nothing is transmitted below a threshold. Four forms for a taxel, and one for the skin above the taxels:

    taxel          y' = y - t tanh(y / t)                      smooth; y - t well above the threshold
    taxel, hard    y' = sign(y) max(|y| - t, 0)                with a corner at t
    taxel, gate    y' = y where |y| > t, else 0                with a step at t, as of a comparator
    taxel, gradual y' = y (1 - exp(-(|y| / t)^p))              many small contacts in parallel, each with a threshold of its own; a gate for
                                                               large p
    skin           sensed - t tanh(sensed / t), and what the taxels miss is dispersed: the applied force stays as it was

Sources: G. Tao and P. V. Kokotović, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, Wiley 1996, ch. 2; thresholds of
many as in W. Weibull, A statistical distribution function of wide applicability, J. Appl. Mech. 18 (1951) 293-297.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Memoryless, Place
from skin_models.parameter import SHAPE, quantity


def _smooth(y, threshold):
    return threshold * np.tanh(y / threshold) if threshold > 0.0 else 0.0 * y


@dataclass(frozen=True)
class TaxelDeadZone(Memoryless):
    """A taxel that answers only above a threshold, smoothly."""

    cause: ClassVar[str] = "dead_zone"
    places: ClassVar = {"taxel": Place.TAXEL}
    source: ClassVar[str] = "Tao and Kokotović 1996, ch. 2, smoothed"

    threshold: float = quantity("N", 0.0, lower=0.0, upper=1e3, typical=0.5, doc="force t that is lost")

    def apply(self, y, s):
        """y - t tanh(y / t)."""
        mine = self.mine(y)
        return self.put_back(y, mine - _smooth(mine, self.threshold))


@dataclass(frozen=True)
class HardDeadZone(Memoryless):
    """A taxel that answers only above a threshold, with a corner."""

    cause: ClassVar[str] = "dead_zone"
    form: ClassVar[str] = "hard"
    places: ClassVar = {"taxel": Place.TAXEL}
    source: ClassVar[str] = "Tao and Kokotović 1996, ch. 2"

    threshold: float = quantity("N", 0.0, lower=0.0, upper=1e3, typical=0.5, doc="force t that is lost")

    def apply(self, y, s):
        """sign(y) max(|y| - t, 0)."""
        mine = self.mine(y)
        return self.put_back(y, mine - np.clip(mine, -self.threshold, self.threshold))


@dataclass(frozen=True)
class GatedTaxel(Memoryless):
    """A taxel that is silent up to a threshold and right above it."""

    cause: ClassVar[str] = "dead_zone"
    form: ClassVar[str] = "gate"
    places: ClassVar = {"taxel": Place.TAXEL}
    source: ClassVar[str] = "Tao and Kokotović 1996, ch. 2; threshold of event-driven taxels"

    threshold: float = quantity("N", 0.0, lower=0.0, upper=1e3, typical=0.5, doc="force t that must be exceeded")

    def apply(self, y, s):
        """y where |y| > t, else 0."""
        mine = self.mine(y)
        return self.put_back(y, mine * (np.abs(mine) > self.threshold))


@dataclass(frozen=True)
class GradualTaxel(Memoryless):
    """A taxel that answers by and by: each of its many contacts from a threshold of its own on."""

    cause: ClassVar[str] = "dead_zone"
    form: ClassVar[str] = "gradual"
    places: ClassVar = {"taxel": Place.TAXEL}
    source: ClassVar[str] = "Weibull 1951"

    threshold: float = quantity(
        "N", 0.0, lower=0.0, upper=1e3, typical=0.2, scan=(0.05, 0.2, 0.8), doc="force t at which 63 % of the contacts answer"
    )
    sharpness: float = quantity(
        "1", 2.0, lower=0.5, upper=10.0, role=SHAPE, typical=2.0, scan=(2.0,), doc="exponent p: how alike the contacts' thresholds are"
    )

    def apply(self, y, s):
        """y (1 - exp(-(|y| / t)^p))."""
        if self.threshold == 0.0:
            return y
        mine = self.mine(y)
        with np.errstate(over="ignore"):  # far above the threshold
            return self.put_back(y, -mine * np.expm1(-((np.abs(mine) / self.threshold) ** self.sharpness)))


@dataclass(frozen=True)
class SkinDeadZone(Memoryless):
    """A gap between skin and taxels that a first force must close."""

    cause: ClassVar[str] = "dead_zone"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Tao and Kokotović 1996, ch. 2, smoothed"

    threshold: float = quantity("N", 0.0, lower=0.0, upper=1e3, typical=0.5, doc="force t that does not reach the taxels")

    def apply(self, y, s):
        """t tanh(sensed / t) goes from the sensed to the dispersed branch."""
        lost = _smooth(y[0], self.threshold)
        return y + np.array([-lost, lost])
