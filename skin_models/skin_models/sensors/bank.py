"""Many taxels at once, each with its own faults: what a simulated skin of thousands of taxels needs beside `taxel_<i>` effects.

    y' = gain (1 - dead) y + bias + walk + white noise,        all per taxel; a dead taxel reads its bias

and the whole bank may be late by a delay and a jitter, as one message is.
"""

from dataclasses import dataclass, field

import numpy as np

from skin_models.effects.time_shift import TimeJitter, TimeShift
from skin_models.errors import ModelError
from skin_models.parameter import check_parameters, quantity
from skin_models.signals import Sample

NEVER = Sample(0.0, 0.0, 0.0, 0.0)  # the clock's effects do not look at the motion


@dataclass(frozen=True)
class TaxelBank:
    """Faults of `count` taxels, drawn once from `seed`. Raises `ModelError` for a size outside its bounds or a count below one."""

    count: int
    seed: int = 0
    gain_spread: float = quantity("1", 0.0, lower=0.0, upper=1.0, doc="standard deviation of ln(gain) between taxels")
    bias_spread: float = quantity("N", 0.0, lower=0.0, upper=1e3, doc="standard deviation of the bias between taxels")
    dead: float = quantity("1", 0.0, lower=0.0, upper=1.0, doc="share of taxels that are dead")
    walk: float = quantity("N/s^0.5", 0.0, lower=0.0, upper=1e3, doc="random walk of every taxel's zero")
    noise: float = quantity("N", 0.0, lower=0.0, upper=1e3, doc="standard deviation of white noise")
    delay: float = quantity("s", 0.0, lower=0.0, upper=1.0, doc="how late all of them are")
    jitter: float = quantity("s", 0.0, lower=0.0, upper=1.0, doc="longest random delay on top")
    gains: np.ndarray = field(init=False, repr=False, compare=False)
    biases: np.ndarray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_parameters(self)
        if self.count < 1:
            raise ModelError(f"a bank of taxels needs at least one taxel, not {self.count}")
        rng = np.random.default_rng(self.seed)
        alive = rng.random(self.count) >= self.dead
        object.__setattr__(self, "gains", alive * np.exp(self.gain_spread * rng.standard_normal(self.count)))
        object.__setattr__(self, "biases", self.bias_spread * rng.standard_normal(self.count))

    def initial(self) -> "BankState":
        """At rest."""
        rng = np.random.default_rng([self.seed, 1])
        return BankState(rng, np.zeros(self.count), self._shift.initial(), self._jitter.initial(rng))

    def step(self, state: "BankState", y: np.ndarray, dt: float) -> tuple["BankState", np.ndarray]:
        """One sample: true forces (count,), N, to readings. Unlike an effect's, the state is used up: its generator moves on."""
        walk = state.walk
        if self.walk:
            walk = walk + self.walk * np.sqrt(dt) * state.rng.standard_normal(self.count)
        out = self.gains * y + self.biases + walk
        if self.noise:
            out += self.noise * state.rng.standard_normal(self.count)
        late, out = self._shift.step(state.late, out, NEVER, dt)
        jittered, out = self._jitter.step(state.jittered, out, NEVER, dt)
        return BankState(state.rng, walk, late, jittered), out

    @property
    def _shift(self) -> TimeShift:
        return TimeShift(where="clock_taxels", delay=self.delay)

    @property
    def _jitter(self) -> TimeJitter:
        return TimeJitter(where="clock_taxels", jitter=self.jitter)


@dataclass(frozen=True)
class BankState:
    """Where a bank's randomness and its clock are."""

    rng: np.random.Generator
    walk: np.ndarray
    late: tuple
    jittered: tuple
