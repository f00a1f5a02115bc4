"""Pseudo-random ramps: the motion on which models are validated (thesis section 4.3.2), the same for the same seed.

Depths are uniform over the range, but at least a tenth of it from one to the next; speeds are log-uniform, so that slow and quick ramps
are equally frequent; every second ramp or so is followed by a hold. The last ramp leads back to where the first began.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.fields import whole
from skin_motion_profiles.profile import Moving, depth, seconds, speed
from skin_motion_profiles.trajectory import Piece

_LEAST_WAY = 0.1  # of the range


@dataclass(frozen=True)
class RandomRamps(Moving):
    """`count` ramps between `shallowest_mm` and `deepest_mm`, then one back to `shallowest_mm`."""

    kind: ClassVar[str] = "random_ramps"
    example: ClassVar = {"seed": 1, "deepest_mm": 1.0, "count": 12}

    seed: int = whole("seed of the depths, speeds and holds", ...)
    deepest_mm: float = depth("greatest depth", ...)
    shallowest_mm: float = depth("least depth, where it begins and ends", 0.0)
    count: int = whole("ramps", 20, lower=1, upper=100000)
    slowest_mm_s: float = speed("mm/s, least speed", 0.3)
    fastest_mm_s: float = speed("mm/s, greatest speed", 5.0)
    longest_hold_s: float = seconds("of the longest hold", 0.5)

    def check(self) -> None:
        """Raise `ProfileError` for a range of depths or of speeds that is upside down."""
        if self.deepest_mm <= self.shallowest_mm:
            raise ProfileError(f"{self.label}: deepest_mm = {self.deepest_mm:g} must exceed shallowest_mm = {self.shallowest_mm:g}")
        if self.fastest_mm_s < self.slowest_mm_s:
            raise ProfileError(f"{self.label}: fastest_mm_s = {self.fastest_mm_s:g} is less than slowest_mm_s = {self.slowest_mm_s:g}")

    def pieces(self, start: float) -> Iterable[Piece]:
        """The ramps that the seed draws: depths uniform, speeds log-uniform, half of the holds zero; `start` does not matter."""
        rng = np.random.default_rng(self.seed)
        here = self.shallowest_mm
        for _ in range(self.count):
            there, pace = self._next_depth(rng, here), self._speed(rng)
            yield from self.line(here, there, pace)
            yield from self.rest(there, self.longest_hold_s * max(2.0 * rng.random() - 1.0, 0.0))
            here = there
        yield from self.line(here, self.shallowest_mm, self._speed(rng))

    def _next_depth(self, rng: np.random.Generator, here: float) -> float:
        """Uniform over the range without the neighbourhood of `here`."""
        width, gap = self.deepest_mm - self.shallowest_mm, _LEAST_WAY * (self.deepest_mm - self.shallowest_mm)
        below, above = max(here - gap - self.shallowest_mm, 0.0), max(self.deepest_mm - here - gap, 0.0)
        u = rng.random() * (below + above)
        return self.shallowest_mm + u if u < below else min(here + gap + u - below, self.shallowest_mm + width)

    def _speed(self, rng: np.random.Generator) -> float:
        return float(self.slowest_mm_s * (self.fastest_mm_s / self.slowest_mm_s) ** rng.random())
