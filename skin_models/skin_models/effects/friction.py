"""Friction of the rig's guide or of the load cell's mounting: the measured force steps with the sign of the speed. Four forms:

    smoothed over speed       y' = y + (F + mu |y|) tanh(v / v_s)
    Stribeck, over speed      y' = y + (F + mu |y|) tanh(v / v_s) (1 + p / (1 + (v / v_p)^2))
    Dahl, over distance       y' = y + (F + mu |y|) z / d,        z' = v - |v| z / d
    Prandtl, over distance    y' = y + (F + mu |y|) z / d,        z the stop operator of the depth, |z| <= d

All are Coulomb's law, smoothed: over the speed v_s, below which the force falls off, or over the distance d that bristles bend before they
slip. Bristles hold their force while the plunger rests; Dahl's slip one after the other, Prandtl's all at once. Stribeck's friction is
greater by the share p at low speed, before surfaces ride on their lubricant. F acts in the air too; mu is the friction of the guide in
proportion to the load. Both forms over distance are stepped exactly for a path that is monotone between samples.

Sources: B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30 (1994) 1083-1138; D. P. Hess, A. Soom, Journal of Tribology 112
(1990) 147-152 (Stribeck's curve); P. Dahl, A Solid Friction Model, TOR-0158, 1968; D. A. Haessig, B. Friedland, Journal of Dynamic Systems,
Measurement, and Control 113 (1991) 354-362 (bristles that slip all at once); C. Canudas de Wit et al., IEEE Trans. Automatic Control
40 (1995) 419-425 (LuGre, of which Dahl's is the part before slip).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Dynamic, Memoryless, Place
from skin_models.operators.bristles import bristles, bristles_step
from skin_models.operators.play import play_step, stop
from skin_models.parameter import SHAPE, quantity
from skin_models.signals import Motion, Sample


@dataclass(frozen=True)
class _Rubbing:
    """What all forms of friction at the load cell share, however they begin to slip."""

    cause: ClassVar[str] = "friction"
    places: ClassVar = {"rig": Place.LOAD_CELL, "load_cell": Place.LOAD_CELL}
    linear: ClassVar[bool] = True

    force: float = quantity("N", 0.0, lower=0.0, upper=1e3, typical=0.5, doc="sliding friction F")
    coefficient: float = quantity("1", 0.0, lower=0.0, upper=2.0, typical=0.03, doc="friction mu per load")

    def _rubbing(self, y, slipping):
        """y + (F + mu |y|) `slipping`, which is between -1 and 1."""
        return y + (self.force + self.coefficient * np.abs(y)) * slipping


@dataclass(frozen=True)
class Friction(_Rubbing, Memoryless):
    """Smoothed Coulomb friction, seen by the load cell."""

    source: ClassVar[str] = "Armstrong-Hélouvry et al. 1994"

    speed: float = quantity(
        "m/s",
        2e-4,
        lower=1e-7,
        upper=1.0,
        role=SHAPE,
        typical=2e-4,
        scan=(5e-5, 2e-4, 1e-3),
        doc="speed v_s over which the sign is smoothed",
    )

    def apply(self, y, s):
        """y + (F + mu |y|) tanh(v / v_s)."""
        return self._rubbing(y, np.tanh(s.v / self.speed))


@dataclass(frozen=True)
class StribeckFriction(_Rubbing, Memoryless):
    """Smoothed friction that is greater before surfaces slide on their lubricant, seen by the load cell."""

    form: ClassVar[str] = "stribeck"
    source: ClassVar[str] = "Hess and Soom 1990"
    proposed: ClassVar[bool] = False
    refines: ClassVar[type] = Friction

    speed: float = quantity("m/s", 2e-4, lower=1e-7, upper=1.0, role=SHAPE, typical=2e-4, doc="speed v_s over which the sign is smoothed")
    peak: float = quantity("1", 0.0, lower=0.0, upper=5.0, role=SHAPE, typical=0.5, doc="share p by which it is greater near rest")
    peak_speed: float = quantity("m/s", 1e-3, lower=1e-7, upper=1.0, role=SHAPE, typical=1e-3, doc="speed v_p, at which half of it is left")

    def apply(self, y, s):
        """y + (F + mu |y|) tanh(v / v_s) (1 + p / (1 + (v / v_p)^2))."""
        return self._rubbing(y, np.tanh(s.v / self.speed) * (1.0 + self.peak / (1.0 + (s.v / self.peak_speed) ** 2)))


@dataclass(frozen=True)
class DahlFriction(_Rubbing, Dynamic):
    """Friction of bristles, seen by the load cell. State: their deflection over d, and the last depth (m; None before the first sample)."""

    form: ClassVar[str] = "dahl"
    source: ClassVar[str] = "Dahl 1968"

    slip: float = quantity(
        "m", 1e-5, lower=1e-7, upper=1e-2, role=SHAPE, typical=1e-5, scan=(3e-6, 1e-5, 3e-5), doc="distance d over which bristles bend"
    )

    def initial(self, rng=None) -> tuple[float, None]:
        """Bristles upright, before the first sample."""
        return 0.0, None

    def step(self, state, y, s: Sample, dt: float):
        """z/d after one sample, and the reading with it."""
        state = bristles_step(state, s.x, self.slip)
        return state, self._rubbing(y, state[0])

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same recurrence in log2(N) passes over the whole recording."""
        return self._rubbing(y, s.once("Dahl", self.slip, lambda: bristles(s.x, self.slip)))


@dataclass(frozen=True)
class PrandtlFriction(_Rubbing, Dynamic):
    """Friction of bristles that bend in proportion and slip all at once, seen by the load cell. State: where they stand, m."""

    form: ClassVar[str] = "prandtl"
    source: ClassVar[str] = "Haessig and Friedland 1991"
    proposed: ClassVar[bool] = False
    refines: ClassVar[type] = DahlFriction

    slip: float = quantity("m", 1e-5, lower=1e-7, upper=1e-2, role=SHAPE, typical=1e-5, doc="distance d over which bristles bend")

    def initial(self, rng=None) -> None:
        """Bristles upright, before the first sample."""
        return None

    def step(self, state, y, s: Sample, dt: float):
        """Where bristles stand after one sample, and the reading with what they are bent by."""
        state = play_step(state, s.x, self.slip)
        return state, self._rubbing(y, (s.x - state) / self.slip)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same for the whole recording."""
        return self._rubbing(y, s.once("Prandtl", self.slip, lambda: stop(s.x, self.slip)) / self.slip)
