"""Lag: a sensor follows its input as a filter of first or of second order, or averages it.

    first order      tau z' + z = y,                                    y' = z
    second order     (tau / 2 zeta)^2 z'' + tau z' + z = y,             y' = z        zeta = 1 / sqrt 2: Butterworth; 1: two equal poles
    in part          T z' + z = y,                         y' = y + tau / T (z - y)   0 <= tau <= T: the rest of it is prompt
    averaged         z(t) = 1/W int_(t - W)^t y,  W = 2 tau             y' = z        as many amplifiers do
    one-sided        tau r^(-1/2) z' + z = y where y > z, tau r^(1/2) z' + z = y elsewhere,      y' = z        r > 1: slow to recover

All start at rest, z(0) = y(0), and are late by tau for slow inputs; tau = 0 is the identity. The steps are exact for an input that is
linear between samples (first-order hold); those of the one-sided form as long as input and output do not cross between samples. Of first
order:

    z[n] = e z[n-1] + (g - e) y[n-1] + (1 - g) y[n],        e = exp(-dt / tau),  g = (1 - e) tau / dt.

Sources: G. F. Franklin, J. D. Powell, M. L. Workman, Digital Control of Dynamic Systems, 3rd ed., Addison-Wesley 1998, section 6.3.2;
S. W. Smith, The Scientist and Engineer's Guide to Digital Signal Processing, California Technical Publishing 1997, ch. 15 (averages);
N. W. Tschoegl, The Phenomenological Theory of Linear Viscoelastic Behavior, Springer 1989, ch. 3 (a soft layer over a sensor);
S. El-Molla et al., Journal of Sensors (2016) 1736169 (capacitive films that take seconds to recover).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.signal import lfilter, lfilter_zi

from skin_models.effect import Dynamic, Place
from skin_models.operators.averaging import averaged, averaged_step
from skin_models.operators.lagging import in_part, lagged, lagged_either_way, lagged_step, lagged_step_either_way, second_order_factors
from skin_models.parameter import PROMPT, SHAPE, quantity
from skin_models.signals import Motion, Sample


@dataclass(frozen=True)
class Lag(Dynamic):
    """First-order sensor lag."""

    cause: ClassVar[str] = "lag"
    places: ClassVar = {"taxel": Place.TAXEL, "load_cell": Place.LOAD_CELL}
    source: ClassVar[str] = "Franklin, Powell and Workman 1998, section 6.3.2"

    tau: float = quantity("s", 0.0, lower=0.0, upper=100.0, typical=0.05, negligible=PROMPT, scan=(0.005, 0.05, 0.2), doc="time constant")

    def initial(self, rng=None) -> None:
        """None: the first sample is taken as rest. From then on the state is z[n-1] and y[n-1], N."""
        return None

    def step(self, state, y, s: Sample, dt: float):
        """z[n] = e z[n-1] + (g - e) y[n-1] + (1 - g) y[n]."""
        state, z = lagged_step(state, self.mine(y), self.tau, dt)
        return state, self.put_back(y, z)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same recursion as a filter, at rest at y[0]."""
        return self.put_back(y, lagged(self.mine(y), self.tau, s.dt))


