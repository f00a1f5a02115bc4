"""Hysteresis: a loop that does not depend on rate, with memory of the turning points. Six forms:

    skin, Prandtl-Ishlinskii   f = k E_r[x]        one elastic-plastic element: stiffness k until it yields at r (several add up)
    skin, loaded               f = k (1 - g + g x / l) E_r[x],  l = 1 mm       the same, and what slides is pressed together by the load
    skin, Bouc-Wen             f = k z,  z' = v - |v| z / r        the same with a gradual yield (n = 1, beta = 1, gamma = 0: Dahl's model)
    skin, lagging              f = -k E_r[x]       a loop the other way round: the force is less on the way in than on the way out
    taxel, load cell           y' = y - a E_r[y]        the reading lags behind at every reversal: higher on the way down for a > 0
    taxel, load cell, loaded   y' = y - a (1 - g + g |y| / F) E_r[y],  F = 1 N         the same with loops that grow with the load

E_r is the stop operator of `skin_models.operators.play`, exact for any path that is monotone between samples. Bouc-Wen is stepped exactly
for such a path too: z[n] = e z[n-1] + sign(dx) r (1 - e), e = exp(-|dx| / r). These three dissipate: no closed path returns energy. The
lagging one returns energy on every path, which no passive skin does; play operators and Preisach relays with positive weights are of this
kind, and so are recordings in which the depth lags behind the encoder in a way that no clearance explains.

Sources: P. Krejčí, Hysteresis, Convexity and Dissipation, 1996; F. Ikhouane and J. Rodellar, Systems with Hysteresis, Wiley 2007
(Bouc-Wen); P. Dahl, A Solid Friction Model, TOR-0158, 1968; W. D. Iwan, J. Appl. Mech. 33 (1966) 893-900;
K. Kuhnen, Eur. J. Control 9 (2003) 407-418 (sensors and actuators).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Dynamic, Place
from skin_models.operators.contact import branches, depth_in_contact
from skin_models.operators.play import play_step, stop
from skin_models.operators.scan import running_affine
from skin_models.parameter import SHAPE, quantity
from skin_models.signals import Motion, Sample

REFERENCE = 1e-3  # m, the depth l
REFERENCE_FORCE = 1.0  # N, the force F
DEPTHS = (0.02e-3, 0.05e-3, 0.1e-3, 0.2e-3, 0.4e-3, 0.8e-3, 1.5e-3)  # m


@dataclass(frozen=True)
class SkinHysteresis(Dynamic):
    """One elastic-plastic element beside both branches."""

    cause: ClassVar[str] = "hysteresis"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Prandtl-Ishlinskii; Krejčí 1996"
    linear: ClassVar[bool] = True

    k_sensed: float = quantity("N/m", 0.0, lower=0.0, typical=4000.0, doc="stiffness before it yields, sensed")
    k_dispersed: float = quantity("N/m", 0.0, lower=0.0, typical=2000.0, doc="stiffness before it yields, dispersed")
    threshold: float = quantity(
        "m", 0.2e-3, lower=1e-6, upper=0.05, role=SHAPE, typical=0.2e-3, scan=DEPTHS, doc="stretch r at which it yields"
    )

    def initial(self, rng=None) -> None:
        """None: the first sample is taken as rest. From then on the state is the play P, m."""
        return None

    def step(self, state, y, s: Sample, dt: float):
        """k (x - P) on each branch, by the weight of the form."""
        x = depth_in_contact(s.x)
        state = play_step(state, x, self.threshold)
        return state, y + branches(self.k_sensed, self.k_dispersed, self._weight(x) * (x - state), s.x)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """k times the stop operator over the whole recording, by the weight of the form."""
        stretched = s.once("stop", self.threshold, lambda: stop(depth_in_contact(s.x), self.threshold))
        return y + branches(self.k_sensed, self.k_dispersed, self._weight(s.x) * stretched, s.x)

    def _weight(self, x):
        """What the force of the element is multiplied by at a depth x, m; in the air there is none."""
        return 1.0


@dataclass(frozen=True)
class LoadedHysteresis(SkinHysteresis):
    """The same with loops that grow in height with depth: what slides is pressed together by the load."""

    form: ClassVar[str] = "loaded"
    source: ClassVar[str] = "Prandtl-Ishlinskii under a load; elements as in Iwan 1966"
    proposed: ClassVar[bool] = False
    refines: ClassVar[type] = SkinHysteresis

    growth: float = quantity("1", 0.0, lower=0.0, upper=1.0, role=SHAPE, typical=0.5, doc="share g that grows in proportion to depth")

    def _weight(self, x):
        return 1.0 - self.growth + self.growth * x / REFERENCE


@dataclass(frozen=True)
class LaggingHysteresis(SkinHysteresis):
    """The same with the loop run the other way round: what a play operator adds stays behind the depth at every reversal."""

    form: ClassVar[str] = "lagging"
    source: ClassVar[str] = "Prandtl-Ishlinskii, of plays; Krejčí 1996"

    def _weight(self, x):
        return -1.0


@dataclass(frozen=True)
class BoucWenHysteresis(Dynamic):
    """A gradually yielding element beside both branches."""

    cause: ClassVar[str] = "hysteresis"
    form: ClassVar[str] = "bouc_wen"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Bouc-Wen, n = 1; Ikhouane and Rodellar 2007; Dahl 1968"
    linear: ClassVar[bool] = True

    k_sensed: float = quantity("N/m", 0.0, lower=0.0, typical=4000.0, doc="stiffness after a turning point, sensed")
    k_dispersed: float = quantity("N/m", 0.0, lower=0.0, typical=2000.0, doc="stiffness after a turning point, dispersed")
    threshold: float = quantity(
        "m", 0.2e-3, lower=1e-6, upper=0.05, role=SHAPE, typical=0.2e-3, scan=DEPTHS, doc="stretch r that it tends to"
    )

    def initial(self, rng=None) -> tuple[float, float | None]:
        """Stretch z, m, and last depth in contact, m: None before the first sample."""
        return 0.0, None

    def step(self, state, y, s: Sample, dt: float):
        """z[n] = e z[n-1] + sign(dx) r (1 - e), e = exp(-|dx| / r); k z on each branch."""
        z, last = state
        x = depth_in_contact(s.x)
        gain, offset = self._map(x - (x if last is None else last))
        z = gain * z + offset
        return (z, x), y + branches(self.k_sensed, self.k_dispersed, z, s.x)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same recurrence in log2(N) passes over the whole recording."""
        return y + branches(self.k_sensed, self.k_dispersed, s.once("Bouc-Wen", self.threshold, lambda: self._stretched(s)), s.x)

    def _stretched(self, s: Motion) -> np.ndarray:
        x = depth_in_contact(s.x)
        return running_affine(*self._map(np.diff(x, prepend=x[0])))

    def _map(self, dx):
        path = -np.abs(dx) / self.threshold
        return np.exp(path), -np.sign(dx) * self.threshold * np.expm1(path)


