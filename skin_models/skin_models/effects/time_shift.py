"""Time shift: a channel is late, or its clock runs at another rate.

    shift          y'(t) = y(t - delay)
    skewed         y'(t) = y(t - delay - skew T)        T: time since the first sample
    jitter         y'(t) = y(t - J u)                   u: drawn afresh at every sample, evenly from 0 to 1
    scanned        y'[i](t) = y[i](t - i s)             taxel i is read so long after taxel 0

All are linear between samples and hold y(0) before the first one.

`where` says which channel is late with respect to the rest: clock (force), clock_taxels, or clock_depth (all the skin's answers, as
seen from the encoder). A finding reports all three as `clock`. A negative delay (the channel is early) works for a whole recording only; a
running simulation cannot look ahead and passes the signal on. Jitter needs a random generator and is not proposed for a finding: its
mean is a delay, the rest noise that grows with the slope. A multiplexer that reads the taxels one after the other, with one time stamp
for all of them, makes each later than the one before; s < 0 where it reads them the other way round.

Source: T. I. Laakso et al., Splitting the unit delay, IEEE Signal Processing Magazine 13 (1996) 30-60 (linear interpolation).
"""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Dynamic, Place
from skin_models.operators.draws import Stream, new_key, uniform, whole
from skin_models.parameter import PROMPT, quantity
from skin_models.signals import Motion, Sample

PLACES = {"clock": Place.LOAD_CELL, "clock_taxels": Place.TAXEL, "clock_depth": Place.DEPTH}


@dataclass(frozen=True)
class TimeShift(Dynamic):
    """A late channel."""

    cause: ClassVar[str] = "time_shift"
    places: ClassVar = PLACES
    source: ClassVar[str] = "Laakso et al. 1996"

    delay: float = quantity(
        "s", 0.0, lower=-1.0, upper=1.0, typical=0.03, negligible=PROMPT, scan=(0.003, 0.1), doc="how late the channel is"
    )

    def initial(self, rng=None) -> tuple:
        """The last samples, newest last: none."""
        return ()

    def step(self, state, y, s: Sample, dt: float):
        """y(t - delay), looked up among the samples kept; the present one where that is still to come."""
        late = self.delay / dt
        past = _remembered(state, y, late)
        return past, _looked_up(past, late)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """y at the shifted times; also for a channel that is early."""
        return _delayed(y, self.delay / s.dt)


@dataclass(frozen=True)
class SkewedClock(Dynamic):
    """A channel whose clock runs at another rate, so that it gets later with time."""

    cause: ClassVar[str] = "time_shift"
    form: ClassVar[str] = "skewed"
    places: ClassVar = PLACES
    source: ClassVar[str] = "Laakso et al. 1996, with a delay that grows"
    refines: ClassVar[type] = TimeShift

    skew: float = quantity("ppm", 0.0, lower=-1e4, upper=1e4, typical=200.0, negligible=2.0, doc="how much later it gets with time")
    delay: float = quantity("s", 0.0, lower=-1.0, upper=1.0, typical=0.001, negligible=PROMPT, doc="how late the channel is at first")

    def initial(self, rng=None) -> tuple[int, tuple]:
        """Number of samples so far, and the last of them, newest last: 0 and none."""
        return 0, ()

    def step(self, state, y, s: Sample, dt: float):
        """y(t - delay - skew T), looked up among the samples kept; the present one where that is still to come."""
        n, past = state
        late = self.delay / dt + 1e-6 * self.skew * n
        past = _remembered(past, y, late)
        return (n + 1, past), _looked_up(past, late)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """y at the shifted times; also for a channel that is early."""
        return _shifted(y, (1.0 - 1e-6 * self.skew) * np.arange(len(s)) - self.delay / s.dt)


