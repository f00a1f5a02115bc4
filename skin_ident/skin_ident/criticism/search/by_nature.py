"""Causes that are the same signal by nature in these data: nobody can tell them apart here, so all of them are reported.

Every rule looks at the effects that carry a named cause, and yields the causes and places that would be the same signal. Their equations
are those of the effects in `skin_models.effects`.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.search.rivals import Rival, reach
from skin_ident.criticism.search.trial import Trial
from skin_ident.criticism.sessions.one_rate import at_one_rate
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import (
    CEILING_OF_LOAD_CELL,
    CREEP_OF_LOAD_CELL,
    DAMPING,
    DEAD_ZONE,
    FORCE_OFFSET,
    GAIN_ERROR,
    HYSTERESIS,
    LAG_OF_LOAD_CELL,
    LAG_OF_TAXELS,
    LATE_DEPTH,
    LEAKS,
    LOOP_OF_LOAD_CELL,
    RELAXATION,
    STIFFER,
    ZERO_OF_DEPTH,
    Key,
)
from skin_models.effect import Effect
from skin_models.effects.drift import Creep, LogDrift, LogGainDrift
from skin_models.effects.mount_compliance import DampedMount, JointedMount, PowerMount, YieldingMount
from skin_models.effects.rate_dependence import OneSidedDamping

CLOSES = 0.05  # share of the greatest depth within which a joint closes at once
AT_ONCE_S = 1.0  # s, time constant below which a drift is complete almost at once: the rest is nearly constant
SENSED = 0.95  # share of a relaxing arm that is under the taxels, above which it counts as all of it
UNTOLD = 0.97  # ratio of the load cell's squared residual with an effect to that without, above which the load cell does not show it
MOST = 0.8  # share of the score of a loop in the skin that one in the load cell must explain: their forms differ
AT_THE_SURFACE = 60e-6  # m, depth within which a skin that stiffens looks like one that begins deeper
SURE = 2.0  # standard errors
ALONE = 0.1  # ratio of what one kind of sensor feels of an effect to what the other feels, below which the other alone shows it
SWALLOWED = {"skin": (DEAD_ZONE, "skin"), "taxel": (DEAD_ZONE, "taxel")}


@dataclass(frozen=True)
class Instances:
    """The effects that carry the cause of one trial, in the sessions to which it was fitted."""

    trial: Trial
    sessions: list[Session]

    @property
    def key(self) -> Key:
        """Cause and place."""
        return self.trial.key

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        """The effects of the trial's model that carry its cause at its place."""
        return self.trial.fit.model.having(self.key)

    def have(self, *forms: type[Effect]) -> bool:
        """Whether one of the effects is of one of these classes."""
        return any(isinstance(e, forms) for e in self.effects)

    def amounts(self) -> tuple[float, float]:
        """Total stiffness of the effects under the taxels and beside them, N/m."""
        return tuple(sum(abs(getattr(e, name, 1.0)) for e in self.effects) for name in ("k_sensed", "k_dispersed"))


def same_by_nature(trial: Trial, trials: list[Trial], said: set[Key], sessions: list[Session]) -> tuple[Rival, ...]:
    """Names not in `said` that are the same signal as a trial's cause; with fit and score where they were tried themselves."""
    mine = Instances(trial, sessions)
    others = dict.fromkeys(other for rule in RULES for other in rule(mine) if other not in said)
    tried = {t.key: Rival(*t.key, trial.score - t.score, t.fit.model) for t in trials}
    return tuple(tried.get(other) or Rival(*other, 0.0) for other in others)


def _swallowed(mine: Instances) -> Iterator[Key]:
    """A force below a threshold may be swallowed by the skin or by its taxels: either way each taxel reads what is above it. In contact, a
    plunger that goes F / k less deep than it reads presses as if the skin swallowed F."""
    cause, where = mine.key
    if cause == DEAD_ZONE and where in SWALLOWED:
        yield from (key for place, key in SWALLOWED.items() if place != where)
    if mine.key == ZERO_OF_DEPTH and all(getattr(e, "offset", 0.0) < 0.0 for e in mine.effects):
        yield SWALLOWED["skin"]


def _memory(mine: Instances) -> Iterator[Key]:
    """At one speed, memory of time and memory of the path are the same signal: a skin that relaxes or a sensor that creeps looks like
    hysteresis."""
    if not at_one_rate(mine.sessions):
        return
    cause, where = mine.key
    if mine.key == RELAXATION:
        yield HYSTERESIS
    elif mine.key == HYSTERESIS:
        yield RELAXATION
    elif cause == "hysteresis":
        yield "drift", where
    elif mine.have(Creep):
        yield "hysteresis", where


def _there_at_once(mine: Instances) -> Iterator[Key]:
    """A drift as log(1 + t / tau) that begins within the first second is nearly complete from the start: a constant."""
    for form, constant in ((LogDrift, FORCE_OFFSET), (LogGainDrift, GAIN_ERROR)):
        if any(isinstance(e, form) and e.tau < AT_ONCE_S for e in mine.effects):
            yield constant, mine.key[1]


def _mounts(mine: Instances) -> Iterator[Key]:
    """A tip at g(x), as behind a joint, makes a linear skin look like one whose spring stiffens as g and whose damping grows as g' with
    depth. Behind a joint that closes at once it presses as if the skin swallowed a force. A tip that follows late makes the skin look like
    one with a fast relaxing arm."""
    joints = [e for e in mine.effects if isinstance(e, JointedMount)]
    if joints or mine.have(PowerMount):
        yield from (STIFFER, DAMPING)
        deepest = max(float(s.motion.x.max()) for s in mine.sessions)
        if joints and max(e.closing for e in joints) < CLOSES * deepest:
            yield SWALLOWED["skin"]
    elif mine.have(DampedMount, YieldingMount):
        yield RELAXATION


