"""A model fed with one measured depth at a time, as it arrives: the simulated skin beside a running or replayed measurement."""

import math
from dataclasses import replace

import numpy as np

from skin_models.layout import A201_AREA, Layout
from skin_models.model import Model, Response, State
from skin_models.signals import DEEPEST, Sample
from skin_models.spread.contacts import Contacts
from skin_models.spread.field import SpreadField
from skin_models.spread.kernels import Kernel

GAP = 1.0  # s; after a longer silence the skin is taken to be at rest again
_BEHIND = 20  # samples in a row with older stamps, which are no longer stragglers: the clock was set back


class LiveModel:
    """Steps a model from stamp to stamp.

    The speed is the one given, or the backward difference of the depth; the acceleration is the backward difference of the speed. A
    stamp that does not advance and a depth beyond 100 mm are refused (`step` gives None), a silence of more than a second starts from
    rest. `refused` and `restarts` count both. So does a clock that was set back, as where a bag is played again or a simulation is
    reset: after a few samples.
    """

    def __init__(self, model: Model, seed: int | None = None) -> None:
        """`seed` drives the effects that are random; None leaves those out."""
        self.model, self.seed = model, seed
        self.refused = self.restarts = 0
        self._last: Sample | None = None
        self._behind = 0  # samples in a row with stamps older than the newest
        self._state: State = model.initial(seed)

    def step(self, t: float, x: float, v: float = math.nan) -> Response | None:
        """The response at time `t` (s) to depth `x` (m) and speed `v` (m/s); None for a sample that cannot be used."""
        ahead = t - self._last.t if self._last is not None else math.inf
        self._behind = self._behind + 1 if ahead < 0.0 else 0
        set_back = self._behind >= _BEHIND
        if not math.isfinite(t + x) or x > DEEPEST or (ahead <= 0.0 and not set_back):
            self.refused += 1
            return None
        if set_back or ahead > GAP:
            return self._start(Sample(t, x, v if math.isfinite(v) else 0.0, 0.0))
        last, dt = self._last, ahead
        v = v if math.isfinite(v) else (x - last.x) / dt
        return self._advance(Sample(t, x, v, (v - last.v) / dt), dt)

    def _start(self, s: Sample) -> Response:
        self._behind = 0
        if self._last is not None:
            self.restarts += 1
            self._state = self.model.initial(self.seed)
        return self._advance(s, 0.01)

    def _advance(self, s: Sample, dt: float) -> Response:
        self._state, response = self.model.step(self._state, s, dt)
        self._last = s
        return response


def under_plunger(model: Model, layout: Layout, kernel: Kernel, radius: float = 0.0) -> Model:
    """The model with the positions and shares of `layout`, for a plunger of `radius` (m) at the origin.

    A model that already has as many shares as there are taxels keeps them: they were measured. The share of a model of a single taxel
    becomes that of a taxel right under the plunger.
    """
    positions = tuple(map(tuple, layout.positions[:, :2].tolist()))
    if len(model.shares) == len(layout):
        return model if model.positions or len(layout) == 1 else replace(model, positions=positions)
    under = min(model.dispersion.sensed_share, 1.0) if model.dispersion.k1 > 0.0 else 1.0  # of the force, right under the plunger
    found = SpreadField(layout, kernel, under, A201_AREA).shares(Contacts([[0.0, 0.0, 0.0]], [1.0], radius))
    shares = np.zeros(len(layout))
    shares[found.taxel] = found.value / under * (model.shares[0] if len(model.shares) == 1 else 1.0)
    return replace(model, shares=tuple(shares.tolist()), positions=positions)
