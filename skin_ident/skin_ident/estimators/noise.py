"""Coloured noise: an autoregressive model of the residual, and its effect on the covariance of least squares.

With e = A(q)^-1 w, w white of variance s2, ordinary least squares has the covariance

    P (H' Omega H) P,     P = (H'H)^-1,     H' Omega H = s2 || A(q^-1)^-1 H ||^2

where Omega is the covariance of e. One backward recursion per column replaces the (N, N) matrix Omega.
Source: E. J. Hannan, Multiple Time Series, Wiley 1970, ch. VII; order by BIC, G. Schwarz, Ann. Statist. 6 (1978).
"""

from collections.abc import Sequence

import numpy as np
from scipy.signal import lfilter


def fit_ar(residuals: Sequence[np.ndarray], lost: int = 0) -> tuple[np.ndarray, float]:
    """Coefficients a of e[n] = sum a[i] e[n-1-i] + w[n] and the std of w, pooled over sessions.

    `residuals` are arrays (N_s,), whose means are not subtracted; `lost` is the number of parameters that were fitted to get them. The
    Yule-Walker equations always give a stable model; the order minimises BIC.
    """
    products = lagged_products(residuals, residuals, highest_order(residuals))
    return from_products(products, sum(e.size for e in residuals), lost)


def highest_order(residuals: Sequence[np.ndarray]) -> int:
    """The highest AR order that so many samples support."""
    n = sum(e.size for e in residuals)
    return int(min(30, max(1, n // 20), max(e.size for e in residuals) - 1))


def lagged_products(a: Sequence[np.ndarray], b: Sequence[np.ndarray], top: int) -> np.ndarray:
    """The sums of a[n] b[n - k] over samples, columns and sessions, for k = 0 … top."""
    pairs = list(zip(a, b, strict=True))
    return np.array([sum(float(np.vdot(x[k:], y[: len(y) - k])) for x, y in pairs if len(x) > k) for k in range(top + 1)])


def from_products(products: np.ndarray, n: int, lost: int) -> tuple[np.ndarray, float]:
    """The AR model of a residual from its lagged products (top + 1,) over n samples."""
    if products[0] <= 0.0:
        return np.empty(0), 0.0
    ar, std = _best_order(products / max(n - lost, 1), n)
    return _unshrunk(ar, n), std


def _unshrunk(ar: np.ndarray, n: int) -> np.ndarray:
    """The model with its poles moved outwards, by as much as the Yule-Walker equations shrink them on average: 3 / n of their radius, which
    is exact for order 1.

    Source: P. Shaman, R. A. Stine, J. Amer. Statist. Assoc. 83 (1988) 842.
    """
    if not ar.size:
        return ar
    radius = float(np.max(np.abs(np.roots(np.concatenate([[1.0], -ar])))))
    growth = min(1.0 + 3.0 / n, max(1.0, (1.0 - 0.5 / n) / max(radius, 1e-12)))
    return ar * growth ** np.arange(1, ar.size + 1)


def _best_order(gamma: np.ndarray, n: int) -> tuple[np.ndarray, float]:
    """AR coefficients and std of the innovations at the order with the lowest BIC, by Levinson's recursion."""
    a, variance = np.empty(0), gamma[0]
    best = (n * np.log(variance), a, variance)
    for p in range(1, gamma.size):
        reflection = (gamma[p] - np.dot(a, gamma[p - 1 : 0 : -1] if p > 1 else [])) / variance
        a = np.concatenate([a - reflection * a[::-1], [reflection]])
        variance *= max(1.0 - reflection**2, 1e-12)
        if not abs(reflection) < 1.0:  # cannot happen to a sample's own autocovariance, but to a corrected one
            break
        score = n * np.log(variance) + p * np.log(n)
        if score < best[0]:
            best = (score, a, variance)
    return best[1], float(np.sqrt(best[2]))


def coloured(columns: np.ndarray, ar: np.ndarray) -> np.ndarray:
    """A(q^-1)^-1 H for one session's columns (N, P), last sample first. The recursion continues before the session until it has decayed."""
    if not ar.size:
        return columns[::-1]
    tail = np.zeros((_memory(ar), columns.shape[1]))
    return lfilter([1.0], np.concatenate([[1.0], -ar]), np.concatenate([tail, columns])[::-1], axis=0)


def _memory(ar: np.ndarray) -> int:
    """Samples after which the noise's correlation has decayed to 1e-3."""
    slowest = np.max(np.abs(np.roots(np.concatenate([[1.0], -ar]))), initial=0.0)
    return int(min(20000, np.ceil(np.log(1e-3) / np.log(min(max(slowest, 1e-3), 0.99999)))))


def spread(columns: np.ndarray, ar: np.ndarray, std: float) -> np.ndarray:
    """Omega G for one session's columns G (N, P)."""
    if not ar.size:
        return std**2 * columns
    back = coloured(columns, ar)[::-1]
    return std**2 * lfilter([1.0], np.concatenate([[1.0], -ar]), back, axis=0)[-len(columns) :]


def effective_samples(ar: np.ndarray, n: int) -> float:
    """The number of independent samples whose variance is known as well as that of n correlated ones (Bartlett)."""
    if not ar.size:
        return float(n)
    gamma = autocovariance(ar, min(n, _memory(ar)))
    return float(n / max(1.0, 1.0 + 2.0 * np.sum(np.square(gamma[1:] / gamma[0]))))


def autocovariance(ar: np.ndarray, lags: int) -> np.ndarray:
    """Autocovariance (lags + 1,) of the AR process with unit innovations."""
    pulse = lfilter([1.0], np.concatenate([[1.0], -ar]), np.eye(1, 2 * lags + _memory(ar) + 1)[0])
    return np.array([np.dot(pulse[k:], pulse[: pulse.size - k]) for k in range(lags + 1)])
