"""Bases of the effects that depend on the greatest depth so far: softening and damage, of the whole force or of the springs alone."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from skin_models.effect import Dynamic
from skin_models.operators.contact import branches, depth_in_contact
from skin_models.parameter import quantity
from skin_models.signals import Motion, Sample


class ByGreatestDepth(Dynamic):
    """Its state is the greatest depth so far (m); subclasses write `bent` once, for scalars and arrays alike."""

    @abstractmethod
    def bent(self, y: Any, x: Any, greatest: Any, s: Any) -> Any:
        """The forces `y` (2, ...) N of a motion `s` at depth `x`, where the greatest so far is `greatest` (m, both not below 0). Works
        elementwise."""

    def initial(self, rng=None) -> float:
        """The greatest depth so far, m: 0."""
        return 0.0

    def step(self, state, y, s: Sample, dt: float):
        """The force bent by this sample's depth among those so far."""
        x = depth_in_contact(s.x)
        greatest = np.maximum(state, x)
        return greatest, self.bent(y, x, greatest, s)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same with the running greatest depth."""
        x = depth_in_contact(s.x)
        return self.bent(y, x, np.maximum.accumulate(x), s)


class OfTheForce(ByGreatestDepth):
    """Springs and dashpots soften alike: y' = y factor(x, X). Subclasses write `factor`."""

    @abstractmethod
    def factor(self, x: Any, greatest: Any) -> Any:
        """What is left of the force at depth `x`, where the greatest so far is `greatest`, m."""

    def bent(self, y, x, greatest, s):
        """y factor(x, X)."""
        return y * self.factor(x, greatest)


@dataclass(frozen=True)
class OfTheSprings(ByGreatestDepth):
    """The springs soften, the dashpots do not: y' = y - k x share(x, X) on each branch. Subclasses write `share`."""

    linear: ClassVar[bool] = True

    k_sensed: float = quantity("N/m", 0.0, lower=0.0, typical=1200.0, doc="greatest stiffness that is lost, sensed")
    k_dispersed: float = quantity("N/m", 0.0, lower=0.0, typical=400.0, doc="greatest stiffness that is lost, dispersed")

    @abstractmethod
    def share(self, x: Any, greatest: Any) -> Any:
        """What share of the stiffness k is lost at depth `x`, where the greatest so far is `greatest`, m."""

    def bent(self, y, x, greatest, s):
        """y - k x share(x, X) on each branch."""
        return y - branches(self.k_sensed, self.k_dispersed, x * self.share(x, greatest), s.x)
