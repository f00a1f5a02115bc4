"""What share of the sensed force every taxel feels in every session, with standard errors that know the colour of the noise.

Per session, whitened residual = sum over taxels of (change of its share) x d(simulated)/d(share) + the same for the other unknowns of
the model, by least squares. The other unknowns are held near the joint fit, so that a skin which differs a little from session to
session is not taken for a change of shares. Only ratios between taxels mean anything: the stiffness k1 is their common scale.
"""

from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.baseline.fitting import tangents
from skin_ident.criticism.baseline.residual import placed, residual, simulated
from skin_ident.criticism.baseline.unknowns import unknowns
from skin_ident.criticism.gates.gate import by_block
from skin_ident.criticism.noise.whitening import Whitener, stack
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

PROBE = 0.01  # of the largest share, for the differences
STEPS = 3  # to where taxels are that read nothing of small forces; where all are linear the first gets there
MODEL = 3e-4  # of the largest share: what the model's own form leaves in a static share
RESOLVED = 0.3  # of a converter's step, by which its levels may be off: a taxel that feels few steps tells its share no better


@dataclass(frozen=True, eq=False)
class Gains:
    """`value` (S, T) shares of the sensed force and `covariance` (S, T, T), session by session."""

    value: np.ndarray
    covariance: np.ndarray

    def of(self, sessions: list[int]) -> "Gains":
        """The same for some of the sessions."""
        return Gains(self.value[sessions], self.covariance[sessions])

    @property
    def level_error(self) -> float:
        """The relative standard error of what all taxels of a session feel together, in the session where that is worst."""
        weights = [g @ np.linalg.solve(c, g) for g, c in zip(self.value, self.covariance, strict=True)]
        return float(1.0 / np.sqrt(max(min(weights), 1e-300)))

    def at_own_levels(self, shares: np.ndarray) -> np.ndarray:
        """Shares (S, T), those of each session at the level that was measured there, by least squares."""
        level = np.sum(shares * self.value, axis=1) / np.maximum(np.sum(shares**2, axis=1), 1e-300)
        return shares * level[:, None]

    def loosened(self, taxel: int, sessions: list[int], relative: float) -> "Gains":
        """The same, where one taxel may have had another gain in some of the sessions, by a standard deviation of `relative`."""
        covariance = self.covariance.copy()
        covariance[sessions, taxel, taxel] += (relative * self.value[sessions, taxel]) ** 2
        return Gains(self.value, covariance)


def gains(model: Model, sessions: list[Session], noise: Whitener) -> Gains:
    """Shares of every taxel in every session, starting from those of the fitted `model`."""
    found = [_of(model, s, noise) for s in sessions]
    return Gains(np.array([g for g, _ in found]), np.array([c for _, c in found]))


def _of(model: Model, s: Session, noise: Whitener) -> tuple[np.ndarray, np.ndarray]:
    value = np.array(placed(model, s).shares)
    for _ in range(STEPS):
        value, covariance = _step(*with_shares(model, s, value), noise)
    return value, covariance + np.diag(_swallowed(model, s, value) ** 2 + _unread(model, s) ** 2)


def _step(model: Model, s: Session, noise: Whitener) -> tuple[np.ndarray, np.ndarray]:
    """Shares and their covariance by one step of Gauss and Newton from those of the session."""
    shares = np.array(placed(model, s).shares)
    others = tuple(u for u in unknowns(model, s) if u.part != "shares" and u.label != "k1")
    D = np.concatenate([_by_share(model, s), tangents(model, [s], others)[0]])
    J, r = stack([D], [s], noise), stack([residual(model, s)], [s], noise)
    near = np.r_[np.full(shares.size, 1e-9), np.ones(len(others))]  # the others: one scaled unit either way
    inverse = np.linalg.inv(J.T @ J + np.diag(near))
    change = inverse @ (J.T @ r)
    own = inverse[: shares.size, : shares.size]
    inflated = max(1.0, _scatter(J * (r - J @ change)[:, None], inverse, own, s))
    floor = (MODEL * shares.max()) ** 2 * np.eye(shares.size)
    return shares + change[: shares.size], inflated * own + floor


def _scatter(scores: np.ndarray, inverse: np.ndarray, own: np.ndarray, s: Session) -> float:
    """How much more the shares scatter than white residuals would let them, as the blocks of the session tell, (R, U) scores: noise that
    grows with the load, or has a longer memory than its model.

    Source: H. White, Econometrica 48, 817 (1980), by blocks as in W. Newey, K. West, Econometrica 55, 703 (1987).
    """
    by_channel = scores.T.reshape(len(inverse), len(s.channels), -1)
    blocks = by_block(by_channel.sum(axis=1), s)
    found = (inverse @ blocks @ blocks.T @ inverse)[: len(own), : len(own)]
    return float(np.trace(np.linalg.solve(own, found))) / len(own)


def _swallowed(model: Model, s: Session, value: np.ndarray) -> np.ndarray:
    """What the shares (T,) may be wrong by where taxels read nothing of small forces, and these feel no more than that."""
    threshold = sum(e.threshold for e in model.effects if e.cause == "dead_zone" and e.where.startswith("taxel"))
    least = threshold / (model.dispersion.k1 * s.motion.x.max())
    return np.where(value < 2.0 * least, least, 0.0)


def _unread(model: Model, s: Session) -> np.ndarray:
    """What the shares (T,) may be wrong by for the steps of the taxels' converters, which are seen against the largest force there is."""
    largest = np.abs(_by_share(model, s)).max(axis=(1, 2))
    steps = np.array(s.steps[-largest.size :])
    return RESOLVED * steps / np.maximum(largest, 1e-300)


def _by_share(model: Model, s: Session) -> np.ndarray:
    """d(simulated)/d(share) of every taxel, (T, C, n), in the common band."""
    shares = np.array(placed(model, s).shares)
    base, step = simulated(model, s), PROBE * shares.max()
    probed = [simulated(*with_shares(model, s, shares + step * row)) for row in np.eye(shares.size)]
    return np.array([s.band.thin(y - base) / step for y in probed])


def with_shares(model: Model, s: Session, shares: np.ndarray) -> tuple[Model, Session]:
    """Model and session such that this session's taxels feel `shares` (T,) of the sensed force."""
    shares = np.maximum(shares, 0.0)
    if s.spread is None:
        return replace(model, shares=tuple(shares.tolist())), s
    return replace(model, shares=(1.0,) * shares.size), replace(s, spread=shares, pinned=True)
