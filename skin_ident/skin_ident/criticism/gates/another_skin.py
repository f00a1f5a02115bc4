"""A skin that is another in every session: a hundredth stiffer today than on the day that was fitted.

What it leaves in a session that was not fitted is slow and large, belongs to no cause, and may hide what a true one gains. So numbers of
the skin may be the session's own, theta ~ N(0, s^2) as a share of each, with s = `STRAYS`, in every model that is held against it:

    theta = (J'J + 1/s^2)^-1 J' r,    2 log p - 2 log p0 = r' J theta - log det(1 + s^2 J'J)

with the whitened residual r, of which r - J theta is left, what theta changes, J, and the marginal likelihood p of that beside p0 without
(N. M. Laird, J. H. Ware, Random-effects models for longitudinal data, Biometrics 38 (1982) 963-974).
"""

import numpy as np

from skin_ident.criticism.baseline.fitting import tangents
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.baseline.settling import settled
from skin_ident.criticism.baseline.unknowns import Unknown, scales, unknowns, values
from skin_ident.criticism.noise.whitening import Whitener, stack
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

NUMBERS = ("k1", "b1", "k2", "b2")  # that a session may have of its own
STRAYS = 0.03  # s, of every number, from session to session


def of_the_skin(model: Model, s: Session) -> tuple[Unknown, ...]:
    """The unknowns that a session may have of its own; none of one that a force drives, in which a stiffness is a gain."""
    return tuple(u for u in unknowns(model, s) if u.label in NUMBERS) if s.drive is None else ()


def changes(model: Model, s: Session) -> np.ndarray:
    """What a unit of each theta changes in a session, (U, C, n) N in the common band."""
    which = of_the_skin(model, s)
    shares = values(model, which) / scales(model, which)
    return tangents(model, [s], which)[0] * shares[:, None, None]


def solved(J: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, float]:
    """theta (U,) of the module's equation from J (R, U) and r (R,), and what it explains: twice a log likelihood ratio."""
    gram, product = J.T @ J, J.T @ r
    theta = np.linalg.solve(gram + np.eye(len(gram)) / STRAYS**2, product)
    return theta, float(theta @ product - np.linalg.slogdet(np.eye(len(gram)) + STRAYS**2 * gram)[1])


def left_beside_own_skin(model: Model, session: Session, noise: Whitener) -> np.ndarray:
    """What a model leaves of a session beside numbers of the session's own, (C, n) N."""
    s = settled(model, session)
    own, e = changes(model, s), residual(model, s)
    theta, _ = solved(stack([own], [s], noise), stack([e], [s], noise))
    return e - np.tensordot(theta, own, 1)
