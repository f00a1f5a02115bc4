"""A first dispersion model by linear least squares (thesis eqs 24, 27, 28), as the start of every fit."""

import numpy as np

from skin_ident.criticism.sessions.session import NOMINAL, Session, motion_under, of_recovery
from skin_models.dispersion import Dispersion
from skin_models.model import Model
from skin_models.parameter import clipped

RECOVERIES = tuple(np.geomspace(1e-3, 1.0, 13))  # recovery times, s, of silicones and foams
MOST = 100.0  # largest ratio of a taxel to the applied force; above 1 where units or calibrations do not agree


def dispersion_start(sessions: list[Session], mass: float = 0.0) -> Model:
    """A dispersion model by regression of every channel on depth and speed in contact, over all sessions, in the common band."""
    if sessions[0].drive is not None:
        return _ratios(sessions, mass)
    H = np.concatenate([s.band.thin(np.array([s.motion.v, s.motion.x]) * (s.motion.x > 0)) for s in sessions], axis=1).T
    slopes = {}
    for c, name in enumerate(sessions[0].channels):
        y = np.concatenate([s.measured[c] for s in sessions])
        w = np.concatenate([s.weight[c] for s in sessions])
        slopes[name] = np.linalg.lstsq(H * w[:, None], y * w, rcond=None)[0]
    taxels = np.array([slopes[c] * (c not in sessions[0].stuck) for c in sessions[0].channels if c != "force"]).reshape(-1, 2)
    if sessions[0].spread is not None:
        taxels = np.tile(_under_spread(sessions), (len(taxels), 1))
    b, k = slopes.get("force", 2.0 * taxels.max(axis=0, initial=0.0))
    if not taxels.size:
        return Model(_skin(m=mass, b1=0.0, k1=0.0, b2=b, k2=k), shares=())
    reference = int(np.argmax(taxels[:, 1]))
    b1, k1 = taxels[reference, 0], max(taxels[reference, 1], 1e-6)
    shares = np.maximum(taxels[:, 1] / k1, 0.0)
    return Model(_skin(m=mass, b1=b1, k1=k1, b2=b - b1, k2=k - k1), shares=tuple(shares))


def _skin(**values: float) -> Dispersion:
    """A dispersion model from these values, clipped to the bounds, which the regression does not know."""
    return Dispersion(**clipped(Dispersion, **values))


def _under_spread(sessions: list[Session]) -> np.ndarray:
    """Damping and stiffness (2,) of the sensed branch, where each session has known shares of the taxels (`spread`)."""
    rows, loads = [], []
    for s in sessions:
        H = s.band.thin(np.array([s.motion.v, s.motion.x]) * (s.motion.x > 0))
        w = (s.weight * s.answers[:, None])[s.taxel_rows]
        rows.append((s.spread[:, None, None] * H.T * w[..., None]).reshape(-1, 2))
        loads.append((s.measured[s.taxel_rows] * w).ravel())
    return np.linalg.lstsq(np.concatenate(rows), np.concatenate(loads), rcond=None)[0]


def _ratios(sessions: list[Session], mass: float) -> Model:
    """Start for a force-to-force test: the ratio of every taxel to the applied force. For a given recovery time tau the problem is linear
    in k and b of each taxel,

        taxel = k x + b x' + zero of the session,    tau x' + x = F / K.

    The tau with the smallest residual is taken, since a fit that starts far from it may not converge.
    """
    _, tau, slopes = min((_under_recovery(sessions, tau) for tau in RECOVERIES), key=lambda found: found[0])
    k, b = np.maximum(slopes[:, 0], 1e-6 * NOMINAL), slopes[:, 1]
    reference = int(np.argmax(k))
    k1, b1 = float(np.clip(k[reference], 0.01 * NOMINAL, MOST * NOMINAL)), float(b[reference])
    skin = _skin(m=mass, b1=b1, k1=k1, b2=NOMINAL * tau - b1, k2=NOMINAL - k1)
    return Model(skin, shares=tuple(k / k[reference]))


def _under_recovery(sessions: list[Session], tau: float) -> tuple[float, float, np.ndarray]:
    """Sum of squared residuals of all taxels with a skin of recovery time tau (s), N^2; tau; and k and b of every taxel (T, 2): the same of
    all where each session has known shares of them (`spread`)."""
    rows: list[list[np.ndarray]] = [[] for _ in sessions[0].channels]
    for s in sessions:
        moved = motion_under(s, of_recovery(tau))
        H = s.band.thin(np.array([moved.x, moved.v]))
        shares = np.ones(len(rows)) if s.spread is None else s.spread
        for taxel, share, y, w in zip(rows, shares, s.measured, s.weight * s.answers[:, None], strict=True):
            seen = np.vstack([share * H, y])[:, w > 0.0]
            taxel.append(seen - seen.mean(axis=1, keepdims=True) if seen.size else seen)
    every = [np.concatenate(taxel, axis=1) for taxel in rows]
    alike = [np.concatenate(every, axis=1)] * len(every) if sessions[0].spread is not None else every
    slopes = np.array([np.linalg.lstsq(e[:2].T, e[2], rcond=None)[0] for e in alike])
    return float(sum(np.sum((e[2] - of @ e[:2]) ** 2) for e, of in zip(every, slopes, strict=True))), tau, slopes
