"""The dispersion model of the thesis: two springs, two dashpots, a mass (eqs 27 and 28, figure 4-9).

    sensed     F_FF = b1 v + k1 x
    dispersed  F_d  = b2 v + k2 x
    applied    F_LC = m (a - g) + F_FF + F_d

with depth x (m), positive into the skin, zero at its surface. The thesis writes it for x > 0; a plunger in the air feels nothing. Skin
that is left faster than it recovers parts from the plunger instead of pulling at it: its surface u then creeps back by itself,

    u' = -u / tau,    tau = (b1 + b2) / (k1 + k2),

and is met again where the plunger comes down to it (`surface`, `meet`). Its two branches then hold each other: the plunger feels nothing,
a taxel below still feels F_FF = b1 u' + k1 u (`free`), which is what the thesis's transfer function (eq 32) leaves after the force is gone.
"""

import math
from dataclasses import dataclass

import numpy as np

from skin_models.errors import ModelError
from skin_models.parameter import check_parameters, quantity
from skin_models.signals import GRAVITY, Motion, Sample

SOON, PIECE = 8, 256  # samples that are checked one by one; then so many at once


@dataclass(frozen=True)
class Surface:
    """Where the skin's surface is under the plunger (m), and whether the plunger touches it; arrays for several plungers."""

    depth: float | np.ndarray
    touched: bool | np.ndarray


@dataclass(frozen=True)
class Dispersion:
    """Parameters of the dispersion model; all are those of the skin under the plunger."""

    m: float = quantity("kg", 0.0, lower=0.0, upper=1e3, doc="mass of skin that moves with the plunger")
    b1: float = quantity("N*s/m", lower=-1e9, upper=1e9, doc="damping between plunger and taxel")
    k1: float = quantity("N/m", lower=0.0, upper=1e9, doc="stiffness between plunger and taxel")
    b2: float = quantity("N*s/m", lower=-1e9, upper=1e9, doc="damping of the force that is dispersed past the taxel")
    k2: float = quantity("N/m", lower=-1e9, upper=1e9, doc="stiffness of the force that is dispersed past the taxel")

    def __post_init__(self) -> None:
        check_parameters(self)

    def branches(self, s: Motion | Sample) -> np.ndarray:
        """Sensed and dispersed force of skin that is touched, shape (2,) or (2, N), N. Zero for x <= 0."""
        pressed = np.asarray(s.x) > 0.0
        sensed, dispersed = self.b1 * s.v + self.k1 * s.x, self.b2 * s.v + self.k2 * s.x
        return np.array([sensed * pressed, dispersed * pressed])

    def inertial(self, s: Motion | Sample) -> np.ndarray:
        """Force of the moving skin, m (a - g) in contact, N."""
        return self.m * (s.a - GRAVITY) * (np.asarray(s.x) > 0.0)

    @property
    def sensed_share(self) -> float:
        """Static share of the applied force that reaches the taxel, k1 / (k1 + k2). Raises `ModelError` for skin without stiffness."""
        if self.k1 + self.k2 == 0.0:
            raise ModelError("k1 + k2 is zero: skin that does not resist has no share that reaches a taxel")
        return self.k1 / (self.k1 + self.k2)

    @property
    def recovery(self) -> float:
        """Time constant tau of skin that nothing touches, s; 0 where damping or stiffness are not positive."""
        b, k = self.b1 + self.b2, self.k1 + self.k2
        return b / k if b > 0.0 and k > 0.0 else 0.0

    @property
    def free_stiffness(self) -> float:
        """k1 - b1 / tau, N/m: force on a taxel per depth of the surface while untouched skin recovers; 0 for skin that is back at once."""
        return self.k1 - self.b1 / self.recovery if self.recovery else 0.0

    def meet(self, surface: Surface | None, s: Sample, dt: float) -> Surface:
        """The surface one sample later. None: at rest at this first sample."""
        before = surface or Surface(np.maximum(s.x, 0.0), True)
        left = before.depth * math.exp(-dt / self.recovery) if self.recovery else 0.0
        touched = self._presses(s) & (before.touched | (s.x > left))
        return Surface(np.where(touched, s.x, left)[()], touched)

    def free(self, surface: Surface) -> float | np.ndarray:
        """Sensed force of skin that recovers while nothing touches it, (k1 - b1 / tau) u, N; the dispersed force is its opposite."""
        return self.free_stiffness * surface.depth * (1 - surface.touched)

    def unpulled(self, forces: np.ndarray) -> np.ndarray:
        """Sensed and dispersed force (2,) or (2, N) of skin that cannot pull at the plunger.

        Where they add up to less than zero, the surface recovers so much more slowly that they cancel: the sensed force takes the share
        b1 / (b1 + b2) of the correction (none where damping is not above zero), and the dispersed force is its opposite.
        """
        total = forces[0] + forces[1]
        pulls = total < 0.0
        if not pulls.any():  # nearly always, and this runs for every single sample
            return forces
        sensed = forces[0] - self.unpulled_share * total * pulls
        return np.array([sensed, np.where(pulls, -sensed, forces[1])])

    @property
    def unpulled_share(self) -> float:
        """The share of the correction in `unpulled` that the sensed force takes."""
        return min(max(self.b1 / (self.b1 + self.b2), 0.0), 1.0) if self.b1 + self.b2 > 0.0 else 0.0

    def contact(self, s: Motion) -> np.ndarray:
        """Whether the plunger touches the skin, (N,) of bool."""
        return self.surface(s).touched

    def surface(self, s: Motion) -> Surface:
        """Where the surface is, (N,): `meet` over a whole recording. Depends on the time constant alone."""
        return s.once("surface", self.recovery, lambda: self._surface(s))

    def _surface(self, s: Motion) -> Surface:
        presses = self._presses(s)
        rate = s.dt / self.recovery if self.recovery else np.inf
        changes = np.flatnonzero(presses[1:] != presses[:-1]) + 1
        ends = [0, *changes.tolist(), presses.size]
        flights, met = [], 0  # of each flight the first sample in the air, that of the next contact, and the depth of the surface at first
        for left, pressed in zip(ends[bool(presses[0]) :: 2], ends[1 + bool(presses[0]) :: 2], strict=False):
            if pressed > met:  # else it has not met the surface again since the last flight
                left = max(left, met)
                surface = max(float(s.x[left - 1] if left else s.x[0]), 0.0)
                met = _met(s.x, presses, left, pressed, surface, rate)
                flights.append((left, met, surface))
        return _recovering(s.x, flights, rate)

    def _presses(self, s: Motion | Sample):
        return (s.x > 0.0) & (s.x + self.recovery * s.v > 0.0)


