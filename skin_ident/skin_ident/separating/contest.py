"""How well a motion tells rival models apart.

If rival i is the truth, its signals on the motion are y_i. The part of them that rival j cannot imitate is

    D_ij = min |W (y_i - y_j - J_j z - A_j a)|^2    over z and a

W is the common low-pass and the whitener. J_j are the tangents of all parameters of model j. A_j are the directions of j's own cause, with
coefficients of the sign that physics allows, as in the ranking, so that another form of the same cause is no evidence. Half of D_ij is the
expected log-likelihood ratio. G_i is defined likewise as what cause i explains over a model without it. The criticism tells two causes
apart when D exceeds a share of G.
"""

from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.baseline.fitting import tangents
from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.baseline.unknowns import unknowns
from skin_ident.criticism.noise.whitening import Whitener, stack
from skin_ident.criticism.projection import basis
from skin_ident.criticism.search.proposals import Direction, bank
from skin_ident.criticism.search.ranking import project, rank
from skin_ident.criticism.sessions.band import Band
from skin_ident.criticism.sessions.parting import meeting, without_parting
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model
from skin_models.signals import Motion

GENTLE = 1.01e-3  # m/s, highest speed at which contact may be made in a sample that is compared
HASTY = 0.02  # largest share of a compared (low-passed) sample that may come from faster contact


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
        """Expected log-likelihood ratio of every pair (R, R), the smaller of the two possible truths; infinite on the diagonal."""
        return 0.5 * np.minimum(self._apart, self._apart.T)

    def margin(self, floor: float, reach: float) -> np.ndarray:
        """Distance of every pair (R, R) over the bound from which the criticism tells two causes apart; above 1, one of them is left."""
        apart = self._apart / np.maximum(floor, reach * self.explained)[:, None]
        return np.minimum(apart, apart.T)

    @property
    def _apart(self) -> np.ndarray:
        return np.where(np.eye(self.explained.size, dtype=bool), np.inf, self.distance)


def contest(rivals: tuple[Contender, ...], plain: Model, sessions: list[Session], noise: Whitener, which: tuple[Direction, ...]) -> Contest:
    """Distances and explained energies of `rivals` on the motion of `sessions`. Measured values do not enter, except for the load on the
    channels, where the noise grows with it.

    `plain` is the model fitted without any of the rivals; `which` are the catalogue's directions.
    """
    signals = [[s.band.thin(simulated(r.model, s)) for s in sessions] for r in rivals]
    apart = [_unlike(rival, [_minus(y, own) for y in signals], sessions, noise, which) for rival, own in zip(rivals, signals, strict=True)]
    base = [s.band.thin(simulated(plain, s)) for s in sessions]
    own = basis(stack(tangents(plain, sessions, unknowns(plain, sessions[0])), sessions, noise))
    explained = [_left((), np.zeros((len(own), 0)), own, stack(_minus(y, base), sessions, noise)) for y in signals]
    return Contest(np.array(apart).T, np.array(explained))


def _minus(y: list[np.ndarray], other: list[np.ndarray]) -> list[np.ndarray]:
    return [a - b for a, b in zip(y, other, strict=True)]


def _unlike(rival: Contender, differences: list[list[np.ndarray]], sessions, noise, which) -> list[float]:
    """The squared whitened norm of the part of each difference (a list of (C, n) per session) that `rival` cannot imitate."""
    mine = tuple(d for d in which if d.key == (rival.cause, rival.where))
    own = basis(stack(tangents(rival.model, sessions, unknowns(rival.model, sessions[0])), sessions, noise))
    forms = stack(bank(rival.model, mine, sessions), sessions, noise)
    return [_left(mine, forms, own, stack(d, sessions, noise)) for d in differences]


def _left(mine: tuple[Direction, ...], forms: np.ndarray, own: np.ndarray, difference: np.ndarray) -> float:
    if not difference.any():
        return 0.0
    p = project(mine, forms, own, difference)
    return max(p.energy - sum(r.gain for r in rank(p)), 0.0)


def rehearsed(motion: Motion, like: Session, model: Model) -> Session:
    """A session of `motion` with the channels of `like` as `model` simulates them, without the samples that a criticism leaves out.

    Samples where contact is made at more than GENTLE are left out too: there the rivals differ by a jump between two samples, which
    telemetry takes for a spike.
    """
    band = Band(motion.dt, like.band.cutoff, like.band.slowest)
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
        heaviest=like.heaviest,
        hung=like.hung,
        spread=like.spread,
        contact=like.contact,
        steps=like.steps,
    )
    read = simulated(model, replace(blank, pinned=True))  # shares of its own are fitted to what it reads, which it has yet to read
    return without_parting(replace(blank, bridged=read, measured=band.thin(read)), model.dispersion)
