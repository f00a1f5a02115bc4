"""Base of the effects that depend on the greatest depth so far: softening and damage."""

from abc import abstractmethod
from typing import Any

import numpy as np

from skin_models.effect import Dynamic
from skin_models.operators.contact import depth_in_contact
from skin_models.signals import Motion, Sample


class ByGreatestDepth(Dynamic):
    """Its state is the greatest depth so far (m); subclasses write `factor` once, for scalars and arrays alike."""

    @abstractmethod
    def factor(self, x: Any, greatest: Any) -> Any:
        """What is left of the force at depth `x`, where the greatest so far is `greatest` (m, both not below 0). Works elementwise."""

    def initial(self, rng=None) -> float:
        """The greatest depth so far, m: 0."""
        return 0.0

    def step(self, state, y, s: Sample, dt: float):
        """y factor(x, greatest), this sample's depth among those so far."""
        x = depth_in_contact(s.x)
        greatest = np.maximum(state, x)
        return greatest, y * self.factor(x, greatest)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same with the running greatest depth."""
        x = depth_in_contact(s.x)
        return y * self.factor(x, np.maximum.accumulate(x))
