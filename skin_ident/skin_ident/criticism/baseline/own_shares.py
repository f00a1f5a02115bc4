"""Shares of a session's own.

Where sessions press at different places, each has a share of its own for every taxel, a factor of no interest to what goes on in time (the
array's own criticism asks how shares follow from places). So it is not an unknown of the model: whatever the model, the taxels of such a
session are scaled to fit it best, in the band and by plain least squares (G. Golub, V. Pereyra, The differentiation of pseudo-inverses and
nonlinear least squares problems whose variables separate, SIAM Journal on Numerical Analysis 10 (1973) 413-432). One taxel in one training
session is the reference, and stays as it is: by it the stiffness under the taxels is known.
"""

import numpy as np

from skin_ident.criticism.sessions.session import Session

SHARE = (0.0, 3.0)  # times what was there


def has_own(session: Session) -> bool:
    """Whether the session has shares of its own, and they are free."""
    return session.spread is not None and not session.pinned


def own_shares(y: np.ndarray, session: Session) -> np.ndarray:
    """By what the simulated taxels among channels `y` (C, N) are multiplied to fit the session best, (T,), within `SHARE`."""
    taxels = session.taxel_rows
    Y = session.band.thin(y[taxels])
    beyond = 0.0 if session.beyond is None else session.band.thin(session.beyond[taxels])
    factor = regression((session.measured[taxels] - beyond)[None], Y, session.weight[taxels])[0]
    return np.where(kept(session), 1.0, np.clip(factor, *SHARE))


def take_shares(changes: np.ndarray, y: np.ndarray, session: Session) -> None:
    """From changes (K, C, n) of a simulation `y` (C, N) take what shares of the session's own can follow. In place: they are large."""
    if not has_own(session):
        return
    taxels = session.taxel_rows
    Y = session.band.thin(y[taxels])
    factors = np.where(kept(session), 0.0, regression(changes[:, taxels], Y, session.weight[taxels]))
    changes[:, taxels] -= factors[..., None] * Y


def regression(rows: np.ndarray, Y: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Slopes (K, T) of `rows` (K, T, n) on `Y` (T, n) with weights (T, n); zero on what is not there."""
    power = np.sum(w * Y**2, axis=1)
    return np.einsum("ktn,tn->kt", rows, w * Y) / np.where(power > 0.0, power, np.inf)


def kept(session: Session) -> np.ndarray:
    """Which taxels (T,) have the share that `spread` says: the reference, and those that answer nothing."""
    return np.array([i == session.reference or f"taxel_{i}" in session.stuck for i in range(session.n_taxels)])
