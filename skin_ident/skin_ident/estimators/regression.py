"""Ordinary least squares of several channels on shared columns, with their joint covariance under coloured, correlated noise.

The estimate is that of the thesis, x = (H'H)^-1 H'y (eq 24). The textbook covariance s2 (H'H)^-1 holds for white noise only, so that of
`noise` is used instead, with correlation between the innovations of the channels (an error of the depth moves them all). The noise is
estimated over a wider band than the parameters, because it is seen best where there is no signal.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.signal import oaconvolve

from skin_ident.estimators.coherent import inflation
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.noise import coloured, effective_samples, from_products, highest_order, lagged_products, spread

PUT_BACK = 3  # iterations of correcting the noise model for the noise that the fit has absorbed


@dataclass(frozen=True)
class Block:
    """One session of one channel: y (n,), its columns H (n, P), and the kernel of the low-pass that both pass before they are compared."""

    y: np.ndarray
    columns: np.ndarray
    kernel: np.ndarray

    @cached_property
    def narrow(self) -> tuple[np.ndarray, np.ndarray]:
        """y and H through the low-pass."""
        return oaconvolve(self.y, self.kernel, mode="valid"), oaconvolve(self.columns, self.kernel[:, None], mode="valid", axes=0)

    def gain(self, inverse: np.ndarray) -> np.ndarray:
        """G (n, P): the change of each coefficient per sample of y, given (H'H)^-1 of the low-passed columns."""
        return oaconvolve(self.narrow[1] @ inverse, self.kernel[::-1, None], mode="full", axes=0)


@dataclass(frozen=True)
class Regression:
    """Coefficients of all channels, one after the other, with their joint covariance.

    Per channel: (H'H)^-1; measured and residual rows of every session, low-passed; the noise before the low-pass, by its AR coefficients
    and the std of its innovations; `repeated`, the factor by which errors that repeat with the motion widen its standard errors.
    """

    coefficients: list[np.ndarray]
    covariance: np.ndarray
    inverses: list[np.ndarray]
    measured: list[list[np.ndarray]]
    residuals: list[list[np.ndarray]]
    ar: list[np.ndarray]
    noise: list[float]
    repeated: list[float]
    condition: float
    dof: float


def regress(channels: Sequence[Sequence[Block]]) -> Regression:
    """Fit each channel (a list of its sessions). Raises `FitError` where a column is empty or repeats another exactly."""
    fits = [_solve(blocks) for blocks in channels]
    noises = [_noise(blocks, c, p) for blocks, (c, p, _) in zip(channels, fits, strict=True)]
    inverses = [p for _, p, _ in fits]
    return Regression(
        coefficients=[c for c, _, _ in fits],
        covariance=_joint(channels, inverses, noises),
        inverses=inverses,
        measured=[[b.narrow[0] for b in blocks] for blocks in channels],
        residuals=[[b.narrow[0] - b.narrow[1] @ c for b in blocks] for blocks, (c, _, _) in zip(channels, fits, strict=True)],
        ar=[n.ar for n in noises],
        noise=[n.std for n in noises],
        repeated=[n.felt / n.std if n.std > 0.0 else 1.0 for n in noises],
        condition=max(k for _, _, k in fits),
        dof=max(1.0, min(n.dof for n in noises)),
    )


def _solve(blocks: Sequence[Block]) -> tuple[np.ndarray, np.ndarray, float]:
    """Coefficients, (H'H)^-1, and the condition of H'H with columns of unit length."""
    y, columns = (np.concatenate(parts) for parts in zip(*(b.narrow for b in blocks), strict=True))
    scale = np.sqrt(np.sum(columns**2, axis=0))
    if np.any(scale == 0.0):
        raise FitError("one of the terms of the model is zero throughout: the skin was never touched, or never moved")
    unit = (columns / scale).T @ (columns / scale)
    condition = float(np.linalg.cond(unit))
    if not condition < 1e14:
        raise FitError("two terms of the model cannot be told apart with this motion: move faster, or at several depths")
    inverse = np.linalg.inv(unit) / np.outer(scale, scale)
    return np.linalg.lstsq(columns / scale, y, rcond=None)[0] / scale, inverse, condition


@dataclass(frozen=True)
class _Noise:
    """The noise of one channel: whitened residual (n,), AR coefficients, std of the innovations, effective degrees of freedom.

    `felt` is the std enlarged for errors that repeat with the motion.
    """

    white: np.ndarray
    ar: np.ndarray
    std: float
    felt: float
    dof: float


def _noise(blocks: Sequence[Block], coefficients: np.ndarray, inverse: np.ndarray) -> _Noise:
    """The noise of a channel. The fit has absorbed noise that looks like the columns; that part is estimated and added again."""
    residuals = [b.y - b.columns @ coefficients for b in blocks]
    n, top = sum(e.size for e in residuals), highest_order(residuals)
    seen = lagged_products(residuals, residuals, top)
    ar, std = from_products(seen, n, coefficients.size)
    gains = [b.gain(inverse) for b in blocks]
    for _ in range(PUT_BACK if std > 0.0 else 0):
        ar, std = from_products(seen + _taken_out(blocks, gains, ar, std, top), n, 0)
    white = np.concatenate([np.convolve(e, np.concatenate([[1.0], -ar]))[: e.size] for e in residuals])
    repeated = float(np.sqrt(inflation(residuals, gains, ar, std)))
    return _Noise(white, ar, std, repeated * std, min(effective_samples(ar, n) - coefficients.size, n / max(1, ar.size)))


def _taken_out(blocks: Sequence[Block], gains: list[np.ndarray], ar: np.ndarray, std: float, top: int) -> np.ndarray:
    """The lagged products that least squares removes from noise of this model: e = (I - H G') eps, E[eps eps'] = Omega."""
    columns = [b.columns for b in blocks]
    spreads = [spread(g, ar, std) for g in gains]
    covariance = sum(g.T @ s for g, s in zip(gains, spreads, strict=True))
    cross = lagged_products(spreads, columns, top) + lagged_products(columns, spreads, top)
    return cross - lagged_products(columns, [c @ covariance for c in columns], top)


def _joint(channels: Sequence[Sequence[Block]], inverses: list[np.ndarray], noises: list[_Noise]) -> np.ndarray:
    """The joint covariance of all coefficients. The estimate of a channel is P H' F y (F: the low-pass), so it moves by G' e, G = F' H
    P."""
    total = 0.0
    correlation = (
        np.corrcoef([n.white for n in noises]).reshape(len(noises), len(noises)) if all(n.std > 0 for n in noises) else np.eye(len(noises))
    )
    for i in range(len(channels[0])):
        factors = [n.felt * coloured(blocks[i].gain(p), n.ar) for blocks, p, n in zip(channels, inverses, noises, strict=True)]
        longest = max(f.shape[0] for f in factors)
        padded = [np.pad(f, ((0, longest - f.shape[0]), (0, 0))) for f in factors]
        count = range(len(padded))
        total = total + np.block([[correlation[c, d] * padded[c].T @ padded[d] for d in count] for c in count])
    return total
