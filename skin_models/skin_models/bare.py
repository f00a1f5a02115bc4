"""A model without effects under one plunger, sample by sample in plain numbers: for simulations in real time.

`Model.step` holds every signal in arrays, and its state in objects, because effects may act anywhere. Without effects a few lines are
enough, which give the same to the last digit in a fifteenth of the time.
"""

import math

from skin_models.model import Model
from skin_models.signals import GRAVITY


class BareSkin:
    """The dispersion model (thesis, eqs 27 and 28) with its contact rule, at a fixed period; see `skin_models.dispersion`.

    It starts at rest under the plunger's first depth.
    """

    def __init__(self, model: Model, period: float) -> None:
        """`period` in s. Only for a model for which `is_bare` holds."""
        d = model.dispersion
        self._m, self._b1, self._k1, self._b2, self._k2 = d.m, d.b1, d.k1, d.b2, d.k2
        self._recovery, self._share = d.recovery, d.unpulled_share
        self._fade = math.exp(-period / d.recovery) if d.recovery else 0.0
        self._free = d.free_stiffness
        self._surface: float | None = None  # m, where the skin's surface is under the plunger
        self._touched = True

    def press(self, x: float, v: float, a: float) -> tuple[float, float]:
        """Applied and sensed force (N), for depth (m), speed (m/s) and acceleration (m/s^2) of the next sample."""
        before = self._surface if self._surface is not None else max(x, 0.0)
        left = before * self._fade
        self._touched = x > 0.0 and x + self._recovery * v > 0.0 and (self._touched or x > left)
        if not self._touched:
            self._surface = left
            return 0.0, self._free * left
        self._surface = x
        sensed, dispersed = self._b1 * v + self._k1 * x, self._b2 * v + self._k2 * x
        if sensed + dispersed < 0.0:
            sensed -= self._share * (sensed + dispersed)
            dispersed = -sensed
        return sensed + dispersed + self._m * (a - GRAVITY), sensed


def is_bare(model: Model) -> bool:
    """Whether a model has no effects, so that `BareSkin` is all of it."""
    return not model.effects
