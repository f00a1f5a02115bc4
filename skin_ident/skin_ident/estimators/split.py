"""From the damping and stiffness fitted to each channel to the parameters of the dispersion model.

    force     B v + K x         B = b1 + b2,   K = k1 + k2
    taxel i   b_i v + k_i x     (b_i, k_i) = s_i (b1, k1),  the strongest taxel having s = 1

Several taxels are described by one pair (b1, k1) and a share each: the best approximation of rank one, weighted by the noise of the taxels
and by the precision of (b, k).
"""

import numpy as np


def split(force: np.ndarray | None, taxels: np.ndarray, weights: np.ndarray, metric: np.ndarray) -> np.ndarray:
    """b1, k1, b2, k2, shares: shape (4 + T,).

    force (2,) = (B, K) or None without a load cell (then b2 = k2 = 0); taxels (T, 2) rows of (b_i, k_i), where T = 0 leaves the whole skin
    in b1 and k1; weights (T,) 1 / noise; metric (2, 2) a Cholesky factor of the precision of (b, k).
    """
    if not len(taxels):
        return np.array([force[0], force[1], 0.0, 0.0])
    sensed, shares = _rank_one(taxels, weights, metric)
    rest = np.zeros(2) if force is None else force - sensed
    return np.concatenate([sensed, rest, shares])


def _rank_one(rows: np.ndarray, weights: np.ndarray, metric: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    if len(rows) == 1:
        return rows[0], np.ones(1)
    u, size, v = np.linalg.svd(weights[:, None] * (rows @ metric), full_matrices=False)
    shares, sensed = u[:, 0] / weights, size[0] * np.linalg.solve(metric.T, v[0])
    strongest = shares[np.argmax(np.abs(shares))]
    return sensed * strongest, shares / strongest


def weights_of(noise: np.ndarray) -> np.ndarray:
    """1 / noise (T,), with the largest limited to a thousand times the smallest."""
    return 1.0 / np.maximum(noise, max(1e-3 * np.max(noise, initial=0.0), 1e-12))


def metric_of(covariance: np.ndarray) -> np.ndarray:
    """The Cholesky factor (2, 2) of the inverse of a covariance of (b, k), up to scale, so that (H'H)^-1 may be given."""
    scale = np.sqrt(np.diag(covariance))
    unit = covariance / np.outer(scale, scale)
    precision = np.linalg.inv(unit + 1e-12 * np.eye(2)) / np.outer(scale, scale)
    return np.linalg.cholesky(precision / np.trace(precision))


def jacobian(f, beta: np.ndarray) -> np.ndarray:
    """Derivative (M, P) of f: (P,) -> (M,) at beta, by central differences."""
    steps = np.diag(1e-6 * np.maximum(np.abs(beta), 1e-9))
    return np.array([(f(beta + d) - f(beta - d)) / (2.0 * d.sum()) for d in steps]).T