@dataclass(frozen=True)
class TimeJitter(Dynamic):
    """A channel that is late by chance."""

    cause: ClassVar[str] = "time_shift"
    form: ClassVar[str] = "jitter"
    proposed: ClassVar[bool] = False
    places: ClassVar = PLACES
    source: ClassVar[str] = "Laakso et al. 1996, with a random delay"

    jitter: float = quantity("s", 0.0, lower=0.0, upper=1.0, typical=0.01, doc="longest delay J")

    def initial(self, rng=None) -> tuple[Stream, tuple] | None:
        """A random stream and the last samples, newest last; None without a generator."""
        return None if rng is None else (Stream(new_key(rng)), ())

    def step(self, state, y, s: Sample, dt: float):
        """y(t - J u), u the next number of the stream."""
        if state is None:
            return None, y
        stream, past = state
        stream, u = stream.next((), uniform)
        past = _remembered(past, y, self.jitter / dt)
        return (stream, past), _looked_up(past, float(u) * self.jitter / dt)

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same numbers at once."""
        if rng is None:
            return y
        n = np.arange(len(s))
        return _shifted(y, n - whole(new_key(rng), n.shape, uniform) * self.jitter / s.dt)


@dataclass(frozen=True)
class Scanning(Dynamic):
    """Taxels that are read one after the other."""

    cause: ClassVar[str] = "time_shift"
    form: ClassVar[str] = "scanned"
    places: ClassVar = {"clock_taxels": Place.TAXEL}
    source: ClassVar[str] = "Laakso et al. 1996, one delay for each channel"

    per_taxel: float = quantity("s", 0.0, lower=-0.2, upper=0.2, typical=0.01, doc="how much later s each taxel is than the one before")

    def initial(self, rng=None) -> tuple:
        """The last samples, newest last: none."""
        return ()

    def step(self, state, y, s: Sample, dt: float):
        """Every taxel at its own time, the present one where that is still to come."""
        late = self._late(len(y)) / dt
        past = _remembered(state, y, max(late, default=0.0))
        return past, np.array([_looked_up(past, back)[i] for i, back in enumerate(late)])

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """Every row at its own shifted times; also where taxels are early."""
        return np.array([_delayed(row, late / s.dt) for row, late in zip(y, self._late(len(y)), strict=True)]).reshape(y.shape)

    def _late(self, n_taxels: int) -> np.ndarray:
        return self.per_taxel * np.arange(n_taxels)


def _remembered(past: tuple, y, late: float) -> tuple:
    """The samples that may be looked up now or next, if the delay (in samples) grows by less than one per sample."""
    return (*past[-int(max(late, 0.0)) - 2 :], y)


def _looked_up(past: tuple, back: float):
    """The signal `back` samples ago, linear between samples; the oldest known if that is longer ago, the newest if it is still to come."""
    back = min(max(back, 0.0), len(past) - 1.0)
    older = min(int(back) + 1, len(past) - 1)
    newer = max(older - 1, 0)
    return past[-1 - newer] + (back - newer) * (past[-1 - older] - past[-1 - newer])


def _shifted(y: np.ndarray, at: np.ndarray) -> np.ndarray:
    """`y` at fractional indices, held beyond its ends."""
    last = y.shape[-1] - 1
    at = np.clip(at, 0.0, last)
    before = np.minimum(at.astype(int), max(last - 1, 0))
    after = np.minimum(before + 1, last)
    earlier, later = np.take(y, before, axis=-1), np.take(y, after, axis=-1)
    return earlier + (at - before) * (later - earlier)


def _delayed(y: np.ndarray, back: float) -> np.ndarray:
    """`y` delayed by a constant number of samples, whole or not, held beyond its ends: `_shifted` without looking up every sample."""
    full, n = math.floor(back), y.shape[-1]
    before, behind = max(full + 1, 0), max(-full, 0)
    held = np.concatenate([np.repeat(y[..., :1], before, -1), y, np.repeat(y[..., -1:], behind, -1)], axis=-1)
    start = before - full
    newer, older = held[..., start : start + n], held[..., start - 1 : start - 1 + n]
    return newer + (back - full) * (older - newer)
