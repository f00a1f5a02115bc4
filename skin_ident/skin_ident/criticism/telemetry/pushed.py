"""Excursions that come from motion and not from a sensor: a load cell that carries a plunger is pushed for a sample or two where the
plunger starts and stops, and every channel feels a motion that is quicker than the encoder's readings show."""

from collections.abc import Sequence

import numpy as np

from skin_ident.criticism.telemetry.wrong_samples import away_from_around
from skin_ident.estimators.scale import normal_scale
from skin_ident.stretches import runs, without

CLEAR = 5.0  # times the acceleration error from noise and steps of the encoder, above which an acceleration is clear
FEWEST = 2  # excursions that give a mass
NEAR = 0.5  # relative deviation from the mass's push up to which it explains an excursion
SEEN = 3.0  # the same as `CLEAR`, enough where another channel shows the excursion as well
SHARED = 4.0  # noise widths by which that channel must be off


def not_pushed(
    away: list[np.ndarray], residuals: list[np.ndarray], paths: Sequence[np.ndarray], dts: Sequence[float], reads: float
) -> list[np.ndarray]:
    """The excursions `away` of one channel, masks (N,) of each session with residual `residuals` (N,), N, without those that are
    proportional to the plunger's acceleration along `paths` (N,) m, sampled every `dts` s, with one mass for all. `reads` is the encoder's
    resolution, m."""
    if not paths:
        return away
    each = [_pushes(*session, reads) for session in zip(away, residuals, paths, dts, strict=True)]
    ratios = [r for pushes in each for r in pushes.values()]
    mass = float(np.median(ratios)) if len(ratios) >= FEWEST else 0.0
    if mass <= 0.0:
        return away
    return [without(m, lambda a, b, p=p: a in p and abs(p[a] / mass - 1.0) < NEAR) for m, p in zip(away, each, strict=True)]


def not_shared(
    away: list[np.ndarray], c: int, residuals: list[np.ndarray], paths: Sequence[np.ndarray], dts: Sequence[float], reads: float
) -> list[np.ndarray]:
    """The excursions `away` of channel `c`, masks (N,) of each session with residuals (C, N), N, without those at which the plunger
    accelerates along `paths` (N,) m, sampled every `dts` s, and which another channel shares: they come from the motion."""
    if not paths:
        return away
    kept = []
    for mask, e, path, dt in zip(away, residuals, paths, dts, strict=True):
        felt, speeding = _felt(mask, c, e), _speeding(path, dt, reads)
        kept.append(without(mask, lambda a, b, f=felt, s=speeding: s[a - 1 : b + 1].any() and f[a:b].any()))
    return kept


def _felt(away: np.ndarray, c: int, residuals: np.ndarray) -> np.ndarray:
    """Mask (N,) of samples where channel `c` is `away` and another channel is clearly off to the same side."""
    out = np.zeros(away.size, bool)
    if away.any() and not away.all():
        far = np.array([away_from_around(e, away) for e in residuals])
        width = np.array([normal_scale(np.diff(e)) for e in residuals])
        shared = far * np.sign(far[c]) > SHARED * width[:, None]
        out[away] = np.delete(shared, c, axis=0).any(axis=0)
    return out


def _speeding(path: np.ndarray, dt: float, reads: float) -> np.ndarray:
    """Mask (N,) of samples where the plunger accelerates or brakes along a `path` (N,) m, above the error of an encoder of resolution
    `reads`, m."""
    speeding = _acceleration(path, dt)
    return np.abs(speeding) > SEEN * _unread(speeding, dt, reads)


def _acceleration(path: np.ndarray, dt: float) -> np.ndarray:
    return np.pad(np.diff(path, 2), 1) / dt**2


def _unread(speeding: np.ndarray, dt: float, reads: float) -> float:
    """Error of an acceleration, m/s^2, from noise and steps of the encoder."""
    return max(normal_scale(speeding), reads / dt**2)


def _pushes(away: np.ndarray, residual: np.ndarray, path: np.ndarray, dt: float, reads: float) -> dict[int, float]:
    """Masses (kg) that would make the excursions which begin where the plunger clearly accelerates or brakes, by the excursion's first
    sample."""
    speeding = _acceleration(path, dt)
    clear = CLEAR * _unread(speeding, dt, reads)
    far = np.zeros(away.size)
    far[away] = away_from_around(residual, away)
    strongest = {a: a + int(np.argmax(np.abs(far[a:b]))) for a, b in zip(*runs(away), strict=True)}
    return {a: far[i] / speeding[i] for a, i in strongest.items() if abs(speeding[i]) > clear}
