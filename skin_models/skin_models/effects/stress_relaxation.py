"""Stress relaxation: the skin's force decays while the depth is held.

Maxwell arm parallel to both springs, the simplest Prony series (thesis eqs 6 and 8),

    f' = k v - f / tau        f(0) = 0, in contact        added to the sensed and to the dispersed force, each with its own k.

The step is exact for a depth that is linear between samples (first-order hold):

    f[n] = e f[n-1] + k (1 - e) tau / dt (x[n] - x[n-1]),        e = exp(-dt / tau).

Source: N. W. Tschoegl, The Phenomenological Theory of Linear Viscoelastic Behavior, Springer 1989, ch. 3.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.signal import lfilter

from skin_models.effect import Dynamic, Place
from skin_models.operators.contact import branches, depth_in_contact
from skin_models.parameter import SHAPE, quantity
from skin_models.signals import Motion, Sample


@dataclass(frozen=True)
class StressRelaxation(Dynamic):
    """One Maxwell arm beside both branches of the dispersion model."""

    cause: ClassVar[str] = "stress_relaxation"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Tschoegl 1989, ch. 3; thesis eqs 6, 8"
    linear: ClassVar[bool] = True

    k_sensed: float = quantity("N/m", 0.0, lower=0.0, typical=1500.0, doc="stiffness of the relaxing arm, sensed")
    k_dispersed: float = quantity("N/m", 0.0, lower=0.0, typical=1500.0, doc="stiffness of the relaxing arm, dispersed")
    tau: float = quantity(
        "s", 1.0, lower=1e-3, upper=1e4, role=SHAPE, typical=1.0, doc="relaxation time",
        scan=(0.03, 0.06, 0.12, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0),
    )  # fmt: skip

    def initial(self, rng=None) -> tuple[float, float | None]:
        """Stretch of the arm's spring, m, and last depth in contact, m: None before the first sample."""
        return 0.0, None  # stretch of the arm's spring (m); last depth in contact (m): at rest at the first sample

    def step(self, state, y, s: Sample, dt: float):
        """f[n] / k = e f[n-1] / k + (1 - e) tau / dt (x[n] - x[n-1]); f on each branch."""
        stretch, last = state
        x = depth_in_contact(s.x)
        last = x if last is None else last
        e = np.exp(-dt / self.tau)
        stretch = e * stretch + (1.0 - e) * self.tau / dt * (x - last)
        return (stretch, x), y + branches(self.k_sensed, self.k_dispersed, stretch, s.x)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same recursion as a filter."""
        return y + branches(self.k_sensed, self.k_dispersed, s.once("Maxwell", self.tau, lambda: self._stretched(s)), s.x)

    def _stretched(self, s: Motion) -> np.ndarray:
        e = np.exp(-s.dt / self.tau)
        gain = (1.0 - e) * self.tau / s.dt
        x = depth_in_contact(s.x)
        return lfilter([gain, -gain], [1.0, -e], x - x[0])
