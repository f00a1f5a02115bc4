"""Time shift: a channel is late, or its clock runs at another rate.

    y'(t) = y(t - delay - skew T)        T: time since the first sample; linear between samples; y(0) before the first one

`where` says which channel is late with respect to the rest: clock (force), clock_taxels, or clock_depth (all the skin's answers, as
seen from the encoder). A finding reports all three as `clock`. A negative delay (the channel is early) can be had for a recording; a
running simulation cannot look ahead and passes the signal on.

Source: T. I. Laakso et al., Splitting the unit delay, IEEE Signal Processing Magazine 13 (1996) 30-60 (linear interpolation).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Dynamic, Place
from skin_models.parameter import quantity
from skin_models.signals import Motion, Sample

LONGEST = 2.0  # s, what a running simulation remembers at most


@dataclass(frozen=True)
class TimeShift(Dynamic):
    """A late channel. State: the number of samples so far and the last of them, newest last."""

    cause: ClassVar[str] = "time_shift"
    places: ClassVar = {"clock": Place.LOAD_CELL, "clock_taxels": Place.TAXEL, "clock_depth": Place.DEPTH}
    source: ClassVar[str] = "Laakso et al. 1996"

    delay: float = quantity("s", 0.0, lower=-1.0, upper=1.0, typical=0.03, doc="how late the channel is at the first sample")
    skew: float = quantity("ppm", 0.0, lower=-1e4, upper=1e4, typical=200.0, doc="how much later it gets, in µs per s")

    def initial(self, rng=None) -> tuple[int, tuple]:
        return 0, ()

    def step(self, state, y, s: Sample, dt: float):
        n, past = state
        past = (*past[-int(LONGEST / dt) - 1 :], y) if self.delay or self.skew else (y,)
        back = min(max(self._late(n * dt) / dt, 0.0), len(past) - 1.0)
        whole = min(int(back), len(past) - 2) if len(past) > 1 else 0
        newer, older = past[-1 - whole], past[max(-2 - whole, -len(past))]
        return (n + 1, past), newer + (back - whole) * (older - newer)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        n = np.arange(len(s))
        at = np.clip(n - self._late(n * s.dt) / s.dt, 0.0, n[-1])
        whole = np.minimum(at.astype(int), n[-1] - 1)
        return y[..., whole] + (at - whole) * (y[..., whole + 1] - y[..., whole])

    def _late(self, elapsed):
        return self.delay + 1e-6 * self.skew * elapsed
