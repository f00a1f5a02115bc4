"""The noise of a recording: autoregressive, and correlated between channels.

A residual that is not white makes every test too sure of itself. The channels are first turned into uncorrelated mixtures (an encoder's
error reaches all of them and makes the strongest one; the eigenvectors of the residual's covariance); the noise of each mixture is
predicted from its last p samples and from M exponential averages, slower and slower,

    e[n] = a_1 e[n-1] + … + a_p e[n-p] + c_1 s_1[n] + … + c_M s_M[n] + w[n],    s_m[n] = (1 - 1/T_m) s_m[n-1] + e[n-1] / T_m,

fitted by least squares over all sessions: without the averages, noise that wanders would be white to a test at all but the lowest
frequencies, and slow causes would be named for it. What correlation is left between the innovations w goes by one covariance matrix.
Where noise grows with the load, everything is divided by what it grows to first (see `growth`). `Whitener.apply` turns residuals and
directions alike into samples of unit variance.

What was fitted to a residual and subtracted has taken noise with it, most of all at the lowest frequencies (see `taken`). A fit to what is
left would think the noise silent there, and every offset and drift would seem certain. The least squares are therefore completed by as
many oscillations as were taken below w_c, as loud as the noise is between w_c and 2 w_c (the geometric mean of its spectrum there).

Sources: L. Ljung, System Identification, 1999, ch. 4 (prediction-error filters); F. Corsi, J. Financial Econometrics 7 (2009) 174-196 (long
memory by averages over a few times); H. D. Patterson and R. Thompson, Biometrika 58 (1971) 545-554 (what regression takes from the noise
has to be given back to it).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular
from scipy.signal import freqz, lfilter

from skin_ident.criticism.noise.growth import Channels, Growth, growth
from skin_ident.stretches import runs

ORDERS = (8, 4, 2)
PER_COEFFICIENT = 10  # samples, the fewest that a coefficient is fitted to
MEMORIES = np.array([10.0, 30.0, 100.0, 300.0])  # T_m, samples
POLES = 1.0 - 1.0 / MEMORIES
AVERAGING = np.poly(POLES)  # the common denominator of all averages, and the numerator that each has over it
EACH = np.array([np.poly(np.delete(POLES, m)) / memory for m, memory in enumerate(MEMORIES)])
FINE = 32  # frequencies that stand for a band
EVERY = np.pi * (np.arange(4096) + 0.5) / 4096  # radians a sample, frequencies that stand for all
AT_ONCE = 32  # rows that are whitened together: more do not fit into a processor's cache
FLOOR = 1e-4  # of the variance, added as white noise: the band's stop band must not be blown up


@dataclass(frozen=True)
class Whitener:
    """`mix` (C, C) makes uncorrelated mixtures of the channels, `filters` (C, p+1) are the prediction-error filters of their last samples,
    `slow` (C, M) their coefficients c_m, `root` (C, C) is the lower Cholesky factor of the innovations' covariance without load."""

    mix: np.ndarray
    filters: np.ndarray
    slow: np.ndarray
    root: np.ndarray
    growth: Growth

    @property
    def order(self) -> int:
        """Of the filters of the last samples, p."""
        return self.filters.shape[1] - 1

    @property
    def to_unit(self) -> np.ndarray:
        """What makes innovations (C, n) independent and of unit variance, (C, C)."""
        return solve_triangular(self.root, np.eye(len(self.root)), lower=True)

    def apply(self, e: np.ndarray, s: Channels) -> np.ndarray:
        """Whiten (..., C, n) of a session, in the precision that comes in. Samples that a channel or its neighbourhood spoils, and the
        first p, come back as zeros."""
        if not e.size:
            return e
        to_unit, mix, believed = (a.astype(e.dtype) for a in (self.to_unit, self.mix, self.believed(s)))
        e = self.steady(e, s)
        if not self.filters[:, 1:].any():  # white: one product does it all
            return np.matmul(to_unit @ mix, e) * believed
        mixed = np.matmul(mix, e * (s.weight.min(axis=0) > 0.0))
        for c in range(len(mix)):
            mixed[..., c, :] = lfilter(*self.predictor(c), mixed[..., c, :], axis=-1)
        mixed *= believed
        return np.matmul(to_unit, mixed)

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
        averages = self.slow[c] @ EACH
        whole = np.convolve(self.filters[c], AVERAGING)
        whole[1 : 1 + averages.size] -= averages
        return whole, AVERAGING

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
        """Mask (n,) of the samples that `apply` does not leave out."""
        believed = lfilter(np.ones(self.order + 1), [1.0], 1.0 - s.weight.min(axis=0)) < 0.5
        believed[: self.order] = False
        return believed


