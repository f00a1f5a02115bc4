"""Counts the degrees of freedom that directions fitted to a residual, and subtracted, have removed from its noise.

Every direction removes one degree of freedom, wherever the noise happens to resemble it. Directions are mostly slow, and a record has few
slow degrees of freedom: a few directions may leave nothing below w_c = pi k_c / n radians a sample, where k_c is the number removed from
channel c of n samples. The number removed below w_c is the power of the orthonormalised directions there.
"""

import numpy as np

ALIKE = 1e-8  # share of a direction's energy not spanned by the others, below which it counts as their duplicate


def taken(chosen: list[np.ndarray], left: list[np.ndarray], weights: list[np.ndarray]) -> np.ndarray:
    """Degrees of freedom that the directions `chosen` (k, C, n) have removed from each channel of the residual `left` (C, n), over all
    sessions: in all, and at the lowest frequencies, (2, C)."""
    size = np.sqrt(sum(np.sum((w * e) ** 2, axis=1) for e, w in zip(left, weights, strict=True)))
    rows = _orthonormal([a * w / np.maximum(size, 1e-12)[:, None] for a, w in zip(chosen, weights, strict=True)])
    freedom = sum(np.sum(row**2, axis=(0, 2)) for row in rows)
    edge = np.pi * freedom / max(sum(np.count_nonzero(w.min(axis=0)) for w in weights), 1)
    return np.array([freedom, sum(_below(edge, row) for row in rows)])


def _orthonormal(rows: list[np.ndarray]) -> list[np.ndarray]:
    """An orthonormal basis of the span of rows (k, C, n), with inner products over all sessions together."""
    gram = sum(np.tensordot(a, a, ([1, 2], [1, 2])) for a in rows).astype(float)
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-30))
    values, vectors = np.linalg.eigh(gram / np.outer(scale, scale))
    apart = values > ALIKE
    weights = (vectors[:, apart] / np.sqrt(values[apart])).T / scale
    return [np.tensordot(weights, a, 1) for a in rows]


def _below(edge: np.ndarray, row: np.ndarray) -> np.ndarray:
    """The energy (C,) of rows (k, C, n) below angular frequencies `edge` (C,) in radians a sample."""
    padded = 2 * row.shape[-1]
    power = np.abs(np.fft.rfft(row, padded)) ** 2 / row.shape[-1]  # one-sided
    power[..., 0] /= 2.0
    return np.sum(power * (np.linspace(0.0, np.pi, power.shape[-1]) <= edge[:, None]), axis=(0, 2))
