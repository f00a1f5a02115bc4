"""Share of the sensed force that every taxel feels in every session, with standard errors that allow for coloured noise.

Per session, the whitened residual is regressed on d(simulated)/d(share) of every taxel and on the tangents of the model's other unknowns.
The other unknowns are held near the joint fit by a prior of one scaled unit, so that small differences of the skin between sessions are not
taken for changes of shares. Only ratios between taxels have a meaning: the stiffness k1 is their common scale.
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

LEAST = 1e-3  # share that is taken for the largest one in the next, where taxels feel less
PROBE = 0.01  # step of finite differences, of the largest share
STEPS = 3  # Gauss-Newton steps; one is enough unless taxels have a dead zone
MODEL = 3e-4  # of the largest share: error of a static share from the imperfect form of the model
RESOLVED = 0.3  # of a converter's step, error of its levels: it limits the share of a taxel that feels few steps


@dataclass(frozen=True, eq=False)
class Gains:
    """`value` (S, T), shares of the sensed force, and `covariance` (S, T, T), session by session."""

    value: np.ndarray
    covariance: np.ndarray

    def of(self, sessions: list[int]) -> "Gains":
        """The same for some of the sessions."""
        return Gains(self.value[sessions], self.covariance[sessions])

    @property
    def level_error(self) -> float:
        """Relative standard error of the common level of a session's taxels, in the session where it is largest."""
        weights = [g @ np.linalg.solve(c, g) for g, c in zip(self.value, self.covariance, strict=True)]
        return float(1.0 / np.sqrt(max(min(weights), 1e-300)))

    def at_own_levels(self, shares: np.ndarray) -> np.ndarray:
        """The given shares (S, T), each session scaled to the measured ones by least squares."""
        level = np.sum(shares * self.value, axis=1) / np.maximum(np.sum(shares**2, axis=1), 1e-300)
        return shares * level[:, None]

    def loosened(self, taxel: int, sessions: list[int], relative: float) -> "Gains":
        """The same, but one taxel may have another gain in some of the sessions, by a standard deviation of `relative`."""
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
    """Shares and their covariance after one Gauss-Newton step from those of the session."""
    shares = np.array(placed(model, s).shares)
    others = tuple(u for u in unknowns(model, s) if u.part != "shares" and u.label != "k1")
    D = np.concatenate([_by_share(model, s), tangents(model, [s], others)[0]])
    J, r = stack([D], [s], noise), stack([residual(model, s)], [s], noise)
    near = np.r_[np.full(shares.size, 1e-9), np.ones(len(others))]  # prior precision: shares free, the others within one scaled unit
    inverse = np.linalg.inv(J.T @ J + np.diag(near))
    change = inverse @ (J.T @ r)
    own = inverse[: shares.size, : shares.size]
    inflated = max(1.0, _scatter(J * (r - J @ change)[:, None], inverse, own, s))
    floor = (MODEL * shares.max()) ** 2 * np.eye(shares.size)
    return shares + change[: shares.size], inflated * own + floor


def _scatter(scores: np.ndarray, inverse: np.ndarray, own: np.ndarray, s: Session) -> float:
    """Ratio of the shares' variance, estimated from blocks of the session, to that for white residuals. `scores` is (R, U). It exceeds 1
    where noise grows with the load or has a longer memory than its model.

    Source: H. White, Econometrica 48, 817 (1980), by blocks as in W. Newey, K. West, Econometrica 55, 703 (1987).
    """
    by_channel = scores.T.reshape(len(inverse), len(s.channels), -1)
    blocks = by_block(by_channel.sum(axis=1), s)
    found = (inverse @ blocks @ blocks.T @ inverse)[: len(own), : len(own)]
    return float(np.trace(np.linalg.solve(own, found))) / len(own)


def _swallowed(model: Model, s: Session, value: np.ndarray) -> np.ndarray:
    """Errors (T,) of the shares of taxels with a dead zone that feel hardly more than its threshold; 0 for the others."""
    zones = [e for e in model.effects if e.cause == "dead_zone"]
    threshold = np.array([sum(e.threshold for e in zones if e.where in ("taxel", f"taxel_{i}")) for i in range(value.size)])
    least = threshold / (model.dispersion.k1 * s.motion.x.max())
    return np.where(value < 2.0 * least, least, 0.0)


def _unread(model: Model, s: Session) -> np.ndarray:
    """Errors (T,) of the shares due to the steps of the taxels' converters, relative to the largest force."""
    largest = np.abs(_by_share(model, s)).max(axis=(1, 2))
    steps = np.array(s.steps[-largest.size :])
    return RESOLVED * steps / np.maximum(largest, 1e-300)


def _by_share(model: Model, s: Session) -> np.ndarray:
    """d(simulated)/d(share) of every taxel, (T, C, n), in the common band."""
    shares = np.array(placed(model, s).shares)
    base, step = simulated(model, s), PROBE * max(shares.max(), LEAST)
    probed = [simulated(*with_shares(model, s, shares + step * row)) for row in np.eye(shares.size)]
    return np.array([s.band.thin(y - base) / step for y in probed])


def with_shares(model: Model, s: Session, shares: np.ndarray) -> tuple[Model, Session]:
    """Model and session changed so that the session's taxels feel `shares` (T,) of the sensed force."""
    shares = np.maximum(shares, 0.0)
    if s.spread is None:
        return replace(model, shares=tuple(shares.tolist())), s
    return replace(model, shares=(1.0,) * shares.size), replace(s, spread=shares, pinned=True)
