"""Stress relaxation of an arm that flows the faster the more it carries: a spring in series with a dashpot of activated flow.

    q' = v - A sinh(q / q_0),        f = k q        q: stretch of the spring, m

From small loads it decays exponentially with the time constant q_0 / A (`flow_time`), from large ones like the logarithm of time, and its
loop over depth hardly depends on the rate: between a Maxwell arm and a dry slider. Exact for steps of depth followed by rest, whatever
the step: with u = tanh(q / 2 q_0) a step d and a rest dt are u -> e (u + t) / (1 + t u), t = tanh(d / 2 q_0), e = exp(-A dt / q_0).

Sources: H. Eyring, J. Chem. Phys. 4 (1936) 283-291; R. N. Haward and G. Thackray, Proc. R. Soc. A 302 (1968) 453-472 (spring and
dashpot).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Dynamic, Place
from skin_models.operators.contact import branches, depth_in_contact
from skin_models.operators.scan import running_fraction
from skin_models.parameter import SHAPE, quantity
from skin_models.signals import Motion, Sample

FULL = 1.0 - 1e-15  # greatest |u|: a spring stretched by 35 q_0


@dataclass(frozen=True)
class EyringRelaxation(Dynamic):
    """One arm beside both branches. State: u, and the last depth in contact (m; None before the first sample)."""

    cause: ClassVar[str] = "stress_relaxation"
    form: ClassVar[str] = "eyring"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Eyring 1936; Haward and Thackray 1968"
    linear: ClassVar[bool] = True

    k_sensed: float = quantity("N/m", 0.0, lower=0.0, typical=4000.0, doc="stiffness of the flowing arm, sensed")
    k_dispersed: float = quantity("N/m", 0.0, lower=0.0, typical=2000.0, doc="stiffness of the flowing arm, dispersed")
    stretch: float = quantity(
        "m",
        0.1e-3,
        lower=1e-6,
        upper=0.05,
        role=SHAPE,
        typical=0.1e-3,
        scan=(0.02e-3, 0.08e-3, 0.3e-3),
        doc="stretch that speeds its flow up",
    )
    flow_time: float = quantity(
        "s", 10.0, lower=1e-3, upper=1e5, role=SHAPE, typical=10.0, scan=(3.0, 30.0, 300.0), doc="time constant at small loads"
    )

    def initial(self, rng=None) -> tuple[float, None]:
        """An arm without load, before the first sample."""
        return 0.0, None

    def step(self, state, y, s: Sample, dt: float):
        """u after one sample, and k q on each branch."""
        u, last = state
        x = depth_in_contact(s.x)
        gain, shift = self._map(x - (x if last is None else last), 0.0 if last is None else dt)
        u = gain * (u + shift) / (1.0 + shift * u)
        return (u, x), y + branches(self.k_sensed, self.k_dispersed, self._carried(u), s.x)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same maps in log2(N) passes over the whole recording."""
        stretched = s.once("Eyring", (self.stretch, self.flow_time), lambda: self._stretched(s))
        return y + branches(self.k_sensed, self.k_dispersed, stretched, s.x)

    def _stretched(self, s: Motion) -> np.ndarray:
        x = depth_in_contact(s.x)
        u = running_fraction(*self._map(np.diff(x, prepend=x[0]), np.where(np.arange(x.size) > 0, s.dt, 0.0)))
        return self._carried(u)

    def _map(self, dx, dt):
        return np.exp(-dt / self.flow_time) + 0.0 * dx, np.tanh(dx / (2.0 * self.stretch))

    def _carried(self, u):
        return 2.0 * self.stretch * np.arctanh(np.clip(u, -FULL, FULL))