@dataclass(frozen=True)
class SecondOrderLag(Lag):
    """Sensor lag of two poles, as an anti-aliasing filter has. A small one equals one of first order, which is tried before it."""

    form: ClassVar[str] = "second_order"
    source: ClassVar[str] = "Franklin, Powell and Workman 1998, section 6.3.2"
    proposed: ClassVar[bool] = False
    refines: ClassVar[type] = Lag

    tau: float = quantity("s", 0.0, lower=0.0, upper=100.0, typical=0.05, negligible=PROMPT, doc="delay of slow inputs")
    damping: float = quantity("1", 0.7, lower=0.2, upper=5.0, role=SHAPE, typical=0.7, doc="damping ratio zeta")

    def initial(self, rng=None) -> None:
        """None: the first sample is taken as rest. From then on the state is (z, z' tau / 2 zeta) and y[n-1], N."""
        return None

    def step(self, state, y, s: Sample, dt: float):
        """x[n] = Phi x[n-1] + before y[n-1] + now y[n], of which z is the first row."""
        mine = self.mine(y)
        if self.tau == 0.0:
            return None, y
        x, last = (np.stack([mine, np.zeros_like(mine)]), mine) if state is None else state
        f = second_order_factors(self.tau, self.damping, dt)
        x = np.tensordot(f.transition, x, 1) + np.multiply.outer(f.before, last) + np.multiply.outer(f.now, mine)
        return (x, mine), self.put_back(y, x[0])

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same recursion as a filter, at rest at y[0]."""
        if self.tau == 0.0:
            return y
        mine = self.mine(y)
        b, a = second_order_factors(self.tau, self.damping, s.dt).filter
        z, _ = lfilter(b, a, mine, zi=lfilter_zi(b, a) * mine[..., :1])
        return self.put_back(y, z)


@dataclass(frozen=True)
class AveragedLag(Lag):
    """The mean of what a sensor felt in the last 2 tau, which many amplifiers return to be rid of noise and of mains."""

    form: ClassVar[str] = "averaged"
    source: ClassVar[str] = "Smith 1997, ch. 15"
    proposed: ClassVar[bool] = False
    refines: ClassVar[type] = Lag

    tau: float = quantity("s", 0.0, lower=0.0, upper=2.0, typical=0.05, negligible=PROMPT, doc="delay: half the window of the average")

    def initial(self, rng=None) -> None:
        """None: the first sample is taken as rest. From then on the state is the samples that the window touches, N."""
        return None

    def step(self, state, y, s: Sample, dt: float):
        """The mean of the last 2 tau."""
        state, z = averaged_step(state, self.mine(y), 2.0 * self.tau, dt)
        return state, self.put_back(y, z)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same from sums over the whole recording."""
        return self.put_back(y, averaged(self.mine(y), 2.0 * self.tau, s.dt))


@dataclass(frozen=True)
class PartialLag(Lag):
    """Sensor lag of a part of the signal, as of a sensor under a soft layer that yields. A slower part is creep, a form of drift."""

    form: ClassVar[str] = "partial"
    source: ClassVar[str] = "Tschoegl 1989, ch. 3"
    proposed: ClassVar[bool] = False
    refines: ClassVar[type] = Lag

    tau: float = quantity("s", 0.0, lower=0.0, upper=2.0, typical=0.05, negligible=PROMPT, doc="delay of slow inputs, at most T")
    settling: float = quantity("s", 0.3, lower=1e-3, upper=2.0, role=SHAPE, typical=0.3, doc="time T in which the late part comes")

    def step(self, state, y, s: Sample, dt: float):
        """z[n] = e z[n-1] + (g - e) y[n-1] + (1 - g) y[n] for T."""
        mine = self.mine(y)
        state, z = lagged_step(state, mine, self.settling, dt)
        return state, self.put_back(y, in_part(mine, z, self.tau, self.settling)) if self.tau else y

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same recursion as a filter, at rest at y[0]."""
        mine = self.mine(y)
        return self.put_back(y, in_part(mine, lagged(mine, self.settling, s.dt), self.tau, self.settling)) if self.tau else y


@dataclass(frozen=True)
class OneSidedLag(Lag):
    """Sensor lag with one time constant on the way up and another on the way down, as of a film that takes longer to recover than to
    respond; `tau` is their geometric mean."""

    form: ClassVar[str] = "one_sided"
    source: ClassVar[str] = "El-Molla et al. 2016"
    proposed: ClassVar[bool] = False
    refines: ClassVar[type] = Lag

    recovery: float = quantity(
        "1", 1.0, lower=0.02, upper=50.0, role=SHAPE, typical=1.5, doc="ratio r of time constants, fall to rise", neutral=1.0
    )

    def step(self, state, y, s: Sample, dt: float):
        """z[n] = e z[n-1] + (g - e) y[n-1] + (1 - g) y[n], e and g those of the way that leads from z[n-1] to y[n]."""
        state, z = lagged_step_either_way(state, self.mine(y), *self._ways, dt)
        return state, self.put_back(y, z)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same for all samples."""
        return self.put_back(y, lagged_either_way(self.mine(y), *self._ways, s.dt))

    @property
    def _ways(self) -> tuple[float, float]:
        """Time constants up and down, s."""
        return self.tau / self.recovery**0.5, self.tau * self.recovery**0.5
