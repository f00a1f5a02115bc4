"""The noise of a recording: autoregressive, and correlated between channels.

A residual that is not white makes every test too sure of itself. The channels are first turned into uncorrelated mixtures (an encoder's
error reaches all of them and makes the strongest one; the eigenvectors of the residual's covariance); of each mixture that is taken away
which its own past predicts (see `predictor`). What correlation is left between the innovations goes by one covariance matrix. Where noise
grows with the load, everything is divided by what it grows to first (see `growth`). `Whitener.apply` turns residuals and directions alike
into samples of unit variance.

Source: L. Ljung, System Identification, 1999, ch. 4 (prediction-error filters).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular
from scipy.signal import freqz, lfilter

from skin_ident.criticism.noise.growth import Channels, Growth, growth
from skin_ident.criticism.noise.in_blocks import InBlocks
from skin_ident.criticism.noise.predictor import AVERAGING, MEMORIES, fit_predictor, whole
from skin_ident.stretches import runs

ORDERS = (8, 4, 2)
PER_COEFFICIENT = 10  # samples, the fewest that a coefficient is fitted to
EVERY = np.pi * (np.arange(4096) + 0.5) / 4096  # radians a sample, frequencies that stand for all
AT_ONCE = 32  # rows that are whitened together: more do not fit into a processor's cache
FLOOR = 1e-4  # of the variance, taken as white noise: the band's stop band must not be blown up


@dataclass(frozen=True)
class Whitener:
    """`mix` (C, C) makes uncorrelated mixtures of the channels, `filters` (C, p+1) are the prediction-error filters of their last samples,
    `slow` (C, M) their coefficients c_m, `root` (C, C) is the lower Cholesky factor of the innovations' covariance without load. `floor`
    (C, C) N^2 is the covariance of white noise that was taken to be there besides; None where nothing was fitted."""

    mix: np.ndarray
    filters: np.ndarray
    slow: np.ndarray
    root: np.ndarray
    growth: Growth
    floor: np.ndarray | None = None

    @property
    def order(self) -> int:
        """Of the filters of the last samples, p."""
        return self.filters.shape[1] - 1

    @cached_property
    def to_unit(self) -> np.ndarray:
        """What makes innovations (C, n) independent and of unit variance, (C, C)."""
        return solve_triangular(self.root, np.eye(len(self.root)), lower=True)

    def apply(self, e: np.ndarray, s: Channels, out: np.ndarray | None = None) -> np.ndarray:
        """Whiten (..., C, n) of a session, in the precision that comes in, into `out` where it is given. Samples that a channel or its
        neighbourhood spoils, and the first p, come back as zeros."""
        if not e.size:
            return e
        to_unit, mix, believed = (a.astype(e.dtype, copy=False) for a in (self.to_unit, self.mix, self.believed(s)))
        if not self.filters[:, 1:].any():  # white: one product does it all
            return np.multiply(np.matmul(to_unit @ mix, self.steady(e, s), out), believed, out)
        mixed = np.matmul(mix, e * self._quieter(s).astype(e.dtype, copy=False))
        for c, blocks in enumerate(self._in_blocks):
            np.multiply(blocks.apply(mixed[..., c, :]), believed, out=mixed[..., c, :])
        return np.matmul(to_unit, mixed, out)

    def steady(self, e: np.ndarray, s: Channels) -> np.ndarray:
        """(..., C, n) over how loud the noise of the session is, in the precision that comes in."""
        return e / self.growth.loudness(s).astype(e.dtype) if self.growth.is_any else e

    def words(self, sessions: list[Channels]) -> float:
        """What it takes to say the innovations of these sessions: their number times log |R|, the logarithms of all loudness, and what
        grows, nats."""
        good = [s.weight.min(axis=0) > 0.0 for s in sessions]
        louder = sum(float(np.sum(np.log(self.growth.loudness(s)[:, g]))) for s, g in zip(sessions, good, strict=True))
        count = sum(map(np.count_nonzero, good))
        charge = 0.5 * np.count_nonzero(self.growth.more) * np.log(max(count, 2))
        return count * float(np.sum(np.log(np.diag(self.root)))) + louder + float(charge)

    def predictor(self, c: int) -> tuple[np.ndarray, np.ndarray]:
        """Numerator and denominator of the filter that leaves of mixture `c` what its past does not predict. Samples that are left out are
        zeros to it: the averages take no notice of them, and those behind them, of which the last p samples are wrong, are not believed."""
        return whole(self.filters[c], self.slow[c]), AVERAGING

    @cached_property
    def _in_blocks(self) -> list[InBlocks]:
        """The same, of every mixture, for many rows at once."""
        return [InBlocks(f, c) for f, c in zip(self.filters, self.slow, strict=True)]

    def averaged(self, samples: int) -> np.ndarray:
        """The standard deviation (C,) of an average of so many samples of each channel without load, N: by the noise's spectrum."""
        kept = (np.sin(0.5 * samples * EVERY) / (samples * np.sin(0.5 * EVERY))) ** 2
        return np.sqrt(np.mean(self._spectrum() * kept, axis=1))

    def lasting(self) -> np.ndarray:
        """By how many times fewer samples of each channel (C,) count, of how loud they are, for being correlated: the sum of rho^2 over all
        lags, which is the mean square of the spectrum over the square of its mean."""
        spectrum = self._spectrum()
        return np.mean(spectrum**2, axis=1) / np.mean(spectrum, axis=1) ** 2

    def _spectrum(self) -> np.ndarray:
        """The power of every channel without load at frequencies `EVERY`, (C, F) N^2: its mean is the variance."""
        predicted = np.array([freqz(*self.predictor(c), EVERY)[1] for c in range(len(self.mix))])
        return np.sum(np.abs(np.einsum("ci,cf,cj->ijf", self.mix, 1.0 / predicted, self.root)) ** 2, axis=1)

    def turned(self, w: np.ndarray, s: Channels) -> np.ndarray:
        """The adjoint of `apply` on (C, n): sum of apply(e) * w = sum of e * turned(w)."""
        good = (s.weight.min(axis=0) > 0.0)[::-1]
        back = (self.to_unit.T @ w * self.believed(s))[:, ::-1]
        mixed = np.array([lfilter(*self.predictor(c), row) for c, row in enumerate(back)]) * good
        return self.steady(self.mix.T @ mixed[:, ::-1], s)

    def believed(self, s: Channels) -> np.ndarray:
        """Mask (n,) of the samples that `apply` does not leave out, as 0 and 1."""

        def work() -> np.ndarray:
            believed = lfilter(np.ones(self.order + 1), [1.0], 1.0 - s.weight.min(axis=0)) < 0.5
            believed[: self.order] = False
            return believed.astype(float)

        return self._once("believed", s, work)

    def _quieter(self, s: Channels) -> np.ndarray:
        """What makes a session as quiet as without load, (C, n), and nothing of samples that one of its channels spoils."""
        return self._once("quieter", s, lambda: (s.weight.min(axis=0) > 0.0) / self.growth.loudness(s))

    def _once(self, what: str, s: Channels, work: Callable[[], np.ndarray]) -> np.ndarray:
        """What is the same as long as the weights of a session are, worked out once."""
        weight, known = self._known.get((what, id(s.weight)), (None, None))
        if weight is not s.weight:
            known = work()
            self._known[what, id(s.weight)] = s.weight, known
        return known

    @cached_property
    def _known(self) -> dict[tuple[str, int], tuple[np.ndarray, np.ndarray]]:
        return {}


