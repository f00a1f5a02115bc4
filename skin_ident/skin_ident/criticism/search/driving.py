"""What a load cell whose force drives a test without depth may have, in the place of what its taxels or the skin seem to have.

Taxel i is simulated from the measured force f as s_i H(f). A load cell that reads F + e where F presses makes that s_i H(e) too much in
every taxel: all of them together read too little by their shares of e. So what all taxels have alike, or the skin under them, the load cell
may have the other way round, if it is something that load cells have: one that creeps up for skin that relaxes, one that lags for taxels
that come early, one that clips for skin that stiffens under great forces, one whose zero is too high for skin that begins to under small
ones, one that rubs for taxels that stay behind. What one taxel of several has, it has not.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice

import numpy as np

from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.search.growing import instances, lacking
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.rivals import Rival
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import DAMPING, LOOP_OF_LOAD_CELL, RELAXATION, STIFFER, SWALLOWS, Key
from skin_models.effects.rate_dependence import EyringDamping, OneSidedDamping, PowerDamping
from skin_models.model import Model

ALIKE = 0.2  # of the squares of a change, by which the record may be further from a common course of all taxels
GREATEST = 0.99  # of the samples are at forces up to those that are called the greatest
BEGINS, FASTER = 0.02, 0.1  # of the greatest force, above which a change begins; of its slope, by which it grows faster there
MOVES = 0.1  # of the rms rate of the force, above which it rises or falls
FEWEST = 10  # samples that show a slope
EITHER_WAY = ("force_offset", "drift", "gain_error")  # that sensors have with either sign
FRICTION, LATE, CLIPS = ("friction", "load_cell"), ("lag", "load_cell"), ("saturation", "load_cell")
CREEP, SLOPE, ZERO = ("drift", "load_cell"), ("gain_error", "load_cell"), ("force_offset", "load_cell")


@dataclass(frozen=True)
class _Change:
    """What some causes at their places (`keys`, of one cause) add to the taxels of sessions, by the effects of a model, or by `runs`."""

    model: Model
    keys: tuple[Key, ...]
    runs: tuple[Run, ...]
    sessions: list[Session]

    @cached_property
    def rows(self) -> list[tuple[np.ndarray, ...]]:
        """By session the rate of the driving force (n,), what is simulated without them, what they add to that, and what is left with them
        (T, n), in the band."""
        plain = self.model
        for key in self.keys:
            plain = lacking(plain, *key)
        return [self._of(s, plain) for s in self.sessions]

    def _of(self, s: Session, plain: Model) -> tuple[np.ndarray, ...]:
        before, after = simulated(plain, s), simulated(self.model, s)
        added = sum((r.values[s.name] for r in self.runs if s.name in r.values), after - before)
        taxels = (s.weight * y for y in (s.band.thin(before), s.band.thin(added), s.measured - s.band.thin(after)))
        return np.gradient(s.band.thin(s.drive[None])[0]), *(y[s.taxel_rows] for y in taxels)

    @property
    def common(self) -> bool:
        """Whether it may as well be one course that all taxels have by their shares: the record is hardly further from that."""
        worse = there = 0.0
        for _, plain, added, left in self.rows:
            shares = np.sqrt(np.mean(plain**2, axis=1, keepdims=True))
            one = shares * (shares.T @ added) / max(float(np.sum(shares**2)), 1e-300)
            worse += float(np.sum((left + added - one) ** 2 - left**2))
            there += float(np.sum(added**2))
        return there > 0.0 and worse < ALIKE * there

    @property
    def ahead(self) -> float:
        """Above nothing where the taxels read more by it while the force rises than while it falls."""
        return sum(float(np.sum(np.sign(rate) * (np.abs(rate) > MOVES * rate.std()) * added)) for rate, _, added, _ in self.rows)

    @property
    def bends(self) -> tuple[bool, bool]:
        """Whether what the taxels read more by it begins above some force and then grows in proportion to it, and whether it grows faster
        among the greatest forces than before."""
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
        """Whether damping that is another on the way in than on the way out lets the taxels read before the load cell, on either way."""
        d, more = self.model.dispersion, sum(getattr(e, "c_sensed", 0.0) for e in instances(self.model, *self.keys[0]))
        return d.k1 > 0.0 and (d.b1 + abs(more)) / d.k1 > d.recovery


def with_load_cell(named: list[Named], model: Model, runs: list[Run], sessions: list[Session]) -> list[Named]:
    """The findings in `sessions`, `model` and `runs` having all of them; where force drives those, with what the load cell may have in
    their place before all their other names."""
    if not named or sessions[0].drive is None:
        return named
    told = [_beside(n, list(_of_load_cell(n, named, model, runs, sessions))) for n in named]
    if not any(FRICTION in (a.key for a in n.alternatives) for n in told):
        return told
    return [_beside(n, [Rival(*FRICTION, 0.0)]) if n.cause == SWALLOWS else n for n in told]  # what rubs does so in the air, too


def _beside(n: Named, rivals: list[Rival]) -> Named:
    known = {a.key: a for a in n.alternatives}
    return replace(n, alternatives=()).with_rivals([*(known.get(r.key, r) for r in rivals), *n.alternatives])


def _of_load_cell(n: Named, named: list[Named], model: Model, runs: list[Run], sessions: list[Session]) -> Iterator[Rival]:
    """What the load cell may have in the place of a finding, or of one of its other names."""
    keys = _every_taxel(n, named, sessions[0])
    own = tuple(r for r in runs if r.course.key in keys)
    if n.is_another_skin:
        yield Rival(*SLOPE, 0.0)
    elif keys:
        yield from (Rival(*key, 0.0) for key in _inverse(_Change(model, keys, own, sessions)))
    for a in n.alternatives:
        if a.model is not None:  # of the same kind alone: these are many names already
            yield from (Rival(*key, a.short_by) for key in islice(_inverse(_Change(a.model, (a.key,), (), sessions)), 1))
        elif a.where == "taxel" and a.cause in EITHER_WAY and sessions[0].n_taxels == 1:
            yield Rival(a.cause, "load_cell", a.short_by)


def _every_taxel(n: Named, named: list[Named], session: Session) -> tuple[Key, ...]:
    """The places at which a finding's cause was named, its own or those of every taxel; () where it has only some."""
    if not n.where.startswith("taxel_"):
        return (n.key,)
    every = {f"taxel_{i}" for i in range(session.n_taxels)} - set(session.stuck)
    keys = tuple(dict.fromkeys(other.key for other in named if other.cause == n.cause and other.where in every))
    return keys if len(keys) == len(every) else ()


