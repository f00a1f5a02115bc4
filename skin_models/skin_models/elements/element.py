"""What every element offers: response functions, and the two ways to drive it."""

from abc import ABC, abstractmethod

import numpy as np

from skin_models.elements.creeping import Creeping
from skin_models.elements.relaxing import Relaxing
from skin_models.errors import ModelError


class Element(ABC):
    """A linear viscoelastic element, at rest for t < 0."""

    @property
    @abstractmethod
    def relaxing(self) -> Relaxing:
        """The element driven by its depth: `state, force = relaxing.step(state, x, dt)`."""

    @property
    @abstractmethod
    def creeping(self) -> Creeping:
        """The element driven by its force: `state, depth = creeping.step(state, f, dt)`."""

    def relaxation(self, t):
        """Force at t > 0 per metre of depth that is applied at t = 0 and held, N/m. The impulse of a dashpot at t = 0 is left out."""
        return self.relaxing.function(t)

    def creep(self, t):
        """Depth at t > 0 per newton of force that is applied at t = 0 and held, m/N."""
        return self.creeping.function(t)

    def recovery(self, t, unloaded: float):
        """Depth at t > `unloaded` per newton that was applied at t = 0 and taken off at `unloaded`, m/N.

        Raises `ModelError` for an earlier t.
        """
        since = np.asarray(t) - unloaded
        if not np.all(since > 0.0):
            raise ModelError(f"recovery is for times after the unloading at {unloaded:g} s")
        return self.creep(t) - self.creep(since)

    def force(self, x: np.ndarray, dt: float) -> np.ndarray:
        """Force (N) of a depth history x (N,), m: a jump from zero to x[0], then linear between samples."""
        return self.relaxing.batch(x, dt)

    def depth(self, f: np.ndarray, dt: float) -> np.ndarray:
        """Depth (m) under a force history f (N,), N: a jump from zero to f[0], then linear between samples."""
        return self.creeping.batch(f, dt)

    def modulus(self, omega):
        """Complex stiffness at angular frequency omega (rad/s): storage + i loss, N/m."""
        return self.relaxing.modulus(omega)
