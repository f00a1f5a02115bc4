"""Backlash: depth is lost at every reversal of the drive.

    tip depth = P[x],  the play operator of half width gap / 2 (`skin_models.operators.play`)

The drive starts in the middle of its gap. Exact for any path that is monotone between samples.

Source: M. Nordin and P.-O. Gutman, Controlling mechanical systems with backlash: a survey, Automatica 38 (2002) 1633-1649.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Dynamic, Place
from skin_models.operators.play import play, play_step
from skin_models.parameter import quantity
from skin_models.signals import Motion, Sample


@dataclass(frozen=True)
class Backlash(Dynamic):
    """A gap between encoder and tip."""

    cause: ClassVar[str] = "backlash"
    places: ClassVar = {"rig": Place.DEPTH}
    source: ClassVar[str] = "Nordin and Gutman 2002"

    gap: float = quantity("m", 0.0, lower=0.0, upper=5e-3, typical=0.1e-3, doc="whole width of the gap")

    def initial(self, rng=None) -> None:
        """None: the first sample is taken as rest. From then on the state is the tip's depth, m."""
        return None

    def step(self, state, y, s: Sample, dt: float):
        """min(x + gap / 2, max(x - gap / 2, last tip))."""
        tip = play_step(state, y, 0.5 * self.gap)
        return tip, tip

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The play operator over the whole recording."""
        return play(y, 0.5 * self.gap)
