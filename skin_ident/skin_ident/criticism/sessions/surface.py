"""Finds the depth at which the force begins, if that is far from the encoder's zero: contact is made and lost there, too.

A linear skin whose surface lies at the depth s reads F = k max(x - s, 0) + b v [x > s] + c. The s with the smallest residual is searched on
an even grid and then refined. A curved skin seems to begin deeper than it does. So the moments left out for this surface are left out in
addition to those of the encoder's zero, and the surface by itself names no cause.
"""

import numpy as np
from scipy.optimize import minimize_scalar

from skin_ident.criticism.sessions.session import Session
from skin_models.signals import Motion

FAR = 0.03  # share of the greatest depth from which the surface differs from the encoder's zero
BETTER = 0.5  # largest ratio of its residual sum of squares to that of the encoder's zero
ROUNDING = 1e-9  # share of the loads' sum of squares below which nothing is left to explain
STEPS, NEAR = 60, 1e-4  # STEPS: grid points over the range of depth; NEAR: tolerance of the surface, share of the greatest depth
MOST = 4000  # most samples that are used of a session


def surface_of(sessions: list[Session]) -> float:
    """The depth, m, at which the force (or, without one, the channel with the largest range) begins; 0 where the encoder's zero does nearly
    as well."""
    pressed = [(s.motion, _load(s)) for s in sessions if s.drive is None]
    if not pressed:
        return 0.0
    if _left(pressed, 0.0) < ROUNDING * sum(float(np.sum((y - y.mean()) ** 2)) for _, y in pressed):
        return 0.0
    shallowest, deepest = min(m.x.min() for m, _ in pressed), max(m.x.max() for m, _ in pressed)
    step = (deepest - shallowest) / STEPS
    coarse = min(shallowest + step * np.arange(STEPS - 1), key=lambda s: _left(pressed, s))
    around = (coarse - step, coarse + step)
    finest = minimize_scalar(lambda s: _left(pressed, s), bounds=around, method="bounded", options={"xatol": NEAR * deepest}).x
    far = abs(finest) > FAR * deepest and _left(pressed, finest) < BETTER * _left(pressed, 0.0)
    return float(finest) if far else 0.0


def _load(session: Session) -> np.ndarray:
    channel = int(np.argmax([np.ptp(y) for y in session.bridged])) if "force" not in session.channels else session.channels.index("force")
    return session.bridged[channel]


def _left(pressed: list[tuple[Motion, np.ndarray]], surface: float) -> float:
    """Residual sum of squares of the loads, N^2, for a linear skin with this surface."""
    rows, loads = [], []
    for m, load in pressed:
        few = slice(None, None, max(1, m.x.size // MOST))
        x = m.x[few] - surface
        rows.append(np.column_stack([np.maximum(x, 0.0), m.v[few] * (x > 0.0), np.ones_like(x)]))
        loads.append(load[few])
    A, y = np.concatenate(rows), np.concatenate(loads)
    return float(np.sum((y - A @ np.linalg.lstsq(A, y, rcond=None)[0]) ** 2))
