"""Hysteresis whose loops grow with depth: a Preisach operator, written as plays.

A Preisach operator weighs relays that switch on at a + r and off at a - r with a density w(r, a). All relays of one half width r
together are a function of the play P_r alone (`skin_models.operators.play`), hence

    f[x] = integral over r of g(r, P_r[x]) dr,        dg/da = w        (Brokate and Sprekels, Krejčí)

and Prandtl-Ishlinskii is the case that does not depend on a: loops of one size and shape wherever they are. With dead zones between play
and sum (Kuhnen) g becomes piecewise linear in a, and so covers every Preisach operator as closely as one likes. What one skin needs of that
freedom is loops that grow with depth. Here the density grows with a as the depth does, and half widths are spread evenly up to R:

    f = k / (2 l n) sum over i of (x^2 - P_i^2),        r_i = R (i - 1/2) / n,  i = 1 … n = 5,  l = 1 mm

After a turning point at depth x it is a spring of stiffness k x / l. Exact for any path that is monotone between samples; it dissipates.
Simulated, not proposed: a recording can tell from relaxation only the sum of elastic-plastic elements that `hysteresis` in the skin spans.

Sources: I. D. Mayergoyz, Mathematical Models of Hysteresis, Springer 1991; M. Brokate and J. Sprekels, Hysteresis and Phase Transitions,
Springer 1996, ch. 2.4; P. Krejčí 1996; K. Kuhnen, Eur. J. Control 9 (2003) 407-418 (dead zones).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Dynamic, Place
from skin_models.effects.hysteresis import REFERENCE
from skin_models.operators.contact import branches, depth_in_contact
from skin_models.operators.play import play, play_step
from skin_models.parameter import SHAPE, quantity
from skin_models.signals import Motion, Sample

PLAYS = 5


@dataclass(frozen=True)
class PreisachHysteresis(Dynamic):
    """A density of relays that grows with depth."""

    cause: ClassVar[str] = "hysteresis"
    form: ClassVar[str] = "preisach"
    proposed: ClassVar[bool] = False
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Preisach; Brokate and Sprekels 1996, ch. 2.4"
    linear: ClassVar[bool] = True

    k_sensed: float = quantity("N/m", 0.0, lower=0.0, typical=4000.0, doc="stiffness after a turning point at 1 mm, sensed")
    k_dispersed: float = quantity("N/m", 0.0, lower=0.0, typical=2000.0, doc="stiffness after a turning point at 1 mm, dispersed")
    width: float = quantity("m", 0.4e-3, lower=1e-6, upper=0.05, role=SHAPE, typical=0.4e-3, doc="greatest half width R of a relay")

    def initial(self, rng=None) -> None:
        """None: the first sample is taken as rest. From then on the state is the plays P_i, (n,) or (n, C), m."""
        return None

    def step(self, state, y, s: Sample, dt: float):
        """Every play by one sample, then k / (2 l) times the mean of x^2 - P_i^2 on each branch."""
        x = depth_in_contact(s.x)
        half = self._half_widths().reshape(-1, *([1] * np.ndim(x)))
        state = play_step(x + 0.0 * half if state is None else state, x, half)
        return state, y + branches(self.k_sensed, self.k_dispersed, self._force(x, state), s.x)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same with n play operators over the whole recording."""
        return y + branches(self.k_sensed, self.k_dispersed, s.once("Preisach", self.width, lambda: self._stretched(s)), s.x)

    def _stretched(self, s: Motion) -> np.ndarray:
        x = depth_in_contact(s.x)
        return self._force(x, np.array([play(x, r) for r in self._half_widths()]))

    def _half_widths(self) -> np.ndarray:
        return self.width * (np.arange(PLAYS) + 0.5) / PLAYS

    def _force(self, x, plays):
        return (x * x - np.mean(plays * plays, axis=0)) / (2.0 * REFERENCE)
