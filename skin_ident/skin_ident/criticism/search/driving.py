"""What a load cell may have, where its force drives a test without depth, in the place of what its taxels or the skin seem to have.

Taxel i is simulated from the measured force f as s_i H(f). If the load cell reads F + e where F presses, every taxel is simulated too high
by s_i H(e): all taxels together seem to read too little, by their shares of e. So what all taxels have alike, or the skin under them, may
be the opposite fault of the load cell, if load cells have such a fault:

- a load cell that creeps up looks like skin that relaxes;
- one that lags, like taxels that come early;
- one that clips, like skin that stiffens under great forces;
- one whose zero is too high, like skin that begins to stiffen under small forces;
- one with friction, like taxels that stay behind.

What one of several taxels has alone cannot come from the load cell.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice

import numpy as np

from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.rivals import Rival
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import (
    CEILING_OF_LOAD_CELL,
    CREEP_OF_LOAD_CELL,
    DAMPING,
    DEAD_ZONE,
    FORCE_OFFSET,
    FRICTION_OF_LOAD_CELL,
    GAIN_ERROR,
    GAIN_OF_LOAD_CELL,
    LAG_OF_LOAD_CELL,
    LOOP_OF_LOAD_CELL,
    RELAXATION,
    STIFFER,
    ZERO_OF_LOAD_CELL,
    Key,
)
from skin_models.effects.rate_dependence import EyringDamping, OneSidedDamping, PowerDamping
from skin_models.model import Model

ALIKE = 0.2  # share of the squares of a change, by which a common course of all taxels may fit the record less well
GREATEST = 0.99  # quantile of the force that is taken for its greatest
BEGINS, FASTER = 0.02, 0.1  # of the greatest force, above which a change begins; of its slope, by which it grows faster at the top
MOVES = 0.1  # of the standard deviation of the force's rate, above which the force rises or falls
FEWEST = 10  # samples at least, to find a slope
EITHER_WAY = (FORCE_OFFSET, "drift", GAIN_ERROR)  # faults that sensors have with either sign


@dataclass(frozen=True)
class _Change:
    """What one cause at some places (`keys`) adds to the taxels of sessions, by the effects of a model and by `runs` of courses."""

    model: Model
    keys: tuple[Key, ...]
    runs: tuple[Run, ...]
    sessions: list[Session]

    @cached_property
    def rows(self) -> list[tuple[np.ndarray, ...]]:
        """By session, in the band: the rate of the driving force (n,), then in the taxels (T, n) the simulation without the cause, what the
        cause adds to it, and the residual with the cause."""
        plain = self.model.lacking(*self.keys)
        return [self._of(s, plain) for s in self.sessions]

    def _of(self, s: Session, plain: Model) -> tuple[np.ndarray, ...]:
        before, after = simulated(plain, s), simulated(self.model, s)
        added = sum((r.values[s.name] for r in self.runs if s.name in r.values), after - before)
        taxels = (s.weight * y for y in (s.band.thin(before), s.band.thin(added), s.measured - s.band.thin(after)))
        return np.gradient(s.band.thin(s.drive[None])[0]), *(y[s.taxel_rows] for y in taxels)

    @property
    def common(self) -> bool:
        """Whether the record is fitted almost as well by one course that all taxels have in proportion to their shares."""
        worse = there = 0.0
        for _, plain, added, left in self.rows:
            shares = np.sqrt(np.mean(plain**2, axis=1, keepdims=True))
            one = shares * (shares.T @ added) / max(float(np.sum(shares**2)), 1e-300)
            worse += float(np.sum((left + added - one) ** 2 - left**2))
            there += float(np.sum(added**2))
        return there > 0.0 and worse < ALIKE * there

    @property
    def ahead(self) -> float:
        """Positive where the cause makes the taxels read more while the force rises than while it falls."""
        return sum(float(np.sum(np.sign(rate) * (np.abs(rate) > MOVES * rate.std()) * added)) for rate, _, added, _ in self.rows)

    @property
    def bends(self) -> tuple[bool, bool]:
        """Whether the change in the taxels begins above some force and then grows in proportion to it, and whether it grows faster among
        the greatest forces than below them."""
        force = np.concatenate([s.band.thin(s.drive[None])[0] for s in self.sessions])
        more = np.concatenate([np.sum(added, axis=0) for _, _, added, _ in self.rows])
        top = float(np.quantile(force, GREATEST))

        def line(low: float, high: float) -> tuple[float, float]:
            within = (force > low * top) & (force < high * top)
            return tuple(np.polyfit(force[within], more[within], 1)) if np.count_nonzero(within) > FEWEST else (0.0, 0.0)

        (before, begins), (last, _) = line(0.25, 0.75), line(0.75, 1.0)
        return begins < -BEGINS * before * top < 0.0, last - before > FASTER * max(abs(before), abs(last))

    @property
    def early(self) -> bool:
        """Whether damping that differs between the way in and the way out makes the taxels read before the load cell on either way."""
        d, more = self.model.dispersion, sum(getattr(e, "c_sensed", 0.0) for e in self.model.having(self.keys[0]))
        return d.k1 > 0.0 and (d.b1 + abs(more)) / d.k1 > d.recovery


def with_load_cell(named: list[Named], model: Model, runs: list[Run], sessions: list[Session]) -> list[Named]:
    """The findings in `sessions`, where `model` and `runs` have all of them. Where a force drives the sessions, what the load cell may have
    in place of a finding comes before all its other names."""
    if not named or sessions[0].drive is None:
        return named
    told = [_beside(n, list(_of_load_cell(n, named, model, runs, sessions))) for n in named]
    if not any(FRICTION_OF_LOAD_CELL in (a.key for a in n.alternatives) for n in told):
        return told
    # Friction acts in the air as well.
    return [_beside(n, [Rival(*FRICTION_OF_LOAD_CELL, 0.0)]) if n.cause == DEAD_ZONE else n for n in told]


def _beside(n: Named, rivals: list[Rival]) -> Named:
    known = {a.key: a for a in n.alternatives}
    return replace(n, alternatives=()).with_rivals([*(known.get(r.key, r) for r in rivals), *n.alternatives])


def _of_load_cell(n: Named, named: list[Named], model: Model, runs: list[Run], sessions: list[Session]) -> Iterator[Rival]:
    """What the load cell may have in the place of a finding, or of one of its alternatives."""
    keys = _every_taxel(n, named, sessions[0])
    own = tuple(r for r in runs if r.course.key in keys)
    if n.is_another_skin:
        yield Rival(*GAIN_OF_LOAD_CELL, 0.0)
    elif keys:
        yield from (Rival(*key, 0.0) for key in _inverse(_Change(model, keys, own, sessions)))
    for a in n.alternatives:
        if a.model is not None:  # the first alone, which is of the same kind: these are many names already
            yield from (Rival(*key, a.short_by) for key in islice(_inverse(_Change(a.model, (a.key,), (), sessions)), 1))
        elif a.where == "taxel" and a.cause in EITHER_WAY and sessions[0].n_taxels == 1:
            yield Rival(a.cause, "load_cell", a.short_by)


def _every_taxel(n: Named, named: list[Named], session: Session) -> tuple[Key, ...]:
    """The places at which a finding's cause was named: its own, or those of every taxel; () where only some taxels have it."""
    if not n.where.startswith("taxel_"):
        return (n.key,)
    every = {f"taxel_{i}" for i in range(session.n_taxels)} - set(session.stuck)
    keys = tuple(dict.fromkeys(other.key for other in named if other.cause == n.cause and other.where in every))
    return keys if len(keys) == len(every) else ()


