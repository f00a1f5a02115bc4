"""Tare: the mean of the unloaded sensors over a while, to be subtracted from then on. Never automatic."""

from dataclasses import dataclass

import numpy as np

from skin_models.words import counted
from skin_testbed_driver.motion import Motion
from skin_testbed_driver.sensing import Sample
from skin_testbed_driver.zeroing import Outcome


@dataclass(frozen=True)
class Offsets:
    """What to subtract, N: from the force, and from every taxel (T,)."""

    force: float
    taxels: np.ndarray


class Taring:
    """Averages `samples` samples; the outcome's value is `Offsets`."""

    def __init__(self, samples: int) -> None:
        """Offsets count from the untared signals, so that taring twice is taring once."""
        self._samples = samples
        self._forces: list[float] = []
        self._taxels: list[np.ndarray] = []

    def step(self, motion: Motion, sample: Sample, t: float) -> Outcome | None:
        """One sample at time `t` (s)."""
        self._forces.append(sample.load)
        self._taxels.append(sample.taxel_untared)
        if len(self._forces) < self._samples:
            return None
        known = np.isfinite(self._taxels)
        counts = known.sum(axis=0)
        taxels = np.where(known, self._taxels, 0.0).sum(axis=0) / np.maximum(counts, 1)  # 0 for a silent one
        silent = f"; {np.count_nonzero(counts == 0)} of the taxels said nothing" if (counts == 0).any() else ""
        means = f"offsets are the means of {counted(self._samples, 'sample')}"
        return Outcome(f"{means}{silent}", Offsets(float(np.mean(self._forces)), taxels))
