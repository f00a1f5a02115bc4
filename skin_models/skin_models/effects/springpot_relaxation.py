"""Stress relaxation without a time constant: a springpot, between a spring (alpha = 0) and a dashpot (alpha = 1), beside both branches.

    f = k d^alpha x / d(t / 1 s)^alpha        a step of depth relaxes as k t^-alpha / Gamma(1 - alpha), t in s

As the Prony series of `skin_models.elements.springpot`, good to 1 % between 1 ms and 10^4 s; faster than that it is a dashpot, slower a
spring. Exact for a depth that is linear between samples, and in contact alone, as with one arm (`stress_relaxation`).

A sum of Maxwell arms spans it, so identification finds it as arms; it is simulated, not proposed.

Source: R. C. Koeller, Applications of fractional calculus to the theory of viscoelasticity, J. Appl. Mech. 51 (1984) 299-307; G. Beylkin
and L. Monzón, Appl. Comput. Harmon. Anal. 28 (2010) 131-149 (as a sum of exponentials).
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np

from skin_models.effect import Dynamic, Place
from skin_models.elements.relaxing import Relaxing
from skin_models.elements.springpot import Springpot
from skin_models.operators.contact import branches, depth_in_contact
from skin_models.parameter import SHAPE, quantity
from skin_models.signals import Motion, Sample


@lru_cache(maxsize=64)
def _series(alpha: float) -> Relaxing:
    return Springpot(c=1.0, alpha=alpha, shortest=1e-3, longest=1e4, allowed=1e-2).relaxing


@dataclass(frozen=True)
class SpringpotRelaxation(Dynamic):
    """A fractional element."""

    cause: ClassVar[str] = "stress_relaxation"
    form: ClassVar[str] = "springpot"
    proposed: ClassVar[bool] = False
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "springpot; Koeller 1984"
    linear: ClassVar[bool] = True

    k_sensed: float = quantity("N/m", 0.0, lower=0.0, typical=800.0, doc="stiffness about 1 s after a step, sensed")
    k_dispersed: float = quantity("N/m", 0.0, lower=0.0, typical=400.0, doc="stiffness about 1 s after a step, dispersed")
    alpha: float = quantity("1", 0.3, lower=0.02, upper=0.98, role=SHAPE, typical=0.3, doc="order of the derivative")

    def initial(self, rng=None) -> None:
        """None: the first sample is taken as rest.

        From then on the state is the first and the last depth in contact (m) and the arms' forces, (A,) or (A, C), for k = 1 (N).
        """
        return None

    def step(self, state, y, s: Sample, dt: float):
        """The Prony series by one sample at constant speed, times k on each branch."""
        series, x = _series(self.alpha), depth_in_contact(s.x)
        start, last, arms = (x, x, np.zeros((series.tau.size, *np.shape(x)))) if state is None else state
        v = (x - last) / dt
        e, gain = np.exp(-dt / series.tau), -series.stiffness * series.tau * np.expm1(-dt / series.tau)
        arms = (e * arms.T + np.multiply.outer(v, gain)).T
        f = series.k * (x - start) + series.b * v + arms.sum(axis=0)
        return (start, x, arms), y + branches(self.k_sensed, self.k_dispersed, f, s.x)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The series over the whole recording."""
        return y + branches(self.k_sensed, self.k_dispersed, s.once("springpot", self.alpha, lambda: self._stretched(s)), s.x)

    def _stretched(self, s: Motion) -> np.ndarray:
        x = depth_in_contact(s.x)
        return _series(self.alpha).batch(x - x[0], s.dt)
