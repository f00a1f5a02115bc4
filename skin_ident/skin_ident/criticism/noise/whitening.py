"""The noise of a recording as a whitening filter: autoregressive, and correlated between channels.

A coloured residual makes every test too sure of itself. Whitening takes four steps:

- Where noise grows with the load, everything is divided by the growth (see `growth`).
- The channels are turned into uncorrelated mixtures, the eigenvectors of the residual's covariance. An encoder's error reaches all channels
  and makes the strongest mixture.
- From each mixture the part that its own past predicts is subtracted (see `predictor`).
- One covariance matrix removes the correlation that is left between the innovations.

`Whitener.apply` turns residuals and directions alike into samples of unit variance.

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

ORDERS = (8, 4, 2)  # orders p of the filters, the highest that the data bear is used
PER_COEFFICIENT = 10  # fewest samples for each fitted coefficient
EVERY = np.pi * (np.arange(4096) + 0.5) / 4096  # radians a sample, the frequencies at which spectra are averaged
AT_ONCE = 32  # rows that are whitened together: more do not fit into a processor's cache
SILENT = 0.01  # N, noise of a channel that leaves no residual at all
FLOOR = 1e-4  # share of the variance that is added as white noise, so that whitening does not blow up the band's stop band


@dataclass(frozen=True)
class Whitener:
    """A noise model. `mix` (C, C) makes uncorrelated mixtures of the channels. `filters` (C, p+1) are the prediction-error filters on their
    last samples, `slow` (C, M) the coefficients c_m of their averages. `root` (C, C) is the lower Cholesky factor of the innovations'
    covariance without load. `floor` (C, C) N^2 is the covariance of the white noise added in the fit; None where nothing was fitted."""

    mix: np.ndarray
    filters: np.ndarray
    slow: np.ndarray
    root: np.ndarray
    growth: Growth
    floor: np.ndarray | None = None

    @property
    def order(self) -> int:
        """Order p of the filters on the last samples."""
        return self.filters.shape[1] - 1

    @cached_property
    def to_unit(self) -> np.ndarray:
        """Matrix (C, C) that makes innovations (C, n) independent and of unit variance."""
        return solve_triangular(self.root, np.eye(len(self.root)), lower=True)

    def apply(self, e: np.ndarray, s: Channels, out: np.ndarray | None = None) -> np.ndarray:
        """Whitens (..., C, n) of a session, in the precision that comes in, into `out` where it is given. The first p samples, and samples
        where any channel has a bad sample at that time or up to p samples before, come back as zeros."""
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
        """(..., C, n) divided by the loudness of the session's noise, in the precision that comes in."""
        return e / self.growth.loudness(s).astype(e.dtype) if self.growth.is_any else e

    def words(self, sessions: list[Channels]) -> float:
        """Description length, nats, of the innovations of these sessions: their number times log |R|, plus the sum of log loudness, plus
        half a log of the number of samples for each channel whose noise grows. Samples that the filter drops at its start count, too:
        models of different orders describe the same samples."""
        good = [s.weight.min(axis=0) > 0.0 for s in sessions]
        louder = sum(float(np.sum(np.log(self.growth.loudness(s)[:, g]))) for s, g in zip(sessions, good, strict=True))
        count = sum(map(np.count_nonzero, good))
        charge = 0.5 * np.count_nonzero(self.growth.more) * np.log(max(count, 2))
        return count * float(np.sum(np.log(np.diag(self.root)))) + louder + float(charge)

    def predictor(self, c: int) -> tuple[np.ndarray, np.ndarray]:
        """Numerator and denominator of the prediction-error filter of mixture `c`. Left-out samples enter as zeros, which adds nothing to
        the averages; the p samples after them, whose last samples are wrong, are not trusted."""
        return whole(self.filters[c], self.slow[c]), AVERAGING

    @cached_property
    def _in_blocks(self) -> list[InBlocks]:
        """The same filters for all mixtures, in a form that is fast for many rows."""
        return [InBlocks(f, c) for f, c in zip(self.filters, self.slow, strict=True)]

    def averaged(self, samples: int) -> np.ndarray:
        """Standard deviation (C,), N, of the mean of that many successive samples of each channel without load, from the noise's
        spectrum."""
        kept = (np.sin(0.5 * samples * EVERY) / (samples * np.sin(0.5 * EVERY))) ** 2
        return np.sqrt(np.mean(self._spectrum() * kept, axis=1))

    def lasting(self) -> np.ndarray:
        """The factor (C,) by which correlation reduces the number of samples that count towards the noise level of each channel: the sum of
        rho^2 over all lags, which is the mean of the squared spectrum over the square of its mean."""
        spectrum = self._spectrum()
        return np.mean(spectrum**2, axis=1) / np.mean(spectrum, axis=1) ** 2

    def _spectrum(self) -> np.ndarray:
        """Power spectrum of every channel without load at the frequencies `EVERY`, (C, F) N^2; its mean is the variance."""
        predicted = np.array([freqz(*self.predictor(c), EVERY)[1] for c in range(len(self.mix))])
        return np.sum(np.abs(np.einsum("ci,cf,cj->ijf", self.mix, 1.0 / predicted, self.root)) ** 2, axis=1)

    def turned(self, w: np.ndarray, s: Channels) -> np.ndarray:
        """The adjoint of `apply` on (C, n): sum of apply(e) * w = sum of e * turned(w)."""
        good = (s.weight.min(axis=0) > 0.0)[::-1]
        back = (self.to_unit.T @ w * self.believed(s))[:, ::-1]
        mixed = np.array([lfilter(*self.predictor(c), row) for c, row in enumerate(back)]) * good
        return self.steady(self.mix.T @ mixed[:, ::-1], s)

    def believed(self, s: Channels) -> np.ndarray:
        """Mask (n,) as 0 and 1 of the samples that `apply` does not set to zero."""

        def work() -> np.ndarray:
            believed = lfilter(np.ones(self.order + 1), [1.0], 1.0 - s.weight.min(axis=0)) < 0.5
            believed[: self.order] = False
            return believed.astype(float)

        return self._once("believed", s, work)

    def _quieter(self, s: Channels) -> np.ndarray:
        """The factor (C, n) that divides by the loudness, and is 0 where any channel is not trusted."""
        return self._once("quieter", s, lambda: (s.weight.min(axis=0) > 0.0) / self.growth.loudness(s))

    def _once(self, what: str, s: Channels, work: Callable[[], np.ndarray]) -> np.ndarray:
        """The result of `work`, computed once for each session and kept as long as the session's weights are the same array."""
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
    """What of a noise model is fixed and not fitted, each with its default: the `order` of the filters (the highest that the data bear),
    how the noise `grows` with the load (not at all), the `mix` (C, C) (the one that makes the channels uncorrelated), and the `floor` (C,
    C) N^2 (a share of the residual's own covariance). Fix the floor where description lengths of two noise models are compared: a floor
    that falls with the residual would shorten them."""

    order: int | None = None
    grows: Growth | None = None
    mix: np.ndarray | None = None
    floor: np.ndarray | None = None


