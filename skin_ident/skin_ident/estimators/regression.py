"""Ordinary least squares of several channels on shared columns, with their joint covariance under coloured, correlated noise.

The estimate is that of the thesis, x = (H'H)^-1 H'y (eq 24). Its covariance is not the textbook's s2 (H'H)^-1, which holds for white
noise only, but the one of `noise`, with the innovations of the channels correlated among themselves (a wrong depth moves them all).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skin_ident.estimators.errors import FitError
from skin_ident.estimators.noise import coloured, effective_samples, fit_ar


@dataclass(frozen=True)
class Block:
    """One session of one channel: y (n,) and its columns H (n, P)."""

    y: np.ndarray
    columns: np.ndarray


@dataclass(frozen=True)
class Regression:
    """Coefficients of all channels, one after the other, with their joint covariance; (H'H)^-1 and residuals per channel."""

    coefficients: list[np.ndarray]
    covariance: np.ndarray
    inverses: list[np.ndarray]
    residuals: list[list[np.ndarray]]
    ar: list[np.ndarray]
    noise: list[float]
    condition: float
    dof: float


def regress(channels: Sequence[Sequence[Block]]) -> Regression:
    """Fit each channel (a list of its sessions). Raises `FitError` where a column is empty or repeats another exactly."""
    fits = [_solve(blocks) for blocks in channels]
    residuals = [[b.y - b.columns @ c for b in blocks] for blocks, (c, _, _) in zip(channels, fits, strict=True)]
    noises = [fit_ar(e, len(c)) for e, (c, _, _) in zip(residuals, fits, strict=True)]
    n = sum(e.size for e in residuals[0])
    return Regression(
        coefficients=[c for c, _, _ in fits],
        covariance=_joint(channels, [p for _, p, _ in fits], noises, _innovations(residuals, noises)),
        inverses=[p for _, p, _ in fits],
        residuals=residuals,
        ar=[ar for ar, _ in noises],
        noise=[s for _, s in noises],
        condition=max(k for _, _, k in fits),
        dof=max(1.0, min(effective_samples(ar, n) for ar, _ in noises) - max(len(c) for c, _, _ in fits)),
    )


def _solve(blocks: Sequence[Block]) -> tuple[np.ndarray, np.ndarray, float]:
    """Coefficients, (H'H)^-1, and the condition of H'H with columns of unit length."""
    gram = sum(b.columns.T @ b.columns for b in blocks)
    scale = np.sqrt(np.diag(gram))
    if np.any(scale == 0.0):
        raise FitError("one of the terms of the model is zero throughout: the skin was never touched, or never moved")
    unit = gram / np.outer(scale, scale)
    condition = float(np.linalg.cond(unit))
    if not condition < 1e14:
        raise FitError("two terms of the model cannot be told apart with this motion: move faster, or at several depths")
    inverse = np.linalg.inv(unit) / np.outer(scale, scale)
    stacked = np.concatenate([b.columns for b in blocks]) / scale
    return np.linalg.lstsq(stacked, np.concatenate([b.y for b in blocks]), rcond=None)[0] / scale, inverse, condition


def _innovations(residuals: list[list[np.ndarray]], noises: list[tuple[np.ndarray, float]]) -> np.ndarray:
    """Correlation (C, C) of the whitened residuals."""
    longest = max(ar.size for ar, _ in noises)
    white = [np.concatenate([_whitened(e, ar)[longest:] for e in es]) for es, (ar, _) in zip(residuals, noises, strict=True)]
    size = np.sqrt(np.mean(np.square(white), axis=1))
    safe = np.where(size > 0, size, 1.0)
    return (np.array(white) @ np.array(white).T) / np.outer(safe, safe) / max(1, len(white[0]))


def _whitened(e: np.ndarray, ar: np.ndarray) -> np.ndarray:
    return np.convolve(e, np.concatenate([[1.0], -ar]))[: e.size]


def _joint(channels, inverses, noises, correlation) -> np.ndarray:
    """P_c (H_c' Omega_cd H_d) P_d for all pairs of channels; sessions are independent."""
    sessions = range(len(channels[0]))
    total = 0.0
    for i in sessions:
        factors = [s * coloured(blocks[i].columns, ar) @ p for blocks, p, (ar, s) in zip(channels, inverses, noises, strict=True)]
        longest = max(f.shape[0] for f in factors)
        padded = [np.pad(f, ((0, longest - f.shape[0]), (0, 0))) for f in factors]
        total = total + np.block([[correlation[c, d] * padded[c].T @ padded[d] for d in range(len(padded))] for c in range(len(padded))])
    return total
