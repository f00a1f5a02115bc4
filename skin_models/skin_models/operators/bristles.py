"""Bristles: dry contact that bends before it slips, over distance and not over time (Dahl's law).

    z' = (v - |v| z) / d        z between -1 and 1: the deflection relative to that while slipping; d the distance over which it bends

Stepped exactly for a path that is monotone between samples; upright at first.

Source: P. Dahl, A Solid Friction Model, TOR-0158, The Aerospace Corporation, 1968.
"""

import numpy as np

from skin_models.operators.scan import running_affine


def bristles(x: np.ndarray, distance: float) -> np.ndarray:
    """z over a whole path x (N,) m."""
    return running_affine(*_map(np.diff(x, prepend=x[0]), distance))


def bristles_step(state: tuple[float, float | None], x: float, distance: float) -> tuple[float, float]:
    """z and x after one sample at x (m), given those of the last one; (0, None) before the first."""
    bent, last = state
    gain, offset = _map(x - (x if last is None else last), distance)
    return gain * bent + offset, x


def _map(dx, distance: float):
    path = -np.abs(dx) / distance
    return np.exp(path), -np.sign(dx) * np.expm1(path)
