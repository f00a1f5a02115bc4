"""What the past of a noise predicts of its next sample.

The next sample is predicted from the last p and from M exponential averages, slower and slower,

    e[n] = a_1 e[n-1] + … + a_p e[n-p] + c_1 s_1[n] + … + c_M s_M[n] + w[n],    s_m[n] = (1 - 1/T_m) s_m[n-1] + e[n-1] / T_m,

fitted by least squares over all sessions: without the averages, noise that wanders would be white to a test at all but the lowest
frequencies, and slow causes would be named for it.

What was fitted to a residual and subtracted has taken noise with it, most of all at the lowest frequencies (see `taken`). A fit to what is
left would think the noise silent there, and every offset and drift would seem certain. The least squares are therefore completed by as
many oscillations as were taken below w_c, as loud as the noise is between w_c and 2 w_c (the geometric mean of its spectrum there). More
may have been taken from one mixture of the channels than from any channel, and no sensor is quieter the slower one looks: where less than
a fifth of the power is left of what no session lasts for three cycles of, as much is given back.

Sources: F. Corsi, J. Financial Econometrics 7 (2009) 174-196 (long memory by averages over a few times); H. D. Patterson and R. Thompson,
Biometrika 58 (1971) 545-554 (what regression takes from the noise has to be given back to it).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

MEMORIES = np.array([10.0, 30.0, 100.0, 300.0])  # T_m, samples
POLES = 1.0 - 1.0 / MEMORIES
AVERAGING = np.poly(POLES)  # the common denominator of all averages, and the numerator that each has over it
EACH = np.array([np.poly(np.delete(POLES, m)) / memory for m, memory in enumerate(MEMORIES)])
FINE = 32  # frequencies that stand for a band
SLOWEST = 6.0  # half cycles of the longest session, in which noise cannot be seen to be quieter than faster noise
QUIETER = 0.2  # of the power of that, the least that it is given


def fit_predictor(
    rows: list[np.ndarray], weights: list[np.ndarray], order: int, unseen: np.ndarray, floor: float
) -> tuple[np.ndarray, np.ndarray]:
    """The filter (p+1,) and the coefficients of the averages (M,) for one mixture and white noise of `floor` N^2, from all sessions
    together: where `weights` (n,) are 0, `rows` (n,) are not believed. Of the noise, `unseen` degrees of freedom were taken, in all and at
    the lowest frequencies."""
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
    gram = X.T @ X
    gram += np.diag(floor * len(X) * np.concatenate([np.ones(order), 1.0 / (2.0 * MEMORIES - 1.0)]) + 1e-30)  # as white noise would add
    product = X.T @ lags[:, order]
    fitted = _Normal(gram, product, np.linalg.solve(gram, product), float(np.sum(lags[:, order] ** 2)), len(X))
    fitted = fitted.given_back(np.full(FINE, unseen[1] / FINE), np.pi * unseen[0] / len(X))
    slowest = np.pi * min(SLOWEST / max(int(g.sum()) for g in good), 0.25)
    a = fitted.given_back(fitted.hole(slowest), slowest).a
    return np.concatenate([[1.0], -a[:order][::-1]]), a[order:]


def whole(f: np.ndarray, c: np.ndarray) -> np.ndarray:
    """The numerator, over `AVERAGING`, of the filter that leaves what neither the last samples, by the prediction-error filter `f` (p+1,),
    nor the averages, by the coefficients `c` (M,), predict."""
    averages = c @ EACH
    numerator = np.convolve(f, AVERAGING)
    numerator[1 : 1 + averages.size] -= averages
    return numerator


@dataclass(frozen=True)
class _Normal:
    """Normal equations, `gram` (p+M, p+M) and `product` (p+M,), of a predictor `a` of `n` samples with so much `energy`."""

    gram: np.ndarray
    product: np.ndarray
    a: np.ndarray
    energy: float
    n: int

    def given_back(self, lost: np.ndarray, edge: float) -> "_Normal":
        """With `lost` (F,) oscillations more at frequencies below `edge`, as loud as noise of this predictor is between that and twice as
        much."""
        if not lost.any():
            return self
        below, above = _around(edge)
        past = _past(below, self.a.size - MEMORIES.size)
        left = (self.energy - 2.0 * self.a @ self.product + self.a @ self.gram @ self.a) / self.n
        each = lost * left * _middle(self._loudness(above))
        gram, product = self.gram + (each * past @ past.conj().T).real, self.product + (past @ each).real
        return replace(self, gram=gram, product=product, a=np.linalg.solve(gram, product), energy=self.energy + float(each.sum()))

    def hole(self, edge: float) -> np.ndarray:
        """How many oscillations are lacking at frequencies (F,) below `edge`, where noise is not much quieter than between that and twice
        as much."""
        below, above = (self._loudness(w) for w in _around(edge))
        return self.n * edge / np.pi / FINE * np.maximum(QUIETER - below / _middle(above), 0.0)

    def _loudness(self, w: np.ndarray) -> np.ndarray:
        """The power of its noise at frequencies `w` (F,), in those of the innovations."""
        return np.abs(1.0 - self.a @ _past(w, self.a.size - MEMORIES.size)) ** -2.0


def _around(edge: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies below `edge`, and between that and twice as much, radians a sample."""
    below, above = (edge * (span + np.arange(FINE) / FINE) for span in (0.5 / FINE, 1.0))
    return below, above


def _middle(power: np.ndarray) -> float:
    return float(np.exp(np.mean(np.log(power))))


def _past(w: np.ndarray, order: int) -> np.ndarray:
    """What last samples and averages are of an oscillation of one, (p+M, F), at angular frequencies `w` (F,) in radians a sample."""
    z = np.exp(-1j * w)
    return np.concatenate([z ** np.arange(order, 0, -1)[:, None], z / (MEMORIES[:, None] * (1.0 - POLES[:, None] * z))])
