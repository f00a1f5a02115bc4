"""Finding the surface: press slowly until the rolling mean of the load cell's voltage has risen by a threshold (thesis, section 3.2.2).

The mean is over the last 100 samples and the threshold is 0.01 V, both as in the thesis. To be quick and exact at once the surface is
approached twice: fast with a tenth of the samples, then, after backing off, slowly with all of them. Free air just before the slow
approach gives the value from which the rise counts, so an offset of the load cell does not matter.
"""

import math
from collections import deque
from collections.abc import Generator
from dataclasses import dataclass

from skin_testbed_driver.motion import Motion
from skin_testbed_driver.sensing import Sample

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
    """Threshold (V), length of the rolling mean (samples), speeds of both approaches (m/s), how far to back off, to search
    and to retract at the end (m)."""

    threshold: float = 0.01
    samples: int = 100
    fast: float = 5e-4
    slow: float = 2e-5
    back_off: float = 1.5e-4
    travel: float = 0.01
    retracted_depth: float = -0.002


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
            found = yield from self._approach(s.fast, 2.0 * s.threshold, mean, air)
            yield from self._leave(found - s.back_off, s.fast)
            mean, free = yield from self._listen(s.samples)
            if air - free >= s.threshold:
                raise _NotFoundError("the plunger pressed on something before the search began: bring it into the air")
            found = yield from self._approach(s.slow, s.threshold, mean, free)
        except _NotFoundError as error:
            yield from self._leave(start, math.inf)
            return Outcome(str(error))
        yield from self._leave(found + s.retracted_depth, math.inf)
        return Outcome(f"surface found: the mean of {s.samples} samples rose by {s.threshold:g} V", found)

    def _listen(self, samples: int) -> _Stages:
        """A mean over as many samples, and its first value (V)."""
        mean, value = RollingMean(samples), None
        while value is None:
            _, _, voltage, _ = yield
            value = mean.add(voltage)
        return mean, value

    def _approach(self, speed: float, threshold: float, mean: RollingMean, air: float) -> _Stages:
        """Press until contact, in which `mean` differs from `air` (V); gives the depth of contact. Raises `_NotFoundError`."""
        motion, depth, _, t = yield
        motion.go_to(depth + self._settings.travel, speed, t)
        while not motion.at_rest(t):
            motion, depth, voltage, t = yield
            rise = mean.add(voltage) - air
            if abs(rise) >= threshold:
                motion.rest(t)
                if rise < 0.0:  # or it would press on until the limit of force
                    raise _NotFoundError("the load cell says that something pulls at the plunger: check the sign of its force")
                return depth
        raise _NotFoundError(f"no contact within {1e3 * self._settings.travel:g} mm: is there anything below the plunger?")

    def _leave(self, depth: float, speed: float) -> _Stages:
        motion, _, _, t = yield
        motion.go_to(depth, speed, t)
        while not motion.at_rest(t):
            motion, _, _, t = yield
