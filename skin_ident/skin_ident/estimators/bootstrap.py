"""Intervals without a noise model: stretches of the residual, all channels together, are drawn anew and carried through the fit.

The fit is linear in what was measured, so a drawn residual e* moves the coefficients by G' e*; no refit is needed, and shares, differences
and ratios are formed afterwards. The stretches must be longer than the residual's memory; by default they are a thirtieth of what was
recorded. What all drawings have in common is taken off: it is no scatter.
Source: H. R. Künsch, Ann. Statist. 17 (1989) 1217.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skin_ident.estimators.dispersion import settled, shape_of, theta_of
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.regression import Block
from skin_ident.estimators.sessions import prepare
from skin_ident.recordings.recording import Recording

NAMES = ("m", "b1", "k1", "b2", "k2")
FEWEST = 4  # stretches in all sessions together
STRETCHES = 30  # by default
FEWEST_RUNS, MOST_RUNS = 40, 100_000


@dataclass(frozen=True, eq=False)
class Bootstrap:
    """Drawn parameters (runs, P) by name; `stretch` is the length drawn, s."""

    names: tuple[str, ...]
    values: np.ndarray
    stretch: float

    def interval(self, name: str, level: float = 0.95) -> tuple[float, float]:
        """Percentile interval."""
        drawn = self.values[:, self.names.index(name)]
        low, high = np.percentile(drawn, [50 * (1 - level), 50 * (1 + level)])
        return float(low), float(high)


def bootstrap(
    recordings: Sequence[Recording],
    mass: float | str = 0.0,
    *,
    offsets: bool = False,
    runs: int = 2000,
    stretch: float | None = None,
    seed: int = 0,
) -> Bootstrap:
    """Draw the dispersion parameters `runs` times. `stretch` in s. Raises `FitError` where the sessions are too short for it."""
    if runs < FEWEST_RUNS:
        raise FitError(f"{runs} bootstrap samples have no 95 % interval: draw at least {FEWEST_RUNS}, better 1000")
    if runs > MOST_RUNS:
        raise FitError(f"{runs} bootstrap samples take hours and tell no more than {MOST_RUNS}: draw 1000")
    sessions, _ = prepare(recordings)
    shape = shape_of(sessions, mass, offsets)
    regression, blocks = settled(sessions, shape)
    period = sessions[0].motion.dt * sessions[0].prefilter.every
    recorded = period * sum(b.y.size for b in blocks[0])
    length = max(2, round((stretch or recorded / STRETCHES) / period))
    residuals = [[b.y - b.columns @ c for b in channel] for channel, c in zip(blocks, regression.coefficients, strict=True)]
    if sum(e.size // length for e in residuals[0]) < FEWEST:
        raise FitError(f"stretches of {length * period:.3g} s are too long for these sessions: at least {FEWEST} must fit in")
    gains = [[b.gain(p) for b in channel] for channel, p in zip(blocks, regression.inverses, strict=True)]
    rng, to = np.random.default_rng(seed), theta_of(regression, shape)
    beta = np.concatenate(regression.coefficients)
    grow = _growth(blocks, regression.coefficients)
    moves = np.array([_drawn(residuals, gains, length, rng) for _ in range(runs)])
    values = np.array([to(beta + grow * move) for move in moves - moves.mean(axis=0)])
    return Bootstrap((*NAMES, *(f"share_{i}" for i in shape.live)), values, length * period)


def _growth(blocks: list[list[Block]], coefficients: list[np.ndarray]) -> float:
    """Residuals are smaller than the noise by the parameters taken out."""
    rows = sum(b.narrow[0].size for b in blocks[0])
    return float(np.sqrt(rows / max(1, rows - max(c.size for c in coefficients))))


def _drawn(residuals: list[list[np.ndarray]], gains: list[list[np.ndarray]], length: int, rng: np.random.Generator) -> np.ndarray:
    """The change of all coefficients by one drawing: the same stretches for every channel."""
    sizes = [e.size for e in residuals[0]]
    picks = [_picked(sizes, n, length, rng) for n in sizes]
    whole = [np.concatenate(channel) for channel in residuals]
    return np.concatenate([sum(g.T @ e[p] for g, p in zip(channel, picks, strict=True)) for channel, e in zip(gains, whole, strict=True)])


def _picked(sizes: list[int], n: int, length: int, rng: np.random.Generator) -> np.ndarray:
    """Indices into the sessions laid end to end: random stretches, none across a border, n samples in all."""
    ends = np.cumsum(sizes)
    starts = np.concatenate([np.arange(end - size, end - length + 1) for end, size in zip(ends, sizes, strict=True)])
    drawn = rng.choice(starts, -(-n // length))
    return (drawn[:, None] + np.arange(length)).ravel()[:n]
