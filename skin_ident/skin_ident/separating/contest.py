"""How well a motion tells rival models apart.

If rival i is the truth, its signals on the motion are y_i, and what rival j cannot imitate of them is

    D_ij = min |W (y_i - y_j - J_j z - A_j a)|^2

with the common band and whitener W, the tangents J_j of everything in j that a fit may change, and the directions A_j of j's own cause
(within their signs, as in the ranking), so that another form of the same cause is no evidence. Half of D_ij is the expected log likelihood
ratio. G_i, likewise, is what cause i explains over a model without it: the criticism tells two causes apart when D exceeds a share of G.
"""

from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.baseline.fitting import tangents
from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.baseline.unknowns import unknowns
from skin_ident.criticism.noise.whitening import Whitener, stack
from skin_ident.criticism.search.proposals import Direction, bank
from skin_ident.criticism.search.ranking import project, rank
from skin_ident.criticism.sessions.band import Band
from skin_ident.criticism.sessions.parting import meeting, without_parting
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model
from skin_models.signals import Motion

GENTLE = 1.01e-3  # m/s
HASTY = 0.02  # of a moment that is compared, the most that may be met at more


@dataclass(frozen=True)
class Contender:
    """One rival: its cause, its place, and the model fitted with it."""

    cause: str
    where: str
    model: Model


@dataclass(frozen=True)
class Contest:
    """`distance` (R, R) is D_ij with the truth i along the rows, `explained` (R,) is G_i, in squared whitened units."""

    distance: np.ndarray
    explained: np.ndarray

    def __add__(self, other: "Contest") -> "Contest":
        return Contest(self.distance + other.distance, self.explained + other.explained)

    @property
    def evidence(self) -> np.ndarray:
        """Expected log likelihood ratio of every pair (R, R), whichever of the two is the truth; infinite on the diagonal."""
        return 0.5 * np.minimum(self._apart, self._apart.T)

    def margin(self, floor: float, reach: float) -> np.ndarray:
        """How many times over the criticism's bound every pair (R, R) lies: above 1 one of the two names is left."""
        apart = self._apart / np.maximum(floor, reach * self.explained)[:, None]
        return np.minimum(apart, apart.T)

    @property
    def _apart(self) -> np.ndarray:
        return np.where(np.eye(self.explained.size, dtype=bool), np.inf, self.distance)


def contest(rivals: tuple[Contender, ...], plain: Model, sessions: list[Session], noise: Whitener, which: tuple[Direction, ...]) -> Contest:
    """What the motion of `sessions` says about `rivals`; of their measured channels only how loaded they are matters.

    `plain` is the model fitted without any of them, `which` are the catalogue's directions.
    """
    signals = [[s.band.thin(simulated(r.model, s)) for s in sessions] for r in rivals]
    apart = [_unlike(rival, [_minus(y, own) for y in signals], sessions, noise, which) for rival, own in zip(rivals, signals, strict=True)]
    base = [s.band.thin(simulated(plain, s)) for s in sessions]
    own = stack(tangents(plain, sessions, unknowns(plain, sessions[0])), sessions, noise)
    explained = [_left((), np.zeros((len(own), 0)), own, stack(_minus(y, base), sessions, noise)) for y in signals]
    return Contest(np.array(apart).T, np.array(explained))


def _minus(y: list[np.ndarray], other: list[np.ndarray]) -> list[np.ndarray]:
    return [a - b for a, b in zip(y, other, strict=True)]


def _unlike(rival: Contender, differences: list[list[np.ndarray]], sessions, noise, which) -> list[float]:
    """What of each difference (C, n) per session `rival` cannot imitate."""
    mine = tuple(d for d in which if d.key == (rival.cause, rival.where))
    own = stack(tangents(rival.model, sessions, unknowns(rival.model, sessions[0])), sessions, noise)
    forms = stack(bank(rival.model, mine, sessions), sessions, noise)
    return [_left(mine, forms, own, stack(d, sessions, noise)) for d in differences]


def _left(mine: tuple[Direction, ...], forms: np.ndarray, own: np.ndarray, difference: np.ndarray) -> float:
    if not difference.any():
        return 0.0
    p = project(mine, forms, own, difference)
    return max(p.energy - sum(r.gain for r in rank(p)), 0.0)


def rehearsed(motion: Motion, like: Session, model: Model) -> Session:
    """A session of `motion` with the channels of `like`, as `model` says they would read, less the moments that a criticism leaves out.

    Contact met at speed is left out too: there the rivals differ by a jump between two samples, which telemetry takes for a spike.
    """
    band = Band(motion.dt, like.band.cutoff)
    t = band.times(motion.t)
    shape = (len(like.channels), t.size)
    hasty = meeting(motion, model.dispersion) & (np.abs(motion.v) > GENTLE)
    unread = np.zeros((len(like.channels), len(motion)))
    blank = Session(
        name="rehearsed",
        motion=motion,
        channels=like.channels,
        raw=unread,
        bridged=unread,
        band=band,
        t=t,
        measured=np.zeros(shape),
        weight=np.ones(shape) * (band.thin(hasty.astype(float)) < HASTY),
        period=motion.dt,
        drive=None if like.drive is None else np.zeros(len(motion)),
        drive_noise=like.drive_noise,
        spread=like.spread,
        contact=like.contact,
        steps=like.steps,
    )
    return without_parting(replace(blank, bridged=simulated(model, blank)), model.dispersion)
