"""Shares of a session's own (variable projection).

Where sessions press at different places, each has its own share for every taxel. This factor says nothing about what happens in time
(`array` asks how shares depend on places). So it is not an unknown of the model: under any model, the taxels of such a session are scaled
to fit best, in the common band and by plain least squares (G. Golub, V. Pereyra, The differentiation of pseudo-inverses and nonlinear least
squares problems whose variables separate, SIAM Journal on Numerical Analysis 10 (1973) 413-432). One taxel of one training session is the
reference and is not scaled; it determines the stiffness under the taxels.
"""

import numpy as np

from skin_ident.criticism.sessions.session import Session

SHARE = (0.0, 3.0)  # bounds of the factor on a simulated taxel


def has_own(session: Session) -> bool:
    """Whether the session has shares of its own that are fitted."""
    return session.spread is not None and not session.pinned


def own_shares(y: np.ndarray, session: Session) -> np.ndarray:
    """Factors (T,), within `SHARE`, by which the simulated taxels in `y` (C, N) are multiplied to fit the session best."""
    taxels = session.taxel_rows
    Y = session.band.thin(y[taxels])
    beyond = 0.0 if session.beyond is None else session.band.thin(session.beyond[taxels])
    factor = regression((session.measured[taxels] - beyond)[None], Y, session.weight[taxels])[0]
    return np.where(kept(session), 1.0, np.clip(factor, *SHARE))


def take_shares(changes: np.ndarray, y: np.ndarray, session: Session) -> None:
    """Subtract from changes (K, C, n) of a simulation `y` (C, N) the part that the session's own shares can imitate. In place, since they
    are large."""
    if not has_own(session):
        return
    taxels = session.taxel_rows
    Y = session.band.thin(y[taxels])
    factors = np.where(kept(session), 0.0, regression(changes[:, taxels], Y, session.weight[taxels]))
    changes[:, taxels] -= factors[..., None] * Y


def regression(rows: np.ndarray, Y: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Slopes (K, T) of `rows` (K, T, n) on `Y` (T, n) with weights (T, n); 0 where `Y` has no power."""
    power = np.sum(w * Y**2, axis=1)
    return np.einsum("ktn,tn->kt", rows, w * Y) / np.where(power > 0.0, power, np.inf)


def kept(session: Session) -> np.ndarray:
    """Mask (T,) of taxels whose share stays as `spread` says: the reference, and stuck ones."""
    return ~session.answers[session.taxel_rows] | (np.arange(session.n_taxels) == session.reference)
