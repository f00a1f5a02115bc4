"""Finding the surface: press slowly until the rolling mean of the load cell's voltage has risen by a threshold (thesis, section 3.2.2).

The mean is over the last 100 samples and the threshold is 0.01 V, both as in the thesis. To be quick and exact at once the surface is
approached twice: fast with a tenth of the samples, then, after backing off, slowly with all of them. Free air just before the slow
approach gives the value from which the rise counts, so an offset of the load cell does not matter.

The threshold is reached only some way into the skin. The surface itself is where the force began to rise: the plunger leaves the skin as
slowly as it came, and on either way the voltage is a level in the air and a line in contact,

    u(x) = c + s max(0, x - x0)

with x0 by least squares. Coming, the force is ahead of a spring's by damping times speed, b v, and x0 lies b v / k above the surface;
leaving, it is behind by as much, and x0 as far below it. The surface is the mean of both.
"""

import math
from collections import deque
from collections.abc import Generator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from skin_models.words import counted
from skin_testbed_driver.motion import Motion
from skin_testbed_driver.sensing import Sample

PRESSED = 4.0  # thresholds to which it is pressed where the surface is extrapolated: the line is then longer than its noise is wide

_Way = list[tuple[float, float]]  # depth (m) and voltage (V) of every sample
_Stages = Generator[None, tuple[Motion, float, float, float], object]


class _NotFoundError(Exception):
    """The search has ended in vain; the sentence says why."""


class RollingMean:
    """Mean of the last `size` values, None until there are as many."""

    def __init__(self, size: int) -> None:
        """Start empty."""
        self._values: deque[float] = deque(maxlen=size)
        self._sum = 0.0

    def add(self, value: float) -> float | None:
        """Take one more value, and give the mean."""
        full = len(self._values) == self._values.maxlen
        self._sum += value - (self._values[0] if full else 0.0)
        self._values.append(value)
        return self._sum / len(self._values) if len(self._values) == self._values.maxlen else None


@dataclass(frozen=True)
class ZeroSettings:
    """Threshold (V), length of the rolling mean (samples), speeds of both approaches (m/s), how far to back off, to search and to retract
    at the end (m), and whether the surface is where the force began to rise or where it reached the threshold."""

    threshold: float = 0.01
    samples: int = 100
    fast: float = 5e-4
    slow: float = 2e-5
    back_off: float = 1.5e-4
    travel: float = 0.01
    retracted_depth: float = -0.002
    extrapolate: bool = True


@dataclass(frozen=True)
class Outcome:
    """How a job ended: with a sentence, and what it found (None: it failed)."""

    message: str
    value: object = None


class Zeroing:
    """One search for the surface; `step` once per sample until it gives an outcome, whose value is the surface's depth in m."""

    def __init__(self, settings: ZeroSettings) -> None:
        """Begin with listening in the air."""
        self._settings = settings
        self._stages = self._run()
        next(self._stages)

    def step(self, motion: Motion, sample: Sample, t: float) -> Outcome | None:
        """One sample at time `t` (s). Moves `motion`."""
        try:
            self._stages.send((motion, sample.depth, sample.force_voltage, t))
        except StopIteration as end:
            return end.value
        return None

    def _run(self) -> _Stages:
        s = self._settings
        _, start, _, _ = yield
        try:
            mean, air = yield from self._listen(max(s.samples // 10, 1))
            *_, (near, _) = yield from self._approach(s.fast, 2.0 * s.threshold, mean, air)
            yield from self._leave(near - s.back_off, s.fast)
            mean, free = yield from self._listen(s.samples)
            if air - free >= s.threshold:
                raise _NotFoundError("the plunger pressed on something before the search began: bring it into the air")
            if s.extrapolate:
                found, how = (yield from self._there_and_back(mean, free)), "the force begins to rise there"
            else:
                *_, (found, _) = yield from self._approach(s.slow, s.threshold, mean, free)
                how = f"the mean of {counted(s.samples, 'sample')} rose by {s.threshold:g} V"
        except _NotFoundError as error:
            yield from self._leave(start, math.inf)
            return Outcome(str(error))
        yield from self._leave(found + s.retracted_depth, math.inf)
        return Outcome(f"surface found: {how}", found)

    def _there_and_back(self, mean: RollingMean, free: float) -> _Stages:
        """Press slowly to some times the threshold and leave as slowly; gives the mean of the depths at which the force began and ended."""
        s = self._settings
        coming = yield from self._approach(s.slow, PRESSED * s.threshold, mean, free)
        deepest, _ = coming[-1]
        leaving = yield from self._leave(deepest - s.back_off, s.slow)
        return 0.5 * (onset(coming) + onset(leaving))

    def _listen(self, samples: int) -> _Stages:
        """A mean over as many samples, and its first value (V)."""
        mean, value = RollingMean(samples), None
        while value is None:
            _, _, voltage, _ = yield
            value = mean.add(voltage)
        return mean, value

    def _approach(self, speed: float, threshold: float, mean: RollingMean, air: float) -> _Stages:
        """Press until contact, in which `mean` differs from `air` (V); gives the way to there. Raises `_NotFoundError`."""
        motion, depth, _, t = yield
        way: _Way = []
        motion.go_to(depth + self._settings.travel, speed, t)
        while not motion.at_rest(t):
            motion, depth, voltage, t = yield
            way.append((depth, voltage))
            rise = mean.add(voltage) - air
            if abs(rise) >= threshold:
                motion.rest(t)
                if rise < 0.0:  # or it would press on until the limit of force
                    raise _NotFoundError("the load cell says that something pulls at the plunger: check the sign of its force")
                return way
        raise _NotFoundError(f"no contact within {1e3 * self._settings.travel:g} mm: is there anything below the plunger?")

    def _leave(self, depth: float, speed: float) -> _Stages:
        """Go to a depth, and give the way to there."""
        motion, _, _, t = yield
        way: _Way = []
        motion.go_to(depth, speed, t)
        while not motion.at_rest(t):
            motion, x, voltage, t = yield
            way.append((x, voltage))
        return way


def onset(way: _Way) -> float:
    """The depth x0 (m) at which the voltage begins to rise on one way, by least squares."""
    x, u = np.array(way).T

    def misfit(x0: float) -> float:
        h = np.maximum(x - x0, 0.0)
        h, v = h - h.mean(), u - u.mean()
        return float(v @ v - (h @ v) ** 2 / max(h @ h, 1e-300))

    return float(minimize_scalar(misfit, bounds=(x.min(), x.max()), method="bounded", options={"xatol": 1e-9}).x)
