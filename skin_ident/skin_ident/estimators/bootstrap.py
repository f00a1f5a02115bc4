"""Bootstrap intervals, for noise that is neither normal nor of constant level: blocks ("stretches") of the residual, all channels together,
are resampled.

The fit is linear in the measurement, so a resampled residual e* moves the coefficients by G' e*. No refit is needed; shares, differences
and ratios are formed afterwards. Noise with a correlation longer than a stretch would come out too small. So the residual is whitened by
each channel's noise model, stretches of the whitened residual are drawn, and the noise model colours them again. By default a stretch is a
thirtieth of what was recorded. The mean of all draws is subtracted, since it is no scatter, and the draws are widened because there are so
few stretches.
Source: H. R. Künsch, Ann. Statist. 17 (1989) 1217; whitening before, D. W. K. Andrews, J. C. Monahan, Econometrica 60 (1992) 953.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skin_ident.estimators.dispersion import shape_of, theta_of, within_bounds
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.noise import coloured
from skin_ident.estimators.regression import Block, Regression
from skin_ident.estimators.sessions import prepare
from skin_ident.estimators.transfer_data import whitened
from skin_ident.recordings.recording import Recording
from skin_models.signals import Motion

NAMES = ("m", "b1", "k1", "b2", "k2")
FEWEST = 4  # stretches that must fit into all sessions together
STRETCHES = 30  # stretches in what was recorded, by default
FEWEST_RUNS, MOST_RUNS = 40, 100_000  # draws


@dataclass(frozen=True, eq=False)
class Bootstrap:
    """Resampled parameters `values` (runs, P), in the order of `names`; `stretch` is the length of a block, s."""

    names: tuple[str, ...]
    values: np.ndarray
    stretch: float

    def interval(self, name: str, level: float = 0.95) -> tuple[float, float]:
        """The percentile interval of a parameter, SI: it holds the middle share `level` of the draws."""
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
    """Resample the parameters of `fit_dispersion` `runs` times. `motions` replaces the measured motion; `stretch` is in s. Raises
    `FitError` where the sessions are too short for such stretches."""
    check_runs(runs)
    sessions, _ = prepare(recordings, motions)
    shape, _, (regression, blocks), _ = within_bounds(sessions, shape_of(sessions, mass, offsets))
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
    """Raises `FitError` for too few draws to give an interval, or so many that they take hours."""
    if runs < FEWEST_RUNS:
        raise FitError(f"{runs} bootstrap samples have no 95 % interval: draw at least {FEWEST_RUNS}, better 1000")
    if runs > MOST_RUNS:
        raise FitError(f"{runs} bootstrap samples take hours and tell no more than {MOST_RUNS}: draw 1000")


def _white(blocks: list[list[Block]], regression: Regression) -> list[list[np.ndarray]]:
    """Residuals whitened by each channel's noise model, cut so that all channels are equally long."""
    order = max(ar.size for ar in regression.ar)
    each = zip(blocks, regression.coefficients, regression.ar, strict=True)
    return [[whitened(b.y - b.columns @ c, ar)[order - ar.size :] for b in channel] for channel, c, ar in each]


def _gains(blocks: list[list[Block]], regression: Regression) -> list[list[np.ndarray]]:
    """The change of the coefficients per sample of the whitened noise. It begins before the session, because earlier noise still acts in
    it."""
    each = zip(blocks, regression.inverses, regression.ar, strict=True)
    gains = [[coloured(b.gain(p), ar)[::-1] for b in channel] for channel, p, ar in each]
    longest = [max(len(g) for g in session) for session in zip(*gains, strict=True)]
    return [[np.pad(g, ((n - len(g), 0), (0, 0))) for g, n in zip(channel, longest, strict=True)] for channel in gains]


def _growth(stretches: float, coefficients: list[np.ndarray], runs: int, rng: np.random.Generator) -> np.ndarray:
    """Factors (runs,) by which the draws are multiplied.

    The fit has removed as many stretches' worth of noise from the residual as a channel has coefficients, and in the directions that
    matter. The level of the noise is known only from the remaining ones, so that the draws must scatter as Student's t does.
    """
    free = max(1.0, stretches - max(c.size for c in coefficients))
    return np.sqrt(stretches / free) * np.sqrt(free / rng.chisquare(free, runs))


def _drawn(white: list[list[np.ndarray]], gains: list[list[np.ndarray]], length: int, rng: np.random.Generator) -> np.ndarray:
    """The change of all coefficients by one draw, with the same stretches for every channel."""
    sizes = [w.size for w in white[0]]
    picks = [_picked(sizes, len(g), length, rng) for g in gains[0]]
    whole = [np.concatenate(channel) for channel in white]
    return np.concatenate([sum(g.T @ w[p] for g, p in zip(channel, picks, strict=True)) for channel, w in zip(gains, whole, strict=True)])


def _picked(sizes: list[int], n: int, length: int, rng: np.random.Generator) -> np.ndarray:
    """Indices into the concatenated sessions: n samples in random stretches, none across the border of a session."""
    ends = np.cumsum(sizes)
    starts = np.concatenate([np.arange(end - size, end - length + 1) for end, size in zip(ends, sizes, strict=True)])
    drawn = rng.choice(starts, -(-n // length))
    return (drawn[:, None] + np.arange(length)).ravel()[:n]
