"""Base of the effects that depend on the time since the first sample: drifts, changes part-way, periodic disturbances."""

from abc import abstractmethod
from typing import Any

import numpy as np

from skin_models.effect import Dynamic
from skin_models.signals import Motion, Sample


class Elapsed(Dynamic):
    """Its state is the time of the first sample; subclasses write `apply` once, for scalars and arrays alike."""

    @abstractmethod
    def apply(self, y: Any, elapsed: Any) -> Any:
        """The changed signal, `elapsed` seconds after the first sample. Must work elementwise along the last axis."""

    def initial(self, rng=None) -> None:
        """None: the first sample's time is not known yet."""
        return None

    def step(self, state: float | None, y: Any, s: Sample, dt: float) -> tuple[float, Any]:
        """`apply` on one sample; the state is the time of the first, s."""
        first = s.t if state is None else state
        return first, self.put_back(y, self.apply(self.mine(y), s.t - first))

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """`apply` on the whole recording."""
        return self.put_back(y, self.apply(self.mine(y), s.t - s.t[0]))
