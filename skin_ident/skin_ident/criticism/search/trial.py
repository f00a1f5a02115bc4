"""One cause tried: grown and refitted beside everything else, and what can be said of it before held-out data are asked."""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.baseline.fitting import Fit
from skin_ident.criticism.baseline.residual import residual, simulated
from skin_ident.criticism.baseline.unknowns import LATE, least_damping
from skin_ident.criticism.search.growing import determined, instances, lacking, unlike_skin
from skin_ident.criticism.search.ranking import Ranked
from skin_ident.criticism.search.rivals import Rival, reach
from skin_ident.criticism.sessions.one_rate import at_one_rate
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.telemetry.pull import is_pulled
from skin_models.effects.drift import Creep, LogDrift, LogGainDrift
from skin_models.effects.mount_compliance import DampedMount, JointedMount, PowerMount, YieldingMount
from skin_models.effects.rate_dependence import OneSidedDamping
from skin_models.parameter import AMPLITUDE, parameters_of

CLOSES = 0.05  # of the greatest depth, within which a joint is closed
AT_ONCE_S = 1.0  # within which a drift that begins so fast is there: what follows is hardly more than a constant
SENSED = 0.95  # of an arm that relaxes, under the taxels: nearly all of it
UNTOLD = 0.97  # of the squares that the load cell leaves without an effect, left with it: it does not tell
ALONE = 0.1  # of what one kind of sensor feels of damping, the most that the other feels where it is told by the first alone
FELT = 0.4  # of what a taxel feels of an effect of the skin, the least that the load cell must feel of it
SAME = ((("dead_zone", "taxel"), ("dead_zone", "skin")), (("dead_zone", "skin"), ("dead_zone", "taxel")))
HYSTERESIS, RELAXATION = ("hysteresis", "skin"), ("stress_relaxation", "skin")
MEMORY = ((HYSTERESIS, RELAXATION), (RELAXATION, HYSTERESIS))
LATE_DEPTH = ("time_shift", "clock_depth")
OFFSET, SWALLOWED = ("position_offset", "rig"), ("dead_zone", "skin")
DAMPING, ADHESION, LEAKS = ("rate_dependence", "skin"), ("adhesion", "skin"), ("crosstalk", "taxel")
STIFFER = (("nonlinear_stiffness", "skin"), DAMPING)


@dataclass(frozen=True)
class Trial:
    """One cause, grown and refitted: `score` is its likelihood gain less the charge for its parameters; `plainer` is the same with its
    first instance alone, where it has several."""

    ranked: Ranked
    fit: Fit
    score: float
    plainer: "Trial | None" = None

    @property
    def key(self) -> tuple[str, str]:
        """Cause and place."""
        return self.ranked.cause, self.ranked.where

    @property
    def forms(self) -> tuple["Trial", ...]:
        """What may be believed of the cause: several instances may go wrong beyond what they were fitted to where the first does not."""
        return (self, self.plainer) if self.plainer else (self,)


def plausible(t: Trial, sessions: list[Session]) -> bool:
    """Whether the load cell feels an effect of the skin as the taxels do: what reaches a taxel has passed the load cell, but for what the
    skin hands round the taxels. Whether the skin is no filter, no brake and no motor. Whether what leaks from one taxel into another is of
    one sign with it. Whether a spread grows with depth or shrinks, not both. And whether skin that pulls is seen to."""
    if t.ranked.cause == "crosstalk" and any(getattr(e, "share", 0.0) < 0.0 for e in instances(t.fit.model, *t.key)):
        return False
    if len({np.sign(getattr(e, "growth", 0.0)) for e in instances(t.fit.model, "spread_depth", "skin")}) > 1:
        return False
    if unlike_skin(t.fit.model) or _drives(t, sessions):
        return False
    if t.key == ADHESION and not is_pulled(t.fit.model, lacking(t.fit.model, *t.key), sessions):
        return False
    channels = sessions[0].channels
    if t.ranked.where != "skin" or t.ranked.cause.startswith(("spread", "dead_zone")) or "force" not in channels or len(channels) == 1:
        return True
    without = lacking(t.fit.model, *t.key)
    felt = np.sqrt(sum(np.sum((simulated(t.fit.model, s) - simulated(without, s)) ** 2, axis=1) for s in sessions))
    return bool(felt[0] > FELT * felt[1:].max())


def _drives(t: Trial, sessions: list[Session]) -> bool:
    """Whether damping that depends on speed gives back more than it takes, under the taxels or in all; what a late reading makes of it is
    allowed."""
    if not instances(t.fit.model, *DAMPING):
        return False
    without, skin = lacking(t.fit.model, *DAMPING), t.fit.model.dispersion
    under_taxels, in_all = least_damping(skin, LATE * sessions[0].period)
    spare = [(0, skin.b1 + skin.b2 - in_all)] if "force" in sessions[0].channels else []
    if t.fit.model.shares:
        spare.append((int(np.argmax(t.fit.model.shares)) - len(t.fit.model.shares), skin.b1 - under_taxels))
    taken, linear = np.zeros(len(spare)), 0.0
    for s in sessions:
        more = simulated(t.fit.model, s) - simulated(without, s)
        taken += [float(np.sum(more[row] * s.motion.v)) for row, _ in spare]
        linear += float(np.sum(s.motion.v**2 * (s.motion.x > 0.0)))
    return bool(np.any(taken + linear * np.array([b for _, b in spare]) < 0.0))