def fit_whitener(
    residuals: list[np.ndarray],
    sessions: list[Channels],
    taken: np.ndarray | None = None,
    order: int | None = None,
    grows: Growth | None = None,
) -> Whitener:
    """The noise model of residuals [(C, n), …], from each channel of which what was fitted and subtracted has `taken` so many degrees of
    freedom (2, C), in all and at the lowest frequencies; of the highest `order` that they bear, unless it is given. The noise `grows` so
    with the load, or is steady. Constant channels are given a tiny floor so that nothing divides by zero."""
    n_channels, order = residuals[0].shape[0], order_for([s.weight for s in sessions]) if order is None else order
    grows = grows or Growth.none(n_channels)
    begun = Whitener(np.eye(n_channels), np.ones((n_channels, 1)), np.zeros((n_channels, MEMORIES.size)), np.eye(n_channels), grows)
    steady, weights = [begun.steady(e, s) for e, s in zip(residuals, sessions, strict=True)], [s.weight for s in sessions]
    kept = np.concatenate([e[:, w.min(axis=0) > 0] for e, w in zip(steady, weights, strict=True)], axis=1)
    _, vectors = np.linalg.eigh(np.atleast_2d(kept @ kept.T / max(kept.shape[1], 1)))
    mixed = [vectors.T @ e for e in steady]
    together = [w.min(axis=0) for w in weights]
    unseen = np.zeros((2, n_channels)) if taken is None else taken @ vectors**2
    filters, slow = zip(*(_predictor([m[c] for m in mixed], together, order, unseen[:, c]) for c in range(n_channels)), strict=True)
    unit = replace(begun, mix=vectors.T, filters=np.array(filters), slow=np.array(slow))
    w = np.concatenate([unit.apply(e, s) for e, s in zip(residuals, sessions, strict=True)], axis=1)
    used = np.any(w != 0.0, axis=0)
    covariance = np.atleast_2d(w[:, used] @ w[:, used].T / max(used.sum(), 1))
    floor = np.diag(np.full(n_channels, 1e-18) + 1e-6 * np.diag(covariance))
    return replace(unit, root=np.linalg.cholesky(covariance + floor))


def with_growth(steady: Whitener, residuals: list[np.ndarray], sessions: list[Channels], taken: np.ndarray | None = None) -> Whitener:
    """The noise model that was fitted to residuals as if their noise were `steady`, fitted again as it grows with the load, where it does.
    Not of what a wrong model leaves: its errors grow with the load, too."""
    apart = [steady.mix.T @ steady.root @ steady.apply(e, s) for e, s in zip(residuals, sessions, strict=True)]  # by channel, N
    grows = growth(apart, sessions)
    return fit_whitener(residuals, sessions, taken, steady.order, grows) if grows.is_any else steady


def order_for(weights: list[np.ndarray]) -> int:
    """The highest order of filters that has samples enough for each coefficient, away from gaps and from what filters spoil behind them; 0,
    and noise is taken as white, where none has."""
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


def _predictor(rows: list[np.ndarray], weights: list[np.ndarray], order: int, unseen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The prediction-error filter (p+1,) and the coefficients of the averages (M,) for one mixture, from all sessions together."""
    if not order:
        return np.ones(1), np.zeros(MEMORIES.size)
    past = [np.lib.stride_tricks.sliding_window_view(r, order + 1) for r in rows]
    good = [np.lib.stride_tricks.sliding_window_view(w, order + 1).all(axis=1) for w in weights]
    slow = [
        np.array([lfilter([0.0, 1.0 / T], [1.0, 1.0 / T - 1.0], r * (w > 0.0)) for T in MEMORIES])[:, order:].T
        for r, w in zip(rows, weights, strict=True)
    ]
    lags, averages = (np.concatenate([x[g] for x, g in zip(xs, good, strict=True)]) for xs in (past, slow))
    X = np.concatenate([lags[:, :order], averages], axis=1)
    gram, size = X.T @ X, float(np.sum(lags[:, :order] ** 2)) / order
    gram += np.diag(FLOOR * size * np.concatenate([np.ones(order), 1.0 / (2.0 * MEMORIES - 1.0)]) + 1e-30)  # as white noise would add
    product = X.T @ lags[:, order]
    a = np.linalg.solve(gram, product)
    if unseen[1] > 0.0:
        more, told = _given_back(a, np.mean((lags[:, order] - X @ a) ** 2), unseen[1], np.pi * unseen[0] / len(X))
        a = np.linalg.solve(gram + more, product + told)
    return np.concatenate([[1.0], -a[:order][::-1]]), a[order:]


def _given_back(a: np.ndarray, innovation: float, taken: float, edge: float) -> tuple[np.ndarray, np.ndarray]:
    """What `taken` oscillations below `edge`, as loud as noise of this predictor is between that and twice as much, add to the normal
    equations: to their matrix (p+M, p+M) and to their right side (p+M,)."""
    order = a.size - MEMORIES.size
    below, above = (_past(edge * (span + np.arange(FINE) / FINE), order) for span in (0.5 / FINE, 1.0))
    loud = innovation * np.exp(-2.0 * np.mean(np.log(np.abs(1.0 - a @ above))))
    each = taken * loud / FINE
    return each * (below @ below.conj().T).real, each * below.sum(axis=1).real


def _past(w: np.ndarray, order: int) -> np.ndarray:
    """What last samples and averages are of an oscillation of one, (p+M, F), at angular frequencies `w` (F,) in radians a sample."""
    z = np.exp(-1j * w)
    return np.concatenate([z ** np.arange(order, 0, -1)[:, None], z / (MEMORIES[:, None] * (1.0 - POLES[:, None] * z))])


def stack(rows: list[np.ndarray], sessions: list, noise: Whitener, out: np.ndarray | None = None) -> np.ndarray:
    """Whiten [(M, C, n), …] or [(C, n), …] over sessions and lay them out as (rows, M), in `out` where it is given, or (rows,)."""
    if rows[0].ndim == 2:
        return np.concatenate([noise.apply(a, s).ravel() for a, s in zip(rows, sessions, strict=True)])
    ends = np.cumsum([0, *(a.shape[1] * a.shape[2] for a in rows)])
    out = np.empty((len(rows[0]), ends[-1])) if out is None else out.T
    for a, s, start, end in zip(rows, sessions, ends[:-1], ends[1:], strict=True):
        for few in range(0, len(a), AT_ONCE):
            out[few : few + AT_ONCE, start:end] = noise.apply(a[few : few + AT_ONCE], s).reshape(-1, end - start)
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
