"""The noise of a recording: autoregressive, and correlated between channels.

A residual that is not white makes every test too sure of itself. The channels are first turned into uncorrelated mixtures (an encoder's
error reaches all of them and makes the strongest one; the eigenvectors of the residual's covariance); the noise of each mixture is AR(p),

    e[n] = a1 e[n-1] + … + ap e[n-p] + w[n],

fitted by the covariance method over all sessions; what correlation is left between the innovations w goes by one covariance matrix.
`Whitener.apply` turns residuals and directions alike into samples of unit variance.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.signal import lfilter

ORDER = 8
FLOOR = 1e-4  # of the variance, added as white noise: the band's stop band must not be blown up


@dataclass(frozen=True)
class Whitener:
    """`mix` (C, C) makes uncorrelated mixtures of the channels, `filters` (C, p+1) are their prediction-error filters, `root` (C, C) is the
    lower Cholesky factor of the innovations' covariance."""

    mix: np.ndarray
    filters: np.ndarray
    root: np.ndarray

    @property
    def to_unit(self) -> np.ndarray:
        """What makes innovations (C, n) independent and of unit variance, (C, C)."""
        return solve_triangular(self.root, np.eye(len(self.root)), lower=True)

    def apply(self, e: np.ndarray, weight: np.ndarray) -> np.ndarray:
        """Whiten (..., C, n), in the precision that comes in. Samples that a channel or its neighbourhood spoils, and the first p,
        come back as zeros."""
        to_unit, mix, believed = (a.astype(e.dtype) for a in (self.to_unit, self.mix, self._believed(weight)))
        if not self.filters[:, 1:].any():  # white: one product does it all
            return np.matmul(to_unit @ mix, e) * believed
        mixed = np.matmul(mix, e)
        for c, taps in enumerate(self.filters):
            mixed[..., c, :] = lfilter(taps.astype(e.dtype), np.ones(1, e.dtype), mixed[..., c, :], axis=-1)
        mixed *= believed
        return np.matmul(to_unit, mixed)

    def turned(self, w: np.ndarray, weight: np.ndarray) -> np.ndarray:
        """The adjoint of `apply` on (C, n): sum of apply(e) * w = sum of e * turned(w)."""
        back = (self.to_unit.T @ w * self._believed(weight))[:, ::-1]
        return self.mix.T @ np.array([lfilter(taps, [1.0], row) for taps, row in zip(self.filters, back, strict=True)])[:, ::-1]

    def _believed(self, weight: np.ndarray) -> np.ndarray:
        order = self.filters.shape[1] - 1
        believed = lfilter(np.ones(order + 1), [1.0], 1.0 - weight.min(axis=0)) < 0.5
        believed[:order] = False
        return believed


def fit_whitener(residuals: list[np.ndarray], weights: list[np.ndarray], order: int = ORDER) -> Whitener:
    """The noise model of residuals [(C, n), …]. Constant channels are given a tiny floor so that nothing divides by zero."""
    n_channels = residuals[0].shape[0]
    kept = np.concatenate([e[:, w.min(axis=0) > 0] for e, w in zip(residuals, weights, strict=True)], axis=1)
    _, vectors = np.linalg.eigh(np.atleast_2d(kept @ kept.T / max(kept.shape[1], 1)))
    mixed = [vectors.T @ e for e in residuals]
    together = [w.min(axis=0) for w in weights]
    filters = np.array([_prediction_error_filter([m[c] for m in mixed], together, order) for c in range(n_channels)])
    unit = Whitener(vectors.T, filters, np.eye(n_channels))
    w = np.concatenate([unit.apply(e, q) for e, q in zip(residuals, weights, strict=True)], axis=1)
    used = np.any(w != 0.0, axis=0)
    covariance = np.atleast_2d(w[:, used] @ w[:, used].T / max(used.sum(), 1))
    floor = np.diag(np.full(n_channels, 1e-18) + 1e-6 * np.diag(covariance))
    return Whitener(vectors.T, filters, np.linalg.cholesky(covariance + floor))


def white(residuals: list[np.ndarray]) -> Whitener:
    """White noise, independent in each channel, of the size that neighbouring samples of the residuals differ by."""
    steps = np.concatenate([np.diff(e, axis=1) for e in residuals], axis=1)
    size = np.maximum(np.sqrt(np.mean(steps**2, axis=1) / 2.0), 1e-12)
    n = size.size
    return Whitener(np.eye(n), np.eye(1, ORDER + 1).repeat(n, axis=0), np.diag(size))


def _prediction_error_filter(rows: list[np.ndarray], weights: list[np.ndarray], order: int) -> np.ndarray:
    past = np.concatenate([np.lib.stride_tricks.sliding_window_view(r, order + 1) for r in rows])
    good = np.concatenate([np.lib.stride_tricks.sliding_window_view(w, order + 1).all(axis=1) for w in weights])
    past = past[good]
    gram = past[:, :order].T @ past[:, :order]
    gram += np.eye(order) * (FLOOR * np.trace(gram) / order + 1e-30)
    a = np.linalg.solve(gram, past[:, :order].T @ past[:, order])
    return np.concatenate([[1.0], -a[::-1]])


def stack(rows: list[np.ndarray], sessions: list, noise: Whitener) -> np.ndarray:
    """Whiten [(M, C, n), …] or [(C, n), …] over sessions and lay them out as (rows, M) or (rows,)."""
    white = [noise.apply(a, s.weight) for a, s in zip(rows, sessions, strict=True)]
    return np.concatenate([w.reshape(*w.shape[:-2], -1) for w in white], axis=-1).T
