"""How well the sampling loop keeps its time: achieved rate, jitter, overruns and skipped samples."""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class LoopReport:
    """`ticks`, `overruns` and `skipped` count since the start; the rate (Hz) and the jitter (s) are those of the last seconds.

    The jitter of a sample is by how much its period differs from the wanted one. An overrun is a sample that began more than one
    period late; a skipped sample was never taken.
    """

    ticks: int
    overruns: int
    skipped: int
    rate: float
    jitter_p50: float
    jitter_p99: float
    jitter_max: float


class LoopStatistics:
    """Collects the times at which samples began."""

    def __init__(self, period: float, memory: float = 10.0) -> None:
        """`period` (s) as wanted, and how many seconds the rate and the jitter look back."""
        self.ticks = self.overruns = self.skipped = 0
        self._period = period
        self._times = np.zeros(max(int(memory / period), 3))  # a ring, so that a report copies it in no time

    def tick(self, began: float, deadline: float) -> None:
        """A sample began at `began` and should have at `deadline`, both s of one monotonic clock."""
        self._times[self.ticks % self._times.size] = began
        self.ticks += 1
        self.overruns += began - deadline > self._period

    def skip(self, count: int) -> None:
        """`count` samples were left out."""
        self.skipped += count

    def report(self) -> LoopReport:
        """The present figures."""
        ticks, times = self._present()
        periods = np.diff(np.roll(times, -ticks)[1:] if ticks >= times.size else times[:ticks])
        if periods.size == 0:
            return LoopReport(self.ticks, self.overruns, self.skipped, math.nan, math.nan, math.nan, math.nan)
        jitter = np.abs(periods - self._period)
        p50, p99 = np.percentile(jitter, (50, 99))
        return LoopReport(self.ticks, self.overruns, self.skipped, 1.0 / float(periods.mean()), float(p50), float(p99), float(jitter.max()))

    def _present(self) -> tuple[int, np.ndarray]:
        """How many samples there were, and the ring as it was then; its oldest time may be overwritten already."""
        while True:
            ticks, times = self.ticks, self._times.copy()
            if ticks == self.ticks:
                return ticks, times
