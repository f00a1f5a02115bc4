"""One survey: everything that the catalogue offers, ranked on top of the present model."""

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from functools import cached_property
from operator import is_

import numpy as np

from skin_ident.criticism.baseline.fitting import Fit, sliding, tangents, unpressed
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.baseline.unknowns import scales, unknowns, values
from skin_ident.criticism.courses.course import bends_of_each_session
from skin_ident.criticism.noise.estimate import RICHEST, less, noise_model
from skin_ident.criticism.noise.pursuit import pursue
from skin_ident.criticism.noise.whitening import Stacked, Whitener, stack
from skin_ident.criticism.projection import basis
from skin_ident.criticism.search.proposals import Direction, between
from skin_ident.criticism.search.ranking import Projected, Ranked, project, rank
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import AT_FULL_RATE, Key
from skin_models.model import Model

FORMS = 5  # directions per cause that may mend its form, of either sign, since a form may have too much of something as well


@dataclass(frozen=True)
class Survey:
    """Every cause ranked against the residual of `model` in `sessions`, under the noise model that the survey itself found.

    `kept` holds the directions of sessions by name while this is the latest survey: they are large, and expensive to compute. `fits` holds
    what causes came to that were fitted beside the model, by cause and place, as `growing.grow` returns them.
    """

    model: Model
    noise: Whitener
    projected: Projected
    ranked: tuple[Ranked, ...]
    sessions: tuple[Session, ...] = field(default=(), compare=False, repr=False)
    kept: dict[str, tuple[Session, np.ndarray]] = field(default_factory=dict, compare=False, repr=False)
    fits: dict[Key, tuple[Fit, ...]] = field(default_factory=dict, compare=False, repr=False)

    def is_of(self, model: Model, sessions: list[Session]) -> bool:
        """Whether this is the survey of that very model in these very sessions."""
        return self.model is model and self._is_in(sessions)

    def _is_in(self, sessions: list[Session]) -> bool:
        return len(sessions) == len(self.sessions) and all(map(is_, sessions, self.sessions))

    def without_directions(self) -> "Survey":
        """The same without the directions in memory, which are computed again when they are asked for."""
        return replace(self, kept={})

    def directions_of(self, session: Session) -> tuple[np.ndarray, int]:
        """All directions in which the simulation of a session may change, (M, C, n): first the model's own unknowns, whose number is
        returned too."""
        mine = unknowns(self.model, session)
        of, rows = self.kept.get(session.name, (None, np.zeros(0)))
        if of is not session:
            own = tangents(self.model, [session], mine)[0]
            rows = between(own, self.model, self.projected.which, session, own[:0])
            self.kept[session.name] = session, rows
        return rows, len(mine)

    @property
    def explained_by_everything(self) -> float:
        """What the richest set of directions explains beside the model's own unknowns, less the charge for each direction used."""
        return self._richest[1]

    def richest(self, sessions: list[Session]) -> np.ndarray:
        """The coefficients (M,) of the richest set of directions that explains the residual of some sessions."""
        return self._richest[0] if self._is_in(sessions) else self._pursued(sessions)[0]

    @cached_property
    def _richest(self) -> tuple[np.ndarray, float]:
        return self._pursued(list(self.sessions))

    def _pursued(self, sessions: list[Session]) -> tuple[np.ndarray, float]:
        """The coefficients (M,) of the richest set of directions in some sessions, and what it explains there beside the model's own
        unknowns, less the charge for each direction used."""
        A, r, own = self._whitened(sessions)
        z = pursue(A, r, own + RICHEST, own)
        charge = np.log(max(np.count_nonzero(r), 2)) * np.count_nonzero(z[own:])
        return z, float(r @ r - np.sum((r - A @ z) ** 2) - charge)

    def of_its_own(self, cause: Key, others: Collection[Key]) -> float:
        """Share of what `cause` explains that more of the `others` would not explain: near 0 where it may stand for what their forms lack,
        and 1 where small amounts of it explain nothing."""
        A, r, own = self._whitened(list(self.sessions))

        def explained(causes: Collection[Key]) -> float:
            offered = np.zeros(A.shape[1], bool)
            offered[own : own + len(self.projected.which)] = [d.key in causes for d in self.projected.which]
            return float(r @ r - np.sum((r - A @ pursue(A, r, own + FORMS * len(causes), own, offered)) ** 2))

        without, theirs, its, both = map(explained, (set(), others, {cause}, {cause, *others}))
        return (both - theirs) / (its - without) if its > without else 1.0

    def _whitened(self, sessions: list[Session]) -> tuple[np.ndarray, np.ndarray, int]:
        """Of some sessions: all directions, whitened, (rows, M), the whitened residual (rows,), and how many of the M are the model's own
        unknowns."""
        every = [self.directions_of(s) for s in sessions]
        A = stack([rows for rows, _ in every], sessions, self.noise)
        r = stack([residual(self.model, s) for s in sessions], sessions, self.noise)
        return A, r, every[0][1]

    def left_by_everything(self, session: Session) -> np.ndarray:
        """Residual (C, n) N of a session after the model's own unknowns and the richest set of directions are fitted to it."""
        every, own = self.directions_of(session)
        return less([residual(self.model, session)], Stacked([every], [session]), own, self.noise)[0]


