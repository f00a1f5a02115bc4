"""The noise of one channel as its residual shows it: level, colour, slow part, and growth with the load."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from skin_ident.criticism.telemetry.slow_part import AVERAGED_S, SlowPart, slow_part

SLOW, SLOW_IN_AIR = 0.6, 0.5  # rms of the slow part over the expected noise, everywhere and in the air, from which noise is slow in part,
LOUDER_SLOWLY = 1.2  # times the expected noise, which it must reach with its slow part as well
IN_AIR = 0.1  # of the expected noise, below which a simulated load is none
BURIED = 0.5  # rms of rounding over declared noise, from which the noise is buried: steps 1.7 times as wide as it
DROWNED = 0.5  # rms of the simulation's error over the declared noise, from which that error is most of what is seen
FEWEST = 300  # samples that a verdict needs


@dataclass(frozen=True)
class Look:
    """The noise of a channel: its declared `level`, and what `steps` of the converter and of the encoder add, N. For every session: the
    residual less its running median (`rows`), the `whole` residual, the simulated `loads` (not readings, which contain the noise), and
    masks of the samples to use (`believed`). `period` is that of the samples, s, the median over sessions; `where` says in words where the
    samples are from, if not from everywhere."""

    channel: str
    level: float
    steps: np.ndarray
    rows: list[np.ndarray]
    whole: list[np.ndarray]
    loads: list[np.ndarray]
    believed: list[np.ndarray]
    period: float
    where: str = ""

    @cached_property
    def e(self) -> np.ndarray:
        """The noise at all samples to be used (n,), N."""
        return np.concatenate([row[b] for row, b in zip(self.rows, self.believed, strict=True)])

    @cached_property
    def slow(self) -> float:
        """Spread of the residual including its slow part, N; 0 without samples."""
        apart = [e[b] - e[b].mean() for e, b in zip(self.whole, self.believed, strict=True) if b.any()]
        return spread(np.concatenate(apart)) if apart else 0.0

    @cached_property
    def in_air(self) -> "Look":
        """The noise without load, to which errors of the depth add nothing."""
        own = float(np.hypot(self.level, self.steps[0]))
        air = [b & (np.abs(y) < IN_AIR * own) for y, b in zip(self.loads, self.believed, strict=True)]
        return replace(self, steps=np.array([self.steps[0], 0.0]), believed=air, where=" in the air")

    @property
    def is_drowned(self) -> bool:
        """Whether errors of the depth are about as loud as the noise."""
        return bool(self.steps[1] >= DROWNED * self.level)

    @cached_property
    def expected(self) -> float:
        """Expected spread, N, from what is declared, steps and encoder."""
        return float(np.hypot(self.level, np.hypot(*self.steps)))

    @cached_property
    def times_expected(self) -> float:
        """Ratio of the spread to the expected one."""
        return spread(self.e) / self.expected

    @property
    def is_buried(self) -> bool:
        """Whether rounding to the converter's steps hides the noise."""
        return bool(self.steps[0] >= BURIED * self.level)

    @property
    def is_its_own(self) -> bool:
        """Whether the noise is mostly the channel's own: neither buried in steps nor mostly encoder errors, which are coloured and grow
        with the load."""
        return not self.is_buried and not self.is_drowned and self.e.size >= FEWEST

    @property
    def declared(self) -> str:
        """The declaration, in words."""
        return f"rig.yaml declares noise of {self.level:.3g} N"

    @cached_property
    def colour(self) -> float:
        """Correlation of neighbouring samples, median over sessions."""
        return float(np.median([neighbours(row, b) for row, b in zip(self.rows, self.believed, strict=True)]))

    @cached_property
    def slow_part(self) -> SlowPart | None:
        """The slow part of the noise at all samples to be used."""
        return slow_part(self.rows, self.believed, self.period)

    @cached_property
    def slow_in_air(self) -> SlowPart | None:
        """The same without load."""
        return slow_part(
            self.rows, [b & (np.abs(y) < IN_AIR * self.expected) for y, b in zip(self.loads, self.believed, strict=True)], self.period
        )

    @property
    def is_slow_in_part(self) -> bool:
        """Whether the noise is louder than declared, and much of it slow, in the air as well: slower than an amplifier's low-pass."""
        everywhere, air = self.slow_part, self.slow_in_air
        much = bool(everywhere and air and everywhere.rms > SLOW * self.expected and air.rms > SLOW_IN_AIR * self.expected)
        return much and everywhere.tau > AVERAGED_S and self.slow > LOUDER_SLOWLY * self.expected

    @cached_property
    def sways(self) -> float:
        """Ratio to the expected spread of the spread with its slow part, but without a trend that bends once in each session, which may be
        drift; the lesser one of everywhere and in the air, 0 where there is too little air."""
        air = self.in_air.believed
        if sum(map(np.count_nonzero, air)) < FEWEST:
            return 0.0
        rows = [_without_trend(e, b) for e, b in zip(self.whole, self.believed, strict=True)]
        there, aloft = (np.concatenate([e[m] for e, m in zip(rows, masks, strict=True)]) for masks in (self.believed, air))
        return min(spread(there) / self.expected, spread(aloft) / self.in_air.expected)

    @cached_property
    def idle_and_loaded(self) -> tuple[float, float, float]:
        """Spread under the lowest third of loads and under the highest, and the mean magnitude of the latter, N; zeros where the loads
        hardly differ."""
        y = np.concatenate([load[b] for load, b in zip(self.loads, self.believed, strict=True)])
        low, high = np.percentile(y, [33.0, 67.0])
        if high <= low + self.expected:
            return 0.0, 0.0, 0.0
        most = y >= high
        return max(spread(self.e[y <= low]), 0.5 * self.expected), spread(self.e[most]), max(float(np.mean(np.abs(y[most]))), 1e-9)

    @property
    def times_under_load(self) -> float:
        """Ratio of the spread under the greatest loads to that under the least."""
        idle, loaded, _ = self.idle_and_loaded
        return loaded / idle if idle else 1.0

    @property
    def times_expected_idle(self) -> float:
        """`times_expected` of the third of the samples with the least load; of all where the loads hardly differ."""
        idle, _, _ = self.idle_and_loaded
        return idle / self.expected if idle else self.times_expected

    @property
    def growth(self) -> float:
        """By how much the noise grows with the load, a share s of it: loaded^2 = idle^2 + (s load)^2."""
        idle, loaded, load = self.idle_and_loaded
        return float(np.sqrt(max(loaded**2 - idle**2, 0.0)) / load) if load else 0.0

    def would_grow(self, share: float) -> float:
        """What `times_under_load` would be if the noise grew by this share of the load: 1 where there is hardly any load."""
        idle, _, load = self.idle_and_loaded
        return float(np.hypot(1.0, share * load / idle)) if idle else 1.0


def spread(e: np.ndarray) -> float:
    """Standard deviation of noise e (n,)."""
    return float(np.mean(np.abs(e)) * np.sqrt(np.pi / 2.0))  # a mean, not a median: quantized noise has few levels


def neighbours(e: np.ndarray, believed: np.ndarray) -> float:
    """Correlation of neighbouring samples that are both `believed`, (N,)."""
    pairs = believed[1:] & believed[:-1]
    a, b = e[1:][pairs], e[:-1][pairs]
    return float(a @ b / max(np.sqrt((a @ a) * (b @ b)), 1e-300))


def _without_trend(e: np.ndarray, believed: np.ndarray) -> np.ndarray:
    """A residual (N,) less the parabola through its samples that are `believed`, (N,)."""
    if np.count_nonzero(believed) < 4:
        return e
    t = np.linspace(-1.0, 1.0, e.size)
    return e - np.polyval(np.polyfit(t[believed], e[believed], 2), t)