@dataclass(frozen=True)
class SensorHysteresis(Dynamic):
    """The reading stays closer to where it came from."""

    cause: ClassVar[str] = "hysteresis"
    places: ClassVar = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "Prandtl-Ishlinskii; Kuhnen 2003"
    linear: ClassVar[bool] = True

    relative: float = quantity("1", 0.0, lower=-1.0, upper=1.0, typical=0.1, doc="share a of the reading that lags; the loop is 2 a r high")
    threshold: float = quantity(
        "N",
        1.0,
        lower=1e-4,
        upper=1e3,
        role=SHAPE,
        typical=1.0,
        scan=(0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0),
        doc="force r at which it yields",
    )

    def initial(self, rng=None) -> None:
        """None: the first sample is taken as rest. From then on the state is the play P, N."""
        return None

    def step(self, state, y, s: Sample, dt: float):
        """y - a (y - P), the second term by the weight of the form."""
        mine = self.mine(y)
        state = play_step(state, mine, self.threshold)
        return state, self.put_back(y, mine - self.relative * self._weight(mine) * (mine - state))

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """y - a times the stop operator over the whole recording, by the weight of the form."""
        mine = self.mine(y)
        return self.put_back(y, mine - self.relative * self._weight(mine) * stop(mine, self.threshold))

    def _weight(self, y):
        """What the lag of the reading is multiplied by at a force y, N."""
        return 1.0


@dataclass(frozen=True)
class LoadedSensorHysteresis(SensorHysteresis):
    """The same with loops that grow in height with the load."""

    form: ClassVar[str] = "loaded"
    source: ClassVar[str] = "Prandtl-Ishlinskii under a load; Kuhnen 2003"
    proposed: ClassVar[bool] = False
    refines: ClassVar[type] = SensorHysteresis

    growth: float = quantity("1", 0.0, lower=0.0, upper=1.0, role=SHAPE, typical=0.5, doc="share g that grows in proportion to the load")

    def _weight(self, y):
        return 1.0 - self.growth + self.growth * np.abs(y) / REFERENCE_FORCE