NOTHING = Given()


def fit_whitener(
    residuals: list[np.ndarray], sessions: list[Channels], taken: np.ndarray | None = None, given: Given = NOTHING
) -> Whitener:
    """Fits the noise model to residuals [(C, n), …], N. `taken` (2, C) are the degrees of freedom that fitted and subtracted directions
    have removed from each channel, in all and at the lowest frequencies."""
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
    """Lower Cholesky factor (C, C) of the covariance of innovations (C, n); samples that are zero in all channels do not count. A channel
    without any residual, which is a silent one, is taken to have noise of `SILENT`: with none, all others would weigh nothing beside it
    wherever it does not read what it did."""
    used = np.any(w != 0.0, axis=0)
    covariance = np.atleast_2d(w[:, used] @ w[:, used].T / max(used.sum(), 1))
    power = np.diag(covariance)
    added = np.where(power > 0.0, 1e-18 + 1e-6 * power, SILENT**2)
    return np.linalg.cholesky(covariance + np.diag(added))


def with_growth(steady: Whitener, residuals: list[np.ndarray], sessions: list[Channels], taken: np.ndarray | None = None) -> Whitener:
    """The noise model `steady`, refitted with noise that grows with the load if its innovations show such growth; else `steady` itself. Use
    it only on residuals [(C, n), …], N, of a model that fits: the errors of a wrong model grow with the load, too."""
    apart = [steady.mix.T @ steady.root @ steady.apply(e, s) for e, s in zip(residuals, sessions, strict=True)]  # innovations by channel, N
    grows = growth(apart, sessions)
    given = Given(steady.order, grows, floor=steady.floor)
    return fit_whitener(residuals, sessions, taken, given) if grows.is_any else steady


def order_for(weights: list[np.ndarray]) -> int:
    """The highest filter order with enough samples for each coefficient, counted by `weights` (C, n) away from gaps and from the samples
    after them that the filter spoils. 0, which takes the noise as white, if no order has enough."""
    pieces = np.concatenate([np.subtract(*reversed(runs(w.min(axis=0) > 0.0))) for w in weights])

    def enough(order: int) -> bool:
        return np.maximum(pieces - 2 * order, 0).sum() >= PER_COEFFICIENT * (order + MEMORIES.size)

    return next((order for order in ORDERS if enough(order)), 0)


def white(residuals: list[np.ndarray], order: int = ORDERS[0], weights: list[np.ndarray] | None = None) -> Whitener:
    """White noise, independent in each channel, with the size of the differences between neighbouring samples of the residuals (C, n). Only
    samples with positive weight count where `weights` (C, n) are given."""
    steps = np.concatenate([np.diff(e, axis=1) for e in residuals], axis=1)
    known = np.concatenate([w[:, 1:] * w[:, :-1] > 0.0 for w in weights], axis=1) if weights else np.ones(steps.shape, bool)
    size = np.sqrt((steps**2 * known).sum(axis=1) / np.maximum(2.0 * known.sum(axis=1), 1.0))
    n = size.size
    root = np.diag(np.maximum(size, 1e-12))
    return Whitener(np.eye(n), np.eye(1, order + 1).repeat(n, axis=0), np.zeros((n, MEMORIES.size)), root, Growth.none(n))


def stack(rows: list[np.ndarray], sessions: list, noise: Whitener, out: np.ndarray | None = None) -> np.ndarray:
    """Whitens [(M, C, n), …] or [(C, n), …] over sessions and lays the result out as (rows, M), in `out` where it is given, or as
    (rows,)."""
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
    """Directions (M, C, n) of each session, whitened and stacked under one noise model after the other. They are large: the result is kept
    for the last noise model, and the next one overwrites the same memory."""

    def __init__(self, rows: list[np.ndarray], sessions: list) -> None:
        self.rows, self.sessions = rows, sessions
        self._last: tuple[Whitener, np.ndarray] | None = None

    def under(self, noise: Whitener) -> np.ndarray:
        """The directions under `noise` as `stack` lays them out, (rows, M)."""
        if self._last is None or self._last[0] is not noise:
            self._last = noise, stack(self.rows, self.sessions, noise, self._last[1] if self._last else None)
        return self._last[1]