def _inverse(change: _Change) -> Iterator[Key]:
    """The faults of a load cell that add the same to all taxels, if there are any."""
    cause, where = change.keys[0]
    if not (where == "skin" or where.startswith(("taxel", "clock"))) or not change.common:
        return
    if where.startswith("taxel") and cause in EITHER_WAY:
        yield cause, "load_cell"
    elif cause == "hysteresis":
        yield LOOP_OF_LOAD_CELL
        if change.ahead < 0.0:
            yield FRICTION
    elif change.keys[0] == RELAXATION:
        yield CREEP
    elif change.keys[0] == STIFFER:
        yield from (key for key, bends in zip((ZERO, CLIPS), change.bends, strict=True) if bends)
    elif change.keys[0] == DAMPING:
        yield from _of_damping(change)
    elif cause == "time_shift" and change.ahead > 0.0:
        yield LATE


def _of_damping(change: _Change) -> Iterator[Key]:
    """Damping that hardly grows with speed is friction, if the taxels stay behind by it; such as is another in than out is such a lag."""
    effects = instances(change.model, *change.keys[0])
    slow = any(isinstance(e, EyringDamping) or (isinstance(e, PowerDamping) and e.exponent < 1.0) for e in effects)
    if slow and change.ahead < 0.0:
        yield FRICTION
    if any(isinstance(e, OneSidedDamping) for e in effects) and change.early:
        yield LATE