def _heard_by_neighbours(mine: Instances) -> Iterator[Key]:
    """A relaxing arm that the load cell does not show looks like taxels that pick up their neighbours' changes."""
    if mine.key == RELAXATION and len(mine.sessions[0].channels) > 2 and _told_by_taxels_alone(mine):
        yield LEAKS


def _told_by_taxels_alone(mine: Instances) -> bool:
    """Whether nearly all of the effect is under the taxels, and the load cell, which should feel it, is simulated no better with it."""
    with_it = mine.trial.fit.model
    without = with_it.lacking(mine.key)
    sensed, dispersed = mine.amounts()
    after, before = (sum(np.sum(residual(model, s)[0] ** 2) for s in mine.sessions) for model in (with_it, without))
    return sensed > SENSED * (sensed + dispersed) and ("force" not in mine.sessions[0].channels or after > UNTOLD * before)


def _told_by_the_load_cell_alone(mine: Instances) -> Iterator[Key]:
    """A loop or relaxing arm of the skin with nothing under the taxels looks like a loop, or creep, of the load cell."""
    sensor = {HYSTERESIS: LOOP_OF_LOAD_CELL, RELAXATION: CREEP_OF_LOAD_CELL}.get(mine.key)
    if sensor is None or len(mine.sessions[0].channels) < 2 or "force" not in mine.sessions[0].channels:
        return
    sensed, dispersed = mine.amounts()
    if sensed < ALONE * dispersed:
        yield sensor


def _late_one_way(mine: Instances) -> Iterator[Key]:
    """Damping in one direction of motion that the load cell or the taxels alone show looks like a lag of theirs that is longer in that
    direction."""
    if mine.key == DAMPING and all(isinstance(e, OneSidedDamping) for e in mine.effects):
        yield from late_one_way(sum(e.c_sensed for e in mine.effects), sum(e.c_dispersed for e in mine.effects))


def late_one_way(sensed: float, dispersed: float) -> Iterator[Key]:
    """The lag of the sensor that alone shows damping under the taxels and beside them, N s/m; nothing where both sensors show it."""
    if abs(sensed) < ALONE * abs(dispersed):
        yield LAG_OF_LOAD_CELL
    elif abs(sensed + dispersed) < ALONE * abs(sensed):
        yield LAG_OF_TAXELS


def _within_a_sample(mine: Instances) -> Iterator[Key]:
    """What skin or mount complete within one sample looks like a late depth."""
    fastest = min((getattr(e, name, np.inf) for e in mine.effects for name in ("tau", "late")), default=np.inf)
    if mine.key[1] in ("skin", "rig") and fastest < mine.sessions[0].longest_period:
        yield LATE_DEPTH


RULES: tuple[Callable[[Instances], Iterator[Key]], ...] = (
    _swallowed,
    _memory,
    _there_at_once,
    _mounts,
    _heard_by_neighbours,
    _told_by_the_load_cell_alone,
    _late_one_way,
    _within_a_sample,
)


def likelier_place(trials: list[Trial]) -> list[Trial]:
    """The trial of the best trial's cause at a likelier place, as a list, empty where there is none.

    - For a dead zone of the skin or of one taxel: the same dead zone in all taxels, if that explains as much.
    - For a loop of the skin that the taxels surely do not feel: the loop of the load cell, if it explains most of it. No skin has a memory
      that bypasses the taxels alone.
    - For a skin that stiffens or softens beside its taxels alone: the load cell's ceiling, if it explains as much.
    - For a skin that stiffens once and for all within a few micrometres: a zero of depth, if it explains as much.
    """
    best = trials[0] if trials else None
    if best and best.key[0] == DEAD_ZONE and best.key[1] != "taxel":
        return [t for t in trials if t.key == SWALLOWED["taxel"] and t.score > reach(best.score)]
    if best and best.key == HYSTERESIS and _beside_the_taxels(best):
        return [t for t in trials if t.key == LOOP_OF_LOAD_CELL and t.score > MOST * best.score]
    if not best or best.key != STIFFER:
        return []
    likelier = ((ZERO_OF_DEPTH, _at_the_surface), (CEILING_OF_LOAD_CELL, _beside_the_taxels))
    return [t for key, is_so in likelier for t in trials if t.key == key and t.score > reach(best.score) and is_so(best)][:1]


def _at_the_surface(trial: Trial) -> bool:
    """Whether every instance of a stiffening has ended within a depth to which no zero is set."""
    return all(getattr(e, "onset", np.inf) < AT_THE_SURFACE for e in trial.fit.model.having(trial.key))


def _beside_the_taxels(trial: Trial) -> bool:
    """Whether every instance of a skin's cause is surely far smaller under the taxels than beside them, and there are taxels to show it."""
    model, std = trial.fit.model, trial.fit.std

    def beside(i: int, e: Effect) -> bool:
        v = e.values
        pairs = [(name, name.removesuffix("sensed") + "dispersed") for name in v if name.endswith("_sensed")]
        felt = [abs(v[a]) + SURE * std.get(model.listed_as(i, a), 0.0) < ALONE * abs(v[b]) for a, b in pairs if v[a] or v[b]]
        return bool(felt) and all(felt)

    return bool(model.shares) and all(beside(i, e) for i, e in enumerate(model.effects) if e.key == trial.key)