def sized(t: Trial) -> bool:
    """Whether a cause that has one size is surely not of none; several sizes of one cause may stand for each other."""
    mine = instances(t.fit.model, *t.key)
    several = len(mine) > 1 or any(sum(p.role == AMPLITUDE for p in parameters_of(e)) > 1 for e in mine)
    return several or t.fit.model.effects[-1] not in mine or determined(t.fit)


def same_by_nature(trial: Trial, trials: list[Trial], said: set[tuple[str, str]], sessions: list[Session]) -> tuple[Rival, ...]:
    """Names, not `said` yet, that are the same signal: a force below a threshold is swallowed by skin or taxels; in contact a plunger that
    has F / k less to go presses as if the skin swallowed F, as does one behind a joint that closes at once; a tip at g(x), as behind a
    joint, makes of a linear skin one whose spring stiffens as g and whose damping grows as g' with depth; one that follows late makes of it
    one with an arm that relaxes fast; an arm that the load cell does not tell is what taxels would hear of their neighbours' changes; what
    skin or mount have done within a sample, a late depth does as well; at one speed memory of time is memory of the path, of a skin that
    relaxes as of a sensor that creeps; damping of one way that one kind of sensor feels is its lag then; and what drifts as log t from
    the first second on is nearly there from the start."""
    at_one, (cause, where) = at_one_rate(sessions), trial.key
    others = [other for one, other in (SAME + MEMORY if at_one else SAME) if one == trial.key]
    if trial.key == OFFSET and all(getattr(e, "offset", 0.0) < 0.0 for e in instances(trial.fit.model, *OFFSET)):
        others.append(SWALLOWED)
    mine = instances(trial.fit.model, *trial.key)
    if at_one and cause == "hysteresis" and where != "skin":
        others.append(("drift", where))
    elif at_one and any(isinstance(e, Creep) for e in mine):
        others.append(("hysteresis", where))
    for cls, constant in ((LogDrift, "force_offset"), (LogGainDrift, "gain_error")):
        if any(isinstance(e, cls) and e.tau < AT_ONCE_S for e in mine):
            others.append((constant, where))
    joints = [e for e in mine if isinstance(e, JointedMount)]
    if joints:
        deepest = max(float(s.motion.x.max()) for s in sessions)
        others += [*STIFFER, *([SWALLOWED] if max(e.closing for e in joints) < CLOSES * deepest else [])]
    elif any(isinstance(e, PowerMount) for e in mine):
        others += STIFFER
    elif any(isinstance(e, (DampedMount, YieldingMount)) for e in mine):
        others.append(RELAXATION)
    if trial.key == RELAXATION and len(sessions[0].channels) > 2 and _told_by_taxels_alone(trial, sessions):
        others.append(LEAKS)
    if trial.key == DAMPING and all(isinstance(e, OneSidedDamping) for e in mine):
        others += _late_one_way(sum(e.c_sensed for e in mine), sum(e.c_dispersed for e in mine))
    if where in ("skin", "rig") and any(getattr(e, name, np.inf) < sessions[0].period for e in mine for name in ("tau", "late")):
        others.append(LATE_DEPTH)
    tried = {t.key: Rival(*t.key, trial.score - t.score, t.fit.model) for t in trials}
    return tuple(tried.get(other) or Rival(*other, 0.0) for other in others if other not in said)


def _late_one_way(sensed: float, dispersed: float) -> list[tuple[str, str]]:
    """The sensor whose lag is longer on one way than on the other, where damping of one way is told by the load cell or by taxels alone."""
    if abs(sensed) < ALONE * abs(dispersed):
        return [("lag", "load_cell")]
    return [("lag", "taxel")] if abs(sensed + dispersed) < ALONE * abs(sensed) else []


def _told_by_taxels_alone(t: Trial, sessions: list[Session]) -> bool:
    """Whether what the skin does is nearly all under the taxels, and the load cell, which feels it, too, is no better simulated for it."""
    mine, without = instances(t.fit.model, *t.key), lacking(t.fit.model, *t.key)
    sensed, dispersed = (sum(abs(getattr(e, name, 1.0)) for e in mine) for name in ("k_sensed", "k_dispersed"))
    after, before = (sum(np.sum(residual(model, s)[0] ** 2) for s in sessions) for model in (t.fit.model, without))
    return sensed > SENSED * (sensed + dispersed) and ("force" not in sessions[0].channels or after > UNTOLD * before)


def all_alike(trials: list[Trial]) -> list[Trial]:
    """Where the best trial is a dead zone, of the skin or of one taxel: the same dead zone in all taxels, if that explains as much."""
    best = trials[0] if trials else None
    alike = [t for t in trials if (t.key, (t.ranked.cause, "skin")) in SAME and t.ranked.cause == best.ranked.cause]
    return [t for t in alike if best.ranked.where != "taxel" and t.score > reach(best.score)]
