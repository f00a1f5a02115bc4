"""Mount compliance: the rig bends under the force, and the encoder moves more than the tip.

    tip depth = x - C F

    static    F = K tip depth           tip depth = x / (1 + C K) in contact, x in the air
    damped    F = B d(tip depth)/dt     T d(tip depth)/dt + tip depth = x, T = C B, in contact; x in the air

What bends the mount is a linear skin of stiffness K and damping B, which are parameters because an effect sees motion, not force. Of the
static part only the product C K matters, and from x and F alone it equals a softer skin; the damped part can be seen: the tip follows late
by T while it presses. A mount under both is a static one behind a damped one, of T / (1 + C K). One that has damping B' of its own follows
in part at once, and in part late, with the time constant T at which skin and mount together come to rest:

    yielding  tip depth = x + L / T (z - x), T z' + z = x, in contact    T = (B + B') C / (1 + C K), late by L for slow motion, 0 <= L <= T

A joint, bolted or clamped, gives at first and closes up: rough faces are pressed together by a force that grows exponentially as they near
each other, so that the joint gives by L ln(1 + F / F1). Under a linear skin that is X deep where F is F1,

    joint     tip depth + L ln(1 + tip depth / X) = x in contact, x in the air

A ball, a roller or an edge on which the mount leans gives by a power of the force (p = 2/3 for a ball), and gives more while the skin is
pressed fast, because its damping adds to the force. To first order, where it gives little compared with the skin,

    power     tip depth = x - L (max(x + T v, 0) / 1 mm)^p >= 0 in contact, x in the air    T = B / K

Sources: two springs in series; K. L. Johnson, Contact Mechanics, Cambridge 1985, ch. 4 (Hertz);
W. C. Oliver and G. M. Pharr, J. Materials Research 7 (1992) 1564-1583 (compliance of the load frame);
J. A. Greenwood and J. B. P. Williamson, Proc. Royal Society A 295 (1966) 300-319 (rough faces of exponentially distributed heights).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import wrightomega

from skin_models.effect import Dynamic, Memoryless, Place
from skin_models.operators.lagging import in_part, lagged_in_contact, lagged_in_contact_step
from skin_models.parameter import PROMPT, SHAPE, quantity
from skin_models.signals import Motion, Sample

TINY = 1e-9  # smallest L / X that counts: below it the joint is taken to be rigid


@dataclass(frozen=True)
class MountCompliance(Memoryless):
    """A spring between encoder and tip."""

    cause: ClassVar[str] = "mount_compliance"
    places: ClassVar = {"rig": Place.DEPTH}
    source: ClassVar[str] = "Oliver and Pharr 1992"

    compliance: float = quantity("m/N", 0.0, lower=0.0, upper=1e-2, typical=1e-5, doc="compliance C of the mount")
    stiffness: float = quantity(
        "N/m", 1e4, lower=0.0, upper=1e7, role=SHAPE, typical=1e4, scan=(1e4,), doc="stiffness K of the specimen that loads it"
    )

    def apply(self, y, s):
        """x / (1 + C K) in contact, x in the air."""
        return np.where(y > 0.0, y / (1.0 + self.compliance * self.stiffness), y)


@dataclass(frozen=True)
class JointedMount(Memoryless):
    """A joint between encoder and tip that gives at first and closes up."""

    cause: ClassVar[str] = "mount_compliance"
    form: ClassVar[str] = "joint"
    places: ClassVar = {"rig": Place.DEPTH}
    source: ClassVar[str] = "Greenwood and Williamson 1966"

    give: float = quantity("m", 0.0, lower=0.0, upper=1e-3, typical=10e-6, doc="length L, given each time that the force grows e-fold")
    closing: float = quantity(
        "m", 0.1e-3, lower=1e-6, upper=0.05, role=SHAPE, typical=0.1e-3, scan=(0.03e-3, 0.3e-3), doc="depth X where the joint closes"
    )

    def apply(self, y, s):
        """X (u - 1) with u + a ln u = 1 + x / X, a = L / X, in contact: u = a w, w + ln w = (1 + x / X) / a - ln a; x in the air."""
        a = self.give / self.closing
        if a <= TINY:
            return y
        u = a * wrightomega((1.0 + np.maximum(y, 0.0) / self.closing) / a - np.log(a)).real
        return np.where(y > 0.0, self.closing * (u - 1.0), y)[()]


@dataclass(frozen=True)
class PowerMount(Memoryless):
    """A ball or an edge between encoder and tip, which gives by a power of the force that it bears."""

    cause: ClassVar[str] = "mount_compliance"
    form: ClassVar[str] = "power"
    places: ClassVar = {"rig": Place.DEPTH}
    source: ClassVar[str] = "Johnson 1985"

    reference: ClassVar[float] = 1e-3  # m

    give: float = quantity("m", 0.0, lower=0.0, upper=1e-3, typical=10e-6, doc="length L, given under a skin that is 1 mm deep")
    recovery: float = quantity("s", 0.1, lower=0.0, upper=2.0, role=SHAPE, typical=0.1, scan=(0.1,), doc="T = B / K of the skin")
    exponent: float = quantity("1", 2 / 3, lower=0.2, upper=3.0, role=SHAPE, typical=2 / 3, scan=(2 / 3,), doc="power p of the force")

    def apply(self, y, s):
        """x - L (max(x + T v, 0) / 1 mm)^p, at least 0, in contact; x in the air."""
        gives = self.give * (np.maximum(y + self.recovery * s.v, 0.0) / self.reference) ** self.exponent
        return np.where(y > 0.0, np.maximum(y - gives, 0.0), y)[()]


@dataclass(frozen=True)
class DampedMount(Dynamic):
    """The same under a skin's damping force."""

    cause: ClassVar[str] = "mount_compliance"
    form: ClassVar[str] = "damped"
    places: ClassVar = {"rig": Place.DEPTH}
    source: ClassVar[str] = "Oliver and Pharr 1992"

    late: float = quantity(
        "s",
        0.0,
        lower=0.0,
        upper=1.0,
        typical=0.01,
        negligible=PROMPT,
        scan=(0.001, 0.05),
        doc="T, compliance times the specimen's damping",
    )

    def initial(self, rng=None) -> None:
        """None: the first sample is taken as rest. From then on the state is the last tip and the last depth below the surface, m."""
        return None

    def step(self, state, y, s: Sample, dt: float):
        """tip[n] = e tip[n-1] + (g - e) x[n-1] + (1 - g) x[n] in contact, 0 in the air; e and g as in `lag`, for T."""
        state, tip = lagged_in_contact_step(state, y, self.late, dt)
        return state, self._tip(tip, y)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same recursion over the whole recording, at rest at x[0]."""
        return self._tip(lagged_in_contact(y, self.late, s.dt), y)

    def _tip(self, tip, y):
        return np.where(y > 0.0, tip, y)[()] if self.late else y


@dataclass(frozen=True)
class YieldingMount(Dynamic):
    """The same for a mount with damping of its own. From x, F and one taxel it cannot be told from skin with a fast relaxing arm."""

    cause: ClassVar[str] = "mount_compliance"
    form: ClassVar[str] = "yielding"
    places: ClassVar = {"rig": Place.DEPTH}
    source: ClassVar[str] = "Oliver and Pharr 1992"
    proposed: ClassVar[bool] = False
    refines: ClassVar[type] = DampedMount

    late: float = quantity(
        "s", 0.0, lower=0.0, upper=1.0, typical=0.01, negligible=PROMPT, doc="L, by which the tip is late in slow motion; at most T"
    )
    settling: float = quantity("s", 0.05, lower=1e-3, upper=0.2, role=SHAPE, typical=0.05, doc="T, in which skin and mount come to rest")

    def initial(self, rng=None) -> None:
        """None: the first sample is taken as rest. From then on the state is the last z and the last depth below the surface, m."""
        return None

    def step(self, state, y, s: Sample, dt: float):
        """z[n] = e z[n-1] + (g - e) x[n-1] + (1 - g) x[n] in contact, 0 in the air; e and g as in `lag`, for T."""
        state, z = lagged_in_contact_step(state, y, self.settling, dt)
        return state, self._tip(z, y)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same recursion over the whole recording, at rest at x[0]."""
        return self._tip(lagged_in_contact(y, self.settling, s.dt), y)

    def _tip(self, z, y):
        return np.where(y > 0.0, in_part(y, z, self.late, self.settling), y)[()] if self.late else y
