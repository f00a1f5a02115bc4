"""Skin that differs from session to session, for instance a hundredth stiffer today than on the day that was fitted.

In a held-out session such a difference leaves a residual that is slow and large, belongs to no cause, and may hide the gain of a true one.
So each parameter in `NUMBERS` may be off by a share theta of its own in each session, theta ~ N(0, s^2) with s = `STRAYS`, in both of the
models that are compared:

    theta = (J'J + 1/s^2)^-1 J' r,    2 log p - 2 log p0 = r' J theta - log det(1 + s^2 J'J)

Here r is the whitened residual, J what the simulation changes by per unit of theta, and r - J theta the residual that remains; p is the
marginal likelihood with theta, and p0 the likelihood without (N. M. Laird, J. H. Ware, Random-effects models for longitudinal data,
Biometrics 38 (1982) 963-974).
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.fitting import tangents
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.baseline.settling import settled
from skin_ident.criticism.baseline.unknowns import Unknown, scales, unknowns, values
from skin_ident.criticism.noise.whitening import Whitener, stack
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

NUMBERS = ("k1", "b1", "k2", "b2")  # parameters of the dispersion model that may differ per session
STRAYS = 0.03  # s, standard deviation of each parameter between sessions, as a share of it
TIMES, SETTLED = 4, 1e-4  # estimates in turn at most, and the change of a parameter below which they stop


def of_the_skin(model: Model, s: Session) -> tuple[Unknown, ...]:
    """The unknowns among `NUMBERS` that may differ per session. None where a force drives the session: there a stiffness acts as a gain."""
    return tuple(u for u in unknowns(model, s) if u.label in NUMBERS) if s.drive is None else ()


def changes(model: Model, s: Session) -> np.ndarray:
    """What the simulation of a session changes by per unit of each theta, (U, C, n) N in the common band."""
    which = of_the_skin(model, s)
    shares = values(model, which) / scales(model, which) / [s.skin.get(u.label, 1.0) for u in which]
    return tangents(model, [s], which)[0] * shares[:, None, None]


def solved(J: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, float]:
    """Estimate theta (U,) of the module's equation from J (R, U) and r (R,); also its log-likelihood ratio, in twice nats."""
    gram, product = J.T @ J, J.T @ r
    theta = np.linalg.solve(gram + np.eye(len(gram)) / STRAYS**2, product)
    return theta, float(theta @ product - np.linalg.slogdet(np.eye(len(gram)) + STRAYS**2 * gram)[1])


def deviations(model: Model, s: Session) -> np.ndarray:
    """theta (U,) of a session as it is; 0 where it has no skin parameters of its own."""
    return np.array([s.skin.get(u.label, 1.0) - 1.0 for u in of_the_skin(model, s)])


def deviating(model: Model, s: Session, theta: np.ndarray) -> Session:
    """A session with the skin parameters that theta (U,) gives it."""
    return replace(s, skin={u.label: 1.0 + float(x) for u, x in zip(of_the_skin(model, s), theta, strict=True)})


def with_own_skin(model: Model, s: Session, noise: Whitener) -> Session:
    """A session with skin parameters of its own, estimated from it."""
    for _ in range(TIMES):
        J, before = stack([changes(model, s)], [s], noise), deviations(model, s)
        theta, _ = solved(J, stack([residual(model, s)], [s], noise) + J @ before)
        s = deviating(model, s, theta)
        if np.abs(theta - before).max() < SETTLED:
            break
    return s


def left_beside_own_skin(model: Model, session: Session, noise: Whitener) -> np.ndarray:
    """Residual (C, n) N of a session after skin parameters of the session's own are estimated from it."""
    s = settled(model, session)
    own, e = changes(model, s), residual(model, s)
    theta, _ = solved(stack([own], [s], noise), stack([e], [s], noise))
    return e - np.tensordot(theta, own, 1)
