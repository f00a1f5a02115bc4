"""A sensor: the effects that a force passes on its way to a number, and the slope by which volts are read as newtons."""

from dataclasses import dataclass, replace

import numpy as np

from skin_models.effect import Effect
from skin_models.errors import ModelError
from skin_models.signals import motion

POUND_FORCE = 4.44822  # N, as in thesis eq 25


@dataclass(frozen=True)
class Reading:
    """The measurement of a force history, arrays (N,): the true force (N), the recorded voltage (V), the force read from it (N)."""

    truth: np.ndarray
    volts: np.ndarray
    force: np.ndarray


@dataclass(frozen=True)
class Sensor:
    """A chain of effects at one place. `slope` (N/V) is that of the calibration which the record is read with."""

    name: str
    slope: float
    effects: tuple[Effect, ...]

    def at(self, where: str) -> "Sensor":
        """The same sensor elsewhere, such as at `taxel_3`."""
        return replace(self, effects=tuple(replace(e, where=where) for e in self.effects))

    def measure(self, truth: np.ndarray, dt: float, seed: int | None = None) -> Reading:
        """Measure a force history (N,), N, sampled every `dt` s. `seed` drives the random effects; None leaves those out.

        Raises `ModelError` for a history that is not finite or has fewer than three samples.
        """
        truth = np.asarray(truth, float)
        if truth.ndim != 1 or not np.all(np.isfinite(truth)):
            raise ModelError(f"{self.name} measures a finite force history of shape (N,)")
        s, force = motion(np.arange(truth.size) * dt, np.zeros(truth.size)), truth[None]
        for i, e in enumerate(replace(e, where="taxel") for e in self.effects):
            force = e.batch(force, s, None if seed is None else np.random.default_rng([seed, i]))
        return Reading(truth, force[0] / self.slope, force[0])
