"""Where the force begins, if that is far from the zero of the encoder: moments of contact lie there, too.

A linear skin whose surface lies at the depth s reads F = k max(x - s, 0) + b v [x > s] + c; the s that explains most is looked for among
even steps, and between them. A curved skin seems to begin deeper than it does: so what is left out for this surface is left out beside
what is left out for that of the encoder, and names nothing.
"""

import numpy as np
from scipy.optimize import minimize_scalar

from skin_ident.criticism.sessions.session import Session
from skin_models.signals import Motion

FAR = 0.03  # of the greatest depth, from which a surface is another one
BETTER = 0.5  # of the squares that the encoder's zero leaves, the most that it may leave
ROUNDING = 1e-9  # of the squares of the loads, below which nothing is left to be explained
STEPS, NEAR = 60, 1e-4  # of the way, and of the greatest depth, to which the surface is found
MOST = 4000  # samples of a session that are looked at


def surface_of(sessions: list[Session]) -> float:
    """The depth, m, at which the force begins, or the strongest taxel; 0 where the encoder's zero does nearly as well."""
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
    """The squares that a linear skin with this surface leaves of the loads, N^2."""
    rows, loads = [], []
    for m, load in pressed:
        few = slice(None, None, max(1, m.x.size // MOST))
        x = m.x[few] - surface
        rows.append(np.column_stack([np.maximum(x, 0.0), m.v[few] * (x > 0.0), np.ones_like(x)]))
        loads.append(load[few])
    A, y = np.concatenate(rows), np.concatenate(loads)
    return float(np.sum((y - A @ np.linalg.lstsq(A, y, rcond=None)[0]) ** 2))
