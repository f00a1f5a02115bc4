"""Excursions that a moving mass makes: a load cell that carries a plunger is pushed for a sample or two where it starts and stops."""

from collections.abc import Sequence

import numpy as np

from skin_ident.criticism.telemetry.wrong_samples import away_from_around
from skin_ident.estimators.scale import normal_scale
from skin_ident.stretches import runs, without

CLEAR = 5.0  # times what noise and steps of the encoder make of an acceleration, above which it is one
FEWEST = 2  # excursions that tell a mass
NEAR = 0.5  # of an excursion, within which the mass explains it


def not_pushed(
    away: list[np.ndarray], residuals: list[np.ndarray], paths: Sequence[np.ndarray], dt: float, reads: float
) -> list[np.ndarray]:
    """The excursions `away` of one channel, masks (N,) of each session whose model leaves `residuals` (N,) N, without those that are in one
    proportion to how the plunger speeds up along `paths` (N,) m, which an encoder `reads` so finely."""
    if not paths:
        return away
    each = [_pushes(*session, dt, reads) for session in zip(away, residuals, paths, strict=True)]
    ratios = [r for pushes in each for r in pushes.values()]
    mass = float(np.median(ratios)) if len(ratios) >= FEWEST else 0.0
    if mass <= 0.0:
        return away
    return [without(m, lambda a, b, p=p: a in p and abs(p[a] / mass - 1.0) < NEAR) for m, p in zip(away, each, strict=True)]


def _pushes(away: np.ndarray, residual: np.ndarray, path: np.ndarray, dt: float, reads: float) -> dict[int, float]:
    """By their first sample, the masses (kg) that would make excursions which begin where the plunger clearly speeds up or slows down."""
    speeding = np.pad(np.diff(path, 2), 1) / dt**2
    clear = CLEAR * max(normal_scale(speeding), reads / dt**2)
    far = np.zeros(away.size)
    far[away] = away_from_around(residual, away)
    strongest = {a: a + int(np.argmax(np.abs(far[a:b]))) for a, b in zip(*runs(away), strict=True)}
    return {a: far[i] / speeding[i] for a, i in strongest.items() if abs(speeding[i]) > clear}