@dataclass(frozen=True)
class Given:
    """What of a noise model is given, and not fitted: the `order` of the filters, else the highest that the residuals bear; how the noise
    `grows` with the load, else not at all; the `mix` (C, C), else that which makes the channels uncorrelated; and the `floor` (C, C) N^2.
    That is given where the words of two noise models are compared: one that falls with what is taken out would shorten them."""

    order: int | None = None
    grows: Growth | None = None
    mix: np.ndarray | None = None
    floor: np.ndarray | None = None


NOTHING = Given()


def fit_whitener(
    residuals: list[np.ndarray], sessions: list[Channels], taken: np.ndarray | None = None, given: Given = NOTHING
) -> Whitener:
    """The noise model of residuals [(C, n), …], N, from each channel of which what was fitted and subtracted has `taken` so many degrees of
    freedom (2, C), in all and at the lowest frequencies."""
    n_channels, together = len(residuals[0]), [s.weight.min(axis=0) for s in sessions]
    order = order_for([s.weight for s in sessions]) if given.order is None else given.order
    grows = given.grows or Growth.none(n_channels)
    begun = Whitener(np.eye(n_channels), np.ones((n_channels, 1)), np.zeros((n_channels, MEMORIES.size)), np.eye(n_channels), grows)
    steady = [begun.steady(e, s) for e, s in zip(residuals, sessions, strict=True)]
    kept = np.concatenate([e[:, w > 0] for e, w in zip(steady, together, strict=True)], axis=1)
    energy = np.atleast_2d(kept @ kept.T / max(kept.shape[1], 1))
    floor = FLOOR * energy if given.floor is None else given.floor
    mix = np.linalg.eigh(energy)[1].T if given.mix is None else given.mix
    mixed, guard = [mix @ e for e in steady], np.diag(mix @ floor @ mix.T)
    unseen = np.zeros((2, n_channels)) if taken is None else taken @ mix.T**2
    fitted = (fit_predictor([m[c] for m in mixed], together, order, unseen[:, c], guard[c]) for c in range(n_channels))
    filters, slow = zip(*fitted, strict=True)
    unit = replace(begun, mix=mix, filters=np.array(filters), slow=np.array(slow), floor=floor)
    return replace(unit, root=_root(np.concatenate([unit.apply(e, s) for e, s in zip(residuals, sessions, strict=True)], axis=1)))


