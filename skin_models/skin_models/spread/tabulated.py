"""A spread kernel given by a table, for shapes that no formula of `kernels` has: what a scan measured."""

import math
from dataclasses import dataclass, field

import numpy as np

from skin_models.errors import ModelError
from skin_models.parameter import SHAPE, quantity
from skin_models.spread.kernels import Kernel


@dataclass(frozen=True)
class Tabulated(Kernel):
    """`shares[i]` at distance `at[i]` times `width`, linear between, zero beyond the last; the first is at 0 and has share 1.

    Raises `ModelError` for a table that does not start so, does not increase in `at`, or holds shares that are not within 0 and 2.
    """

    width: float = quantity("m", lower=1e-6, upper=1.0, role=SHAPE, doc="what the distances of the table are multiples of")
    at: tuple[float, ...] = field(kw_only=True)
    shares: tuple[float, ...] = field(kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        at, shares = np.array(self.at, float), np.array(self.shares, float)
        if at.size < 2 or at.shape != shares.shape or not (np.isfinite(at).all() and np.isfinite(shares).all()):
            raise ModelError("a table of the spread needs as many shares as distances, two or more, all finite")
        if at[0] != 0.0 or np.any(np.diff(at) <= 0.0) or shares[0] != 1.0 or shares.min() < 0.0 or shares.max() > 2.0:
            raise ModelError("a table of the spread starts at distance 0 with share 1, its distances increase, its shares are 0 to 2")

    def shape(self, r):
        """Linear between the entries of the table, 0 beyond the last."""
        return np.interp(np.asarray(r) / self.width, self.at, self.shares, right=0.0)

    @property
    def area(self):
        """2 pi times the integral of r shape(r), exact for straight lines between the entries."""
        # r times a straight line, integrated exactly over each piece
        a, b = np.array(self.at[:-1]), np.array(self.at[1:])
        s, t = np.array(self.shares[:-1]), np.array(self.shares[1:])
        pieces = (b - a) * (a * (2.0 * s + t) + b * (s + 2.0 * t)) / 6.0
        return 2.0 * math.pi * self.width**2 * float(pieces.sum())

    def reach(self, tolerance):
        """The entry behind the last share that is `tolerance` or more."""
        above = np.flatnonzero(np.array(self.shares) >= tolerance)[-1]
        return self.width * self.at[min(above + 1, len(self.at) - 1)]
