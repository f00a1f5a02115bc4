"""Adhesion: the skin holds on to the plunger on release.

    f = -F b (1 - (x / l)^2)^2        for |x| < l, else 0

b is the bond, of which there are two forms:

    grown      made where the plunger is pressed deeper than l: the force is zero there, and comes without a step
    snapping   made as soon as the surfaces touch, a twentieth of l deep: two that merely meet do not hold each other

Both are broken where the plunger is drawn further than l out of the surface. On the way out the force is strongest at the surface, -F, and
pulls a little way into the air; the snapping one pulls as much on the way in. It acts after the contact rule, which otherwise forbids
pulling. A cycle costs the work of adhesion, 16/15 F l, or half of that.

Source: the law is a smooth stand-in for K. L. Johnson, K. Kendall, A. D. Roberts, Proc. R. Soc. A 324 (1971) 301-313, whose contact
forms with a snap at the surface and parts at a gap; D. Maugis, J. Colloid Interface Sci. 150 (1992) 243-269.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Dynamic, Place
from skin_models.operators.relay import relay, relay_step
from skin_models.parameter import SHAPE, quantity
from skin_models.signals import Motion, Sample

TOUCHING = 0.05  # of the reach


@dataclass(frozen=True)
class Adhesion(Dynamic):
    """A pull on release."""

    cause: ClassVar[str] = "adhesion"
    places: ClassVar = {"skin": Place.SURFACE}
    source: ClassVar[str] = "after Johnson, Kendall and Roberts 1971; Maugis 1992"
    linear: ClassVar[bool] = True

    pull_sensed: float = quantity("N", 0.0, lower=0.0, typical=0.8, doc="greatest pull F on the sensed branch")
    pull_dispersed: float = quantity("N", 0.0, lower=0.0, typical=0.4, doc="greatest pull F on the dispersed branch")
    reach: float = quantity(
        "m", 0.2e-3, lower=1e-6, upper=0.02, role=SHAPE, typical=0.2e-3, scan=(0.05e-3, 0.1e-3, 0.2e-3, 0.4e-3, 0.8e-3), doc="reach l"
    )

    def initial(self, rng=None) -> float:
        """The bond, 0.0: not made. It is 1.0 while it holds."""
        return 0.0

    def step(self, state, y, s: Sample, dt: float):
        """The bond by a relay that is on from where it is made and off from x = -l, then its pull on both branches."""
        state = relay_step(state, s.x, -self.reach, self._made_at)
        return state, y + self._pull(state, s.x)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same with the relay over the whole recording."""
        return y + self._pull(relay(s.x, -self.reach, self._made_at), s.x)

    @property
    def _made_at(self) -> float:
        """The depth at which the bond is made, m."""
        return self.reach

    def _pull(self, bond, x):
        shape = np.maximum(1.0 - (x / self.reach) ** 2, 0.0) ** 2
        return -np.multiply.outer(np.array([self.pull_sensed, self.pull_dispersed]), bond * shape)


@dataclass(frozen=True)
class SnappingAdhesion(Adhesion):
    """A pull from the first touch on."""

    form: ClassVar[str] = "snapping"
    only_if_shown: ClassVar[bool] = True  # without a pull in the air it acts as a shift of the zero of depth

    @property
    def _made_at(self) -> float:
        return TOUCHING * self.reach
