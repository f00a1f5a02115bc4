"""Damage: cyclic softening that takes part of the stiffness for good, by D(z) = 1 - d (1 - exp(-z / l)).

    damage            y' = y D(X)             X = greatest depth so far
    virgin            y' = y D(X) / D(x)      the same, where y is the force on the virgin curve (x = X)
    damaged_springs   y' = y - k x (exp(-x / l) - exp(-X / l))    the same of the springs alone, beside dashpots that stay
    fatigue           y' = y D(s)             s = path travelled in the skin, to and fro

The first three are complete after the first deep cycle, and later cycles repeat; the last goes on from cycle to cycle, fastest at first.
Moves of less than 5 um to and fro do not count as path: an encoder at rest flickers by as much (a play operator takes them out).

Sources: J. C. Simo, On a fully three-dimensional finite-strain viscoelastic damage model, Comput. Methods Appl. Mech. Eng. 60 (1987)
153-173 (greatest strain so far); C. Miehe, Discontinuous and continuous damage evolution in Ogden-type large-strain elastic materials,
Eur. J. Mech. A/Solids 14 (1995) 697-720 (path, exponential saturation).
"""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from skin_models.effect import Dynamic, Place
from skin_models.operators.contact import depth_in_contact
from skin_models.operators.greatest_depth import OfTheForce, OfTheSprings
from skin_models.operators.play import play, play_step
from skin_models.parameter import SHAPE, quantity
from skin_models.signals import Motion, Sample

FLICKER = 2.5e-6  # m, half width of the play operator: moves up to twice this do not count as path


def left(loss: float, measure: Any, scale: float) -> Any:
    """D(z) of the module: the share of the force that is left at the measure z (m), for a loss d and a scale l (m)."""
    return 1.0 + loss * np.expm1(-measure / scale)


@dataclass(frozen=True)
class Damage(OfTheForce):
    """The virgin curve softens as the skin is damaged, and unloading keeps what is left."""

    cause: ClassVar[str] = "cyclic_softening"
    form: ClassVar[str] = "damage"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Simo 1987"
    linear: ClassVar[bool] = True

    loss: float = quantity("1", 0.0, lower=0.0, upper=0.95, typical=0.2, doc="greatest share d of the force that is lost")
    length: float = quantity(
        "m", 0.5e-3, lower=1e-5, upper=0.05, role=SHAPE, typical=0.5e-3, scan=(0.2e-3, 0.5e-3, 1e-3, 2e-3), doc="depth scale l"
    )

    def factor(self, x, greatest):
        """D(X)."""
        return left(self.loss, greatest, self.length)


@dataclass(frozen=True)
class DamageBelow(Damage):
    """The virgin curve is unchanged; below the greatest depth so far the skin is softer by its damage."""

    form: ClassVar[str] = "virgin"
    linear: ClassVar[bool] = False

    def factor(self, x, greatest):
        """D(X) / D(x)."""
        return left(self.loss, greatest, self.length) / left(self.loss, x, self.length)


@dataclass(frozen=True)
class DamagedSprings(OfTheSprings):
    """The springs alone are softer below the greatest depth so far."""

    cause: ClassVar[str] = "cyclic_softening"
    form: ClassVar[str] = "damaged_springs"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Simo 1987, beside linear damping"

    length: float = quantity(
        "m", 0.5e-3, lower=1e-5, upper=0.05, role=SHAPE, typical=0.5e-3, scan=(0.2e-3, 0.5e-3, 1e-3, 2e-3), doc="depth scale l"
    )

    def share(self, x, greatest):
        """exp(-x / l) - exp(-X / l)."""
        return np.exp(-x / self.length) - np.exp(-greatest / self.length)


@dataclass(frozen=True)
class Fatigue(Dynamic):
    """Stiffness lost to the path travelled."""

    cause: ClassVar[str] = "cyclic_softening"
    form: ClassVar[str] = "fatigue"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Miehe 1995"
    linear: ClassVar[bool] = True

    loss: float = quantity("1", 0.0, lower=0.0, upper=0.95, typical=0.2, doc="greatest share d of the force that is lost")
    length: float = quantity(
        "m", 5e-3, lower=1e-4, upper=10.0, role=SHAPE, typical=5e-3, scan=(1e-3, 2.5e-3, 5e-3, 10e-3, 30e-3), doc="path scale l"
    )

    def initial(self, rng=None) -> tuple[float, None]:
        """Path so far, m, and the depth that the play operator last let through, m: None before the first sample."""
        return 0.0, None

    def step(self, state, y, s: Sample, dt: float):
        """y D(s), with the path s extended by the move of the play operator's output."""
        path, last = state
        now = play_step(last, depth_in_contact(s.x), FLICKER)
        path = path + np.abs(now - (now if last is None else last))
        return (path, now), y * left(self.loss, path, self.length)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same with the play operator over the whole recording."""
        return y * left(self.loss, s.once("path", None, lambda: self._path(s)), self.length)

    def _path(self, s: Motion) -> np.ndarray:
        path = play(depth_in_contact(s.x), FLICKER)
        return np.cumsum(np.abs(np.diff(path, axis=-1, prepend=path[..., :1])), axis=-1)
