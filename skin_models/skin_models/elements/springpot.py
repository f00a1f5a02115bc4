"""The springpot: between a spring (alpha = 0) and a dashpot (alpha = 1).

    f = c d^alpha x / dt^alpha,        G(t) = c t^-alpha / Gamma(1 - alpha),        J(t) = t^alpha / (c Gamma(1 + alpha))

Here as a Prony series for times within `shortest` … `longest`. The trapezoidal rule in u = ln(rate) for

    t^-alpha = 1 / Gamma(alpha) ∫ exp(alpha u - t exp(u)) du

converges exponentially: a spacing h leaves a relative ripple of about 2 |Gamma(alpha + 2 pi i / h)| / Gamma(alpha). h is chosen for
half of the error allowed; the arms that are far too slow are summed into a spring and those far too fast into a dashpot. `error` is
the relative error that the series then really has, in relaxation and in creep.

Source: G. Beylkin and L. Monzón, Approximation by exponential sums revisited, Appl. Comput. Harmon. Anal. 28 (2010) 131-149; for
the element, R. C. Koeller, Applications of fractional calculus to the theory of viscoelasticity, J. Appl. Mech. 51 (1984) 299-307.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import gamma, loggamma

from skin_models.elements.creeping import Creeping
from skin_models.elements.element import Element
from skin_models.elements.prony import Prony
from skin_models.elements.relaxing import Relaxing
from skin_models.errors import ModelError
from skin_models.parameter import check_parameters, quantity


@dataclass(frozen=True)
class Springpot(Element):
    """A fractional element. Raises `ModelError` for a band of times that is empty."""

    c: float = quantity("N*s^alpha/m", lower=1e-12, doc="size: stiffness for alpha = 0, damping for alpha = 1")
    alpha: float = quantity("1", lower=0.02, upper=0.98, doc="order of the derivative")
    shortest: float = quantity("s", 1e-3, lower=1e-12, doc="shortest time that matters, such as the sample period")
    longest: float = quantity("s", 1e3, lower=1e-12, doc="longest time that matters, such as the length of a recording")
    allowed: float = quantity("1", 1e-4, lower=1e-9, upper=0.1, doc="relative error allowed between the two")

    def __post_init__(self) -> None:
        check_parameters(self)
        if not self.shortest < self.longest:
            raise ModelError(f"a springpot needs shortest < longest, not {self.shortest:g} s and {self.longest:g} s")

    @cached_property
    def series(self) -> Prony:
        """The Prony series that stands for it."""
        h = self._spacing()
        slowest = np.log(self.allowed / (4.0 * self.longest))
        fastest = np.log(4.0 / (self.allowed * self.shortest))
        rates = np.exp(np.arange(slowest, fastest + h, h))
        scale = self.c * h / (gamma(self.alpha) * gamma(1.0 - self.alpha))
        stiffness = scale * rates**self.alpha
        slower_still = stiffness[0] / np.expm1(self.alpha * h)  # geometric sums of the stiffness of all slower arms
        faster_still = stiffness[-1] / rates[-1] / np.expm1((1.0 - self.alpha) * h)  # and of the damping of all faster ones
        return Prony(k=float(slower_still), b=float(faster_still), arms=tuple(zip(stiffness.tolist(), (1.0 / rates).tolist(), strict=True)))

    def _spacing(self) -> float:
        spacings = np.geomspace(3.0, 0.05, 200)
        ripple = 2.0 * np.exp(loggamma(self.alpha + 2j * np.pi / spacings).real - loggamma(self.alpha))
        return float(spacings[np.argmax(ripple <= 0.5 * self.allowed)])

    @property
    def error(self) -> float:
        """Greatest relative error of relaxation and creep between `shortest` and `longest`, on a grid of 2000 times."""
        t = np.geomspace(self.shortest, self.longest, 2000)
        relaxation, creep = self.relaxation(t) / self.ideal_relaxation(t), self.creep(t) / self.ideal_creep(t)
        return float(max(np.max(np.abs(relaxation - 1.0)), np.max(np.abs(creep - 1.0))))

    def ideal_relaxation(self, t):
        """G(t) = c t^-alpha / Gamma(1 - alpha) of the true springpot, N/m."""
        return self.c * np.asarray(t, float) ** -self.alpha / gamma(1.0 - self.alpha)

    def ideal_creep(self, t):
        """J(t) = t^alpha / (c Gamma(1 + alpha)) of the true springpot, m/N."""
        return np.asarray(t, float) ** self.alpha / (self.c * gamma(1.0 + self.alpha))

    @property
    def relaxing(self) -> Relaxing:
        """The series driven by depth."""
        return self.series.relaxing

    @property
    def creeping(self) -> Creeping:
        """The series driven by force."""
        return self.series.creeping