def _met(x: np.ndarray, presses: np.ndarray, left: int, pressed: int, surface: float, rate: float) -> int:
    """Index of the sample at which a plunger at depths `x` meets the surface again, `x.size` if it never does.

    The surface was at depth `surface` when it was left at sample `left`, and has recovered by `rate` per sample since. From sample
    `pressed` on the plunger may press again, and nearly always meets the surface soon after.
    """
    soon = min(pressed + SOON, x.size)
    for n in range(pressed, soon):
        if presses[n] and x[n] > (surface and surface * math.exp(-rate * (n - left + 1))):
            return n
    for start in range(soon, x.size, PIECE):
        ahead = np.arange(start, min(start + PIECE, x.size))
        met = ahead[(x[ahead] > surface * np.exp(-rate * (ahead - left + 1))) & presses[ahead]]
        if met.size:
            return int(met[0])
    return x.size


def _recovering(x: np.ndarray, flights: list[tuple[int, int, float]], rate: float) -> Surface:
    """The surface over a recording: at the plunger's depths `x` in contact, and recovering by `rate` per sample during its `flights`."""
    touched, depth = np.ones(x.size, bool), np.maximum(x, 0.0)
    if flights:
        left, met, surface = np.array(flights).T
        long = (met - left).astype(int)
        air = np.arange(long.sum()) + np.repeat(left - np.cumsum(long) + long, long).astype(int)
        touched[air] = False
        depth[air] = np.repeat(surface, long) * np.exp(-rate * (air + 1 - np.repeat(left, long)))
    return Surface(depth, touched)
