"""Noise of a sensor channel: white, coloured, growing with load or heavy-tailed."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

KINDS = ("white", "ar", "hetero", "t3", "ar_t3")


@dataclass(frozen=True)
class Noise:
    """`level` in ADC steps (standard deviation), `rho` of the AR(1) kinds, `growth` of the level per full load of hetero."""

    kind: str = "white"
    level: float = 0.7
    rho: float = 0.9
    growth: float = 3.0

    def draw(self, rng, load, step) -> np.ndarray:
        """Samples (N) beside the noise-free `load` (N), for a converter with steps of `step` (N). Standard deviation: level x step."""
        if self.kind not in KINDS:
            raise ValueError(f"no noise called {self.kind!r}; there are {KINDS}")
        n = load.size
        raw = rng.standard_t(3, n) / np.sqrt(3) if self.kind.endswith("t3") else rng.standard_normal(n)
        if self.kind.startswith("ar"):
            raw = _coloured(raw, self.rho, rng)
        if self.kind == "hetero":
            raw = raw * _shape(load, self.growth)
        return self.level * step * raw


def _coloured(raw, rho, rng):
    start = rng.standard_normal()
    return lfilter([np.sqrt(1 - rho**2)], [1, -rho], raw, zi=[rho * start])[0]


def _shape(load, growth):
    shape = 1 + growth * np.abs(load) / max(np.max(np.abs(load)), 1e-9)
    return shape / np.sqrt(np.mean(shape**2))


def as_noise(noise, rng) -> Noise:
    """A `Noise` from itself, a kind, or "any" (everything drawn)."""
    if isinstance(noise, Noise):
        return noise
    kind = str(rng.choice(KINDS)) if noise == "any" else noise
    rho = float(rng.choice([0.5, 0.9, 0.97, 0.995]))
    return Noise(kind, float(np.exp(rng.uniform(np.log(0.3), np.log(3.0)))), rho)