def survey(model: Model, sessions: list[Session], which: tuple[Direction, ...], noise: Whitener | None = None) -> Survey:
    """Rank all causes. `noise` is fitted to the residual of the richest set of directions unless it is given."""
    mine = unknowns(model, sessions[0])
    own, known = len(mine), len(mine) + len(which)
    residuals, every = [residual(model, s) for s in sessions], _everything(model, sessions, which)
    noise = noise or _beside(every, residuals, own, which)
    A, r = every.under(noise), stack(residuals, sessions, noise)
    J = A[:, :own]
    free = unpressed(values(model, mine), mine, J.T @ r)
    # An unknown that is pressed against its bound, such as a mass of zero, explains nothing.
    J = (J @ sliding(mine, scales(model, mine), free))[:, free]
    projected = project(which, A[:, own:known], basis(J), r)
    kept = {s.name: (s, rows[:known]) for s, rows in zip(sessions, every.rows, strict=True)}
    return Survey(model, noise, projected, tuple(r for r in rank(projected) if r.cause != AT_FULL_RATE), tuple(sessions), kept)


def noise_beside(model: Model, sessions: list[Session], which: tuple[Direction, ...]) -> Whitener:
    """The noise model that a survey finds, without the ranking."""
    residuals = [residual(model, s) for s in sessions]
    return _beside(_everything(model, sessions, which), residuals, len(unknowns(model, sessions[0])), which)


def _everything(model: Model, sessions: list[Session], which: tuple[Direction, ...]) -> Stacked:
    """All directions: the model's own unknowns, those of the catalogue, and bends that belong to one session alone."""
    own, bends = tangents(model, sessions, unknowns(model, sessions[0])), bends_of_each_session(model, sessions)
    rows = [between(before, model, which, s, after) for before, s, after in zip(own, sessions, bends, strict=True)]
    return Stacked(rows, sessions)


def _beside(every: Stacked, residuals: list[np.ndarray], own: int, which: tuple[Direction, ...]) -> Whitener:
    return noise_model(residuals, every, own, _offered(which, own, len(every.rows[0])))


def _offered(which: tuple[Direction, ...], own: int, rows: int) -> np.ndarray:
    """Mask (M,) of the directions that may explain more than noise: the model's own, small amounts of every cause, and bends of each
    session's own. Large amounts of the same causes would be counted twice, and so would play of the encoder, of which laws of damping and
    loops explain nearly as much."""
    offered = np.ones(rows, bool)
    offered[own : own + len(which)] = [d.probe < 1.0 and not d.effect.supple for d in which]
    return offered


def detectable(p: Projected, z: float) -> np.ndarray:
    """Amount (M,) of each direction, in typical sizes, that would reach `z` standard errors; inf where the data do not excite it."""
    return np.where(p.energies > 0.0, z / np.sqrt(np.where(p.energies > 0.0, p.energies, 1.0)), np.inf)
