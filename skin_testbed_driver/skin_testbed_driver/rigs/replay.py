"""A recording as a rig: the driver publishes it again, sample by sample, at its own rate. It cannot be commanded."""

import math
from dataclasses import dataclass, field

import numpy as np

from skin_models.layout import Layout
from skin_models.words import counted
from skin_testbed_driver.rig import Reading, Rig, RigError


@dataclass(frozen=True)
class Track:
    """One recorded signal: times t (N,) s, growing, and values (N,) or (N, T). Between its samples it is linear."""

    t: np.ndarray
    values: np.ndarray

    def at(self, times: np.ndarray) -> np.ndarray:
        """Values at `times`, NaN outside the recording."""
        if self.values.ndim == 1:
            return np.interp(times, self.t, self.values, math.nan, math.nan)
        columns = [np.interp(times, self.t, column, math.nan, math.nan) for column in self.values.T]
        return np.array(columns).reshape(len(columns), len(times)).T


def _no_track() -> Track:
    return Track(np.zeros(1), np.empty((1, 0)))  # of no taxel


@dataclass(frozen=True)
class Recorded:
    """What a recording holds, on one clock: depth (m), force (N), taxels (N), which may be missing; and what was mended or is lost."""

    depth: Track
    force: Track
    taxels: Track = field(default_factory=_no_track)
    warnings: tuple[str, ...] = ()


class ReplayRig(Rig):
    """Plays a recording from its first common sample to its last, then says that it has ended."""

    owns_time = True
    moves = False
    travel = (-math.inf, math.inf)

    def __init__(self, recorded: Recorded, layout: Layout, loop: bool = False) -> None:
        """`loop` starts again at the end."""
        self.layout, self._recorded, self._loop = layout, recorded, loop

    def open(self, sample_rate: float) -> None:
        """Raises `RigError` for a recording in which depth and force do not overlap, or with other taxels than the layout has."""
        r = self._recorded
        begin, end = max(r.depth.t[0], r.force.t[0]), min(r.depth.t[-1], r.force.t[-1])
        if not end > begin:
            raise RigError("the recording's depth and force have no time in common")
        silent = r.taxels.values.shape[1] == 0  # a material test: taxels that say nothing
        if not silent and r.taxels.values.shape[1] != len(self.layout):
            there = counted(r.taxels.values.shape[1], "taxel")
            raise RigError(f"the recording has {there}, but the layout has {len(self.layout)}: leave that out")
        times = np.arange(begin, end + 0.5e-6, 1.0 / sample_rate)
        self._depth, self._force = r.depth.at(times), r.force.at(times)
        self._taxels = np.full((times.size, len(self.layout)), math.nan) if silent else r.taxels.at(times)
        self._i = 0

    def read(self) -> Reading:
        """The next sample, m and N. Raises `RigError` at the end, unless it loops."""
        if self._i == self._depth.size:
            if not self._loop:
                raise RigError("the recording has ended")
            self._i = 0
        i, self._i = self._i, self._i + 1
        return Reading(float(self._depth[i]), force=float(self._force[i]), taxel_force=self._taxels[i])

    def command(self, position: float, velocity: float) -> None:
        """Raises `RigError`: nothing moves."""
        raise RigError("a recording cannot be commanded")