def _inverse(change: _Change) -> Iterator[Key]:
    """The faults of a load cell that would add the same to all taxels, if there are any."""
    cause, where = change.keys[0]
    if not (where == "skin" or where.startswith(("taxel", "clock"))) or not change.common:
        return
    if where.startswith("taxel") and cause in EITHER_WAY:
        yield cause, "load_cell"
    elif cause == "hysteresis":
        yield LOOP_OF_LOAD_CELL
        if change.ahead < 0.0:
            yield FRICTION_OF_LOAD_CELL
    elif change.keys[0] == RELAXATION:
        yield CREEP_OF_LOAD_CELL
    elif change.keys[0] == STIFFER:
        yield from (key for key, bends in zip((ZERO_OF_LOAD_CELL, CEILING_OF_LOAD_CELL), change.bends, strict=True) if bends)
    elif change.keys[0] == DAMPING:
        yield from _of_damping(change)
    elif cause == "time_shift" and change.ahead > 0.0:
        yield LAG_OF_LOAD_CELL


def _of_damping(change: _Change) -> Iterator[Key]:
    """Damping that hardly grows with speed may be friction, if the taxels stay behind by it. Damping that differs between the way in and
    the way out may be a lag that does."""
    effects = change.model.having(change.keys[0])
    slow = any(isinstance(e, EyringDamping) or (isinstance(e, PowerDamping) and e.exponent < 1.0) for e in effects)
    if slow and change.ahead < 0.0:
        yield FRICTION_OF_LOAD_CELL
    if any(isinstance(e, OneSidedDamping) for e in effects) and change.early:
        yield LAG_OF_LOAD_CELL
