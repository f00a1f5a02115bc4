"""A skin that is another in every session: a hundredth stiffer today than on the day that was fitted.

What it leaves in a session that was not fitted is slow and large, belongs to no cause, and may hide what a true one gains. So numbers of
the skin may be the session's own, theta ~ N(0, s^2) as a share of each, in every model that is held against it:

    theta = (J'J + 1/s^2)^-1 J' e,    left: e - J theta

with the whitened residual e and what theta changes, J (N. M. Laird, J. H. Ware, Random-effects models for longitudinal data, Biometrics 38
(1982) 963-974).
"""

import numpy as np

from skin_ident.criticism.baseline.fitting import tangents
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.baseline.settling import settled
from skin_ident.criticism.baseline.unknowns import Unknown, scales, unknowns, values
from skin_ident.criticism.gates.uncertain import Open
from skin_ident.criticism.noise.whitening import Whitener
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


def left_beside_own_skin(model: Model, session: Session, noise: Whitener) -> np.ndarray:
    """What a model leaves of a session beside numbers of the session's own, (C, n) N."""
    s = settled(model, session)
    J = changes(model, s)
    return Open([J], np.eye(len(J)) / STRAYS).beside([residual(model, s)], [s], noise)[0]