def _root(w: np.ndarray) -> np.ndarray:
    """The lower Cholesky factor (C, C) of the covariance of innovations (C, n), of which zeros are none. A constant channel is given a tiny
    one, so that nothing divides by zero."""
    used = np.any(w != 0.0, axis=0)
    covariance = np.atleast_2d(w[:, used] @ w[:, used].T / max(used.sum(), 1))
    tiny = np.diag(np.full(len(w), 1e-18) + 1e-6 * np.diag(covariance))
    return np.linalg.cholesky(covariance + tiny)


def with_growth(steady: Whitener, residuals: list[np.ndarray], sessions: list[Channels], taken: np.ndarray | None = None) -> Whitener:
    """The noise model that was fitted to residuals [(C, n), …], N, as if their noise were `steady`, fitted again as it grows with the load,
    where it does. Not of what a wrong model leaves: its errors grow with the load, too."""
    apart = [steady.mix.T @ steady.root @ steady.apply(e, s) for e, s in zip(residuals, sessions, strict=True)]  # by channel, N
    grows = growth(apart, sessions)
    given = Given(steady.order, grows, floor=steady.floor)
    return fit_whitener(residuals, sessions, taken, given) if grows.is_any else steady


def order_for(weights: list[np.ndarray]) -> int:
    """The highest order of filters that has, by `weights` (C, n) of each session, samples enough for each coefficient, away from gaps and
    from what filters spoil behind them; 0, and noise is taken as white, where none has."""
    pieces = np.concatenate([np.subtract(*reversed(runs(w.min(axis=0) > 0.0))) for w in weights])

    def enough(order: int) -> bool:
        return np.maximum(pieces - 2 * order, 0).sum() >= PER_COEFFICIENT * (order + MEMORIES.size)

    return next((order for order in ORDERS if enough(order)), 0)


def white(residuals: list[np.ndarray], order: int = ORDERS[0], weights: list[np.ndarray] | None = None) -> Whitener:
    """White noise, independent in each channel, of the size that neighbouring samples of the residuals (C, n) differ by: of those that are
    believed, where `weights` (C, n) are given."""
    steps = np.concatenate([np.diff(e, axis=1) for e in residuals], axis=1)
    known = np.concatenate([w[:, 1:] * w[:, :-1] > 0.0 for w in weights], axis=1) if weights else np.ones(steps.shape, bool)
    size = np.sqrt((steps**2 * known).sum(axis=1) / np.maximum(2.0 * known.sum(axis=1), 1.0))
    n = size.size
    root = np.diag(np.maximum(size, 1e-12))
    return Whitener(np.eye(n), np.eye(1, order + 1).repeat(n, axis=0), np.zeros((n, MEMORIES.size)), root, Growth.none(n))


def stack(rows: list[np.ndarray], sessions: list, noise: Whitener, out: np.ndarray | None = None) -> np.ndarray:
    """Whiten [(M, C, n), …] or [(C, n), …] over sessions and lay them out as (rows, M), in `out` where it is given, or (rows,)."""
    if rows[0].ndim == 2:
        return np.concatenate([noise.apply(a, s).ravel() for a, s in zip(rows, sessions, strict=True)])
    ends = np.cumsum([0, *(a.shape[1] * a.shape[2] for a in rows)])
    out = np.empty((len(rows[0]), ends[-1])) if out is None else out.T
    for a, s, start, end in zip(rows, sessions, ends[:-1], ends[1:], strict=True):
        for few in range(0, len(a), AT_ONCE):
            some = a[few : few + AT_ONCE]
            noise.apply(some, s, out[few : few + AT_ONCE, start:end].reshape(some.shape))
    return out.T


class Stacked:
    """Rows (M, C, n) of each session, laid out under one noise model after the other: not twice under the same, and always in the same
    memory, for they are large. What was laid out under another noise model before is overwritten."""

    def __init__(self, rows: list[np.ndarray], sessions: list) -> None:
        self.rows, self.sessions = rows, sessions
        self._last: tuple[Whitener, np.ndarray] | None = None

    def under(self, noise: Whitener) -> np.ndarray:
        """What `stack` makes of them, (rows, M)."""
        if self._last is None or self._last[0] is not noise:
            self._last = noise, stack(self.rows, self.sessions, noise, self._last[1] if self._last else None)
        return self._last[1]
