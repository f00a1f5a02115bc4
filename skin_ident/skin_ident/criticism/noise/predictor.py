"""Linear prediction of the next noise sample from its past.

The next sample is predicted from the last p samples and from M exponential averages, slower and slower,

    e[n] = a_1 e[n-1] + … + a_p e[n-p] + c_1 s_1[n] + … + c_M s_M[n] + w[n],    s_m[n] = (1 - 1/T_m) s_m[n-1] + e[n-1] / T_m,

fitted by least squares over all sessions. Without the averages a test would take wandering noise for white at all but the lowest
frequencies, and would name slow causes for it.

Directions that were fitted to a residual and subtracted have removed noise with it, most of all at the lowest frequencies (see `taken`). A
fit to the rest would find almost no noise there, and every offset and drift would seem certain. Two corrections add sinusoids to the least
squares:

- As many sinusoids below w_c as degrees of freedom were removed there, each as loud as the noise between w_c and 2 w_c (geometric mean of
  its spectrum there).
- More may have been removed from a mixture of the channels than from any single channel, and no sensor gets quieter towards low
  frequencies. So at frequencies of which even the longest session lasts less than three cycles, the power is raised towards a fifth of that
  of the octave above.

Sources: F. Corsi, J. Financial Econometrics 7 (2009) 174-196 (long memory by averages over a few times); H. D. Patterson and R. Thompson,
Biometrika 58 (1971) 545-554 (the noise that regression removes has to be given back).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

MEMORIES = np.array([10.0, 30.0, 100.0, 300.0])  # T_m, time constants of the averages, samples
POLES = 1.0 - 1.0 / MEMORIES
AVERAGING = np.poly(POLES)  # common denominator of all averages; `EACH` holds the numerator of each average over it
EACH = np.array([np.poly(np.delete(POLES, m)) / memory for m, memory in enumerate(MEMORIES)])
FINE = 32  # frequencies that represent a band
SLOWEST = 6.0  # half cycles in the longest session, below which noise cannot be seen to be quieter than at higher frequencies
QUIETER = 0.2  # least power at those frequencies, as a share of that in the octave above


def fit_predictor(
    rows: list[np.ndarray], weights: list[np.ndarray], order: int, unseen: np.ndarray, floor: float
) -> tuple[np.ndarray, np.ndarray]:
    """The prediction-error filter (p+1,) and the coefficients of the averages (M,) of one mixture, fitted to all sessions together, with
    white noise of variance `floor` N^2 added. `rows` (n,) are not trusted where `weights` (n,) are 0. `unseen` are the degrees of freedom
    that fitted directions removed from the noise: in all, and at the lowest frequencies."""
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
    gram += np.diag(floor * len(X) * np.concatenate([np.ones(order), 1.0 / (2.0 * MEMORIES - 1.0)]) + 1e-30)  # what white noise would add
    product = X.T @ lags[:, order]
    fitted = _Normal(gram, product, np.linalg.solve(gram, product), float(np.sum(lags[:, order] ** 2)), len(X))
    fitted = fitted.given_back(np.full(FINE, unseen[1] / FINE), np.pi * unseen[0] / len(X))
    slowest = np.pi * min(SLOWEST / max(int(g.sum()) for g in good), 0.25)
    a = fitted.given_back(fitted.hole(slowest), slowest).a
    return np.concatenate([[1.0], -a[:order][::-1]]), a[order:]


def whole(f: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Numerator, over `AVERAGING`, of the filter that gives the prediction error, for taps `f` (p+1,) on the last samples and coefficients
    `c` (M,) of the averages."""
    averages = c @ EACH
    numerator = np.convolve(f, AVERAGING)
    numerator[1 : 1 + averages.size] -= averages
    return numerator


@dataclass(frozen=True)
class _Normal:
    """Normal equations of a predictor: `gram` (p+M, p+M), `product` (p+M,), the solution `a`, the `energy` of the `n` predicted samples."""

    gram: np.ndarray
    product: np.ndarray
    a: np.ndarray
    energy: float
    n: int

    def given_back(self, lost: np.ndarray, edge: float) -> "_Normal":
        """The equations with `lost` (F,) more sinusoids at frequencies below `edge`, each as loud as this predictor's noise between `edge`
        and twice `edge`."""
        if not lost.any():
            return self
        below, above = _around(edge)
        past = _past(below, self.a.size - MEMORIES.size)
        left = (self.energy - 2.0 * self.a @ self.product + self.a @ self.gram @ self.a) / self.n
        each = lost * left * _middle(self._loudness(above))
        gram, product = self.gram + (each * past @ past.conj().T).real, self.product + (past @ each).real
        return replace(self, gram=gram, product=product, a=np.linalg.solve(gram, product), energy=self.energy + float(each.sum()))

    def hole(self, edge: float) -> np.ndarray:
        """How many sinusoids are missing at each of the frequencies (F,) below `edge` to bring the power there to `QUIETER` of that in the
        octave above."""
        below, above = (self._loudness(w) for w in _around(edge))
        return self.n * edge / np.pi / FINE * np.maximum(QUIETER - below / _middle(above), 0.0)

    def _loudness(self, w: np.ndarray) -> np.ndarray:
        """Power spectrum of the predictor's noise at frequencies `w` (F,), relative to that of the innovations."""
        return np.abs(1.0 - self.a @ _past(w, self.a.size - MEMORIES.size)) ** -2.0


def _around(edge: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies below `edge`, and those between `edge` and twice `edge`, radians a sample."""
    below, above = (edge * (span + np.arange(FINE) / FINE) for span in (0.5 / FINE, 1.0))
    return below, above


def _middle(power: np.ndarray) -> float:
    return float(np.exp(np.mean(np.log(power))))


def _past(w: np.ndarray, order: int) -> np.ndarray:
    """Regressors (last p samples and M averages), (p+M, F), for a complex oscillation of amplitude one at angular frequencies `w` (F,),
    radians a sample."""
    z = np.exp(-1j * w)
    return np.concatenate([z ** np.arange(order, 0, -1)[:, None], z / (MEMORIES[:, None] * (1.0 - POLES[:, None] * z))])
