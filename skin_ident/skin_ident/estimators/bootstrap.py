"""Intervals that do not take the noise for normal or even: stretches of the residual, all channels together, are drawn anew.

The fit is linear in what was measured, so a drawn residual e* moves the coefficients by G' e*; no refit is needed, and shares, differences
and ratios are formed afterwards. Noise that remembers longer than a stretch lasts would come out too small: the residual goes through each
channel's noise model, stretches of what is left are drawn, and the model gives them their memory back. They are a thirtieth of what was
recorded by default. What all drawings have in common is taken off: it is no scatter; and they are widened for there being so few stretches.
Source: H. R. Künsch, Ann. Statist. 17 (1989) 1217; whitening before, D. W. K. Andrews, J. C. Monahan, Econometrica 60 (1992) 953.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skin_ident.estimators.dispersion import settled, shape_of, theta_of
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.noise import coloured
from skin_ident.estimators.regression import Block, Regression
from skin_ident.estimators.sessions import prepare
from skin_ident.estimators.transfer_data import whitened
from skin_ident.recordings.recording import Recording
from skin_models.signals import Motion

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
        """Between which ends, SI, the middle `level` of what was drawn of a parameter lies."""
        drawn = self.values[:, self.names.index(name)]
        low, high = np.percentile(drawn, [50 * (1 - level), 50 * (1 + level)])
        return float(low), float(high)


def bootstrap(
    recordings: Sequence[Recording],
    mass: float | str = 0.0,
    motions: Sequence[Motion] | None = None,
    *,
    offsets: bool = False,
    runs: int = 2000,
    stretch: float | None = None,
    seed: int = 0,
) -> Bootstrap:
    """Draw the dispersion parameters `runs` times. `motions` replaces the measured motion; `stretch` in s. Raises `FitError` where the
    sessions are too short for it."""
    check_runs(runs)
    sessions, _ = prepare(recordings, motions)
    shape = shape_of(sessions, mass, offsets)
    regression, blocks = settled(sessions, shape)
    period = sessions[0].motion.dt * sessions[0].prefilter.every
    recorded = period * sum(b.y.size for b in blocks[0])
    length = max(2, round((stretch or recorded / STRETCHES) / period))
    white, gains = _white(blocks, regression), _gains(blocks, regression)
    if sum(w.size // length for w in white[0]) < FEWEST:
        raise FitError(f"stretches of {length * period:.3g} s are too long for these sessions: at least {FEWEST} must fit in")
    rng, to = np.random.default_rng(seed), theta_of(regression, shape)
    beta = np.concatenate(regression.coefficients)
    moves = np.array([_drawn(white, gains, length, rng) for _ in range(runs)])
    moves = (moves - moves.mean(axis=0)) * _growth(recorded / period / length, regression.coefficients, runs, rng)[:, None]
    values = np.array([to(beta + move) for move in moves])
    return Bootstrap((*NAMES, *(f"share_{i}" for i in shape.live)), values, length * period)


def check_runs(runs: int) -> None:
    """Raises `FitError` for so few samples that they have no interval, or so many that they take hours."""
    if runs < FEWEST_RUNS:
        raise FitError(f"{runs} bootstrap samples have no 95 % interval: draw at least {FEWEST_RUNS}, better 1000")
    if runs > MOST_RUNS:
        raise FitError(f"{runs} bootstrap samples take hours and tell no more than {MOST_RUNS}: draw 1000")


def _white(blocks: list[list[Block]], regression: Regression) -> list[list[np.ndarray]]:
    """Residuals through each channel's noise model, all channels equally long."""
    order = max(ar.size for ar in regression.ar)
    each = zip(blocks, regression.coefficients, regression.ar, strict=True)
    return [[whitened(b.y - b.columns @ c, ar)[order - ar.size :] for b in channel] for channel, c, ar in each]


def _gains(blocks: list[list[Block]], regression: Regression) -> list[list[np.ndarray]]:
    """How much the coefficients move with each sample of the whitened noise, which begins before the session: it has a memory."""
    each = zip(blocks, regression.inverses, regression.ar, strict=True)
    gains = [[coloured(b.gain(p), ar)[::-1] for b in channel] for channel, p, ar in each]
    longest = [max(len(g) for g in session) for session in zip(*gains, strict=True)]
    return [[np.pad(g, ((n - len(g), 0), (0, 0))) for g, n in zip(channel, longest, strict=True)] for channel in gains]


def _growth(stretches: float, coefficients: list[np.ndarray], runs: int, rng: np.random.Generator) -> np.ndarray:
    """What every drawing is multiplied by, (runs,).

    The fit has taken as many stretches' worth of noise out of the residual as a channel has coefficients, just where it matters; and how
    large the noise is is known from the rest only, so that the drawings are to spread as Student's t does.
    """
    free = max(1.0, stretches - max(c.size for c in coefficients))
    return np.sqrt(stretches / free) * np.sqrt(free / rng.chisquare(free, runs))


def _drawn(white: list[list[np.ndarray]], gains: list[list[np.ndarray]], length: int, rng: np.random.Generator) -> np.ndarray:
    """The change of all coefficients by one drawing: the same stretches for every channel."""
    sizes = [w.size for w in white[0]]
    picks = [_picked(sizes, len(g), length, rng) for g in gains[0]]
    whole = [np.concatenate(channel) for channel in white]
    return np.concatenate([sum(g.T @ w[p] for g, p in zip(channel, picks, strict=True)) for channel, w in zip(gains, whole, strict=True)])


def _picked(sizes: list[int], n: int, length: int, rng: np.random.Generator) -> np.ndarray:
    """Indices into the sessions laid end to end: random stretches, none across a border, n samples in all."""
    ends = np.cumsum(sizes)
    starts = np.concatenate([np.arange(end - size, end - length + 1) for end, size in zip(ends, sizes, strict=True)])
    drawn = rng.choice(starts, -(-n // length))
    return (drawn[:, None] + np.arange(length)).ravel()[:n]
