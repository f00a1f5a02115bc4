"""What physics rules out among the trials, whatever they explain. Every rule returns whether a trial breaks it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.baseline.unknowns import LATE, least_damping
from skin_ident.criticism.gates.gate import own_channels
from skin_ident.criticism.search.growing import felt, unlike_skin
from skin_ident.criticism.search.trial import Trial
from skin_ident.criticism.sessions.session import Session, motion_under
from skin_ident.criticism.telemetry.pull import is_pulled
from skin_ident.criticism.vocabulary import ADHESION, DAMPING, SENSORS
from skin_models.effect import Effect
from skin_models.effects.eyring_relaxation import EyringRelaxation
from skin_models.effects.hysteresis import BoucWenHysteresis

ONCE = 0.6  # of the greatest depth or reading: a loop that closes yields both ways, and needs less than half
LITTLE = 5.0  # times the threshold of other elements, from which Bouc-Wen's is a stiffness
FELT = 0.4  # least ratio of what the load cell feels of an effect of the skin to what a taxel feels of it


def plausible(trial: Trial, sessions: list[Session]) -> bool:
    """Whether no rule of physics speaks against a trial."""
    return not any(rule(trial, sessions) for rule in RULES)


def _leaks_less_than_nothing(trial: Trial, sessions: list[Session]) -> bool:
    """Crosstalk is not negative: what leaks into a taxel has the sign of where it comes from."""
    return trial.ranked.cause == "crosstalk" and any(getattr(e, "share", 0.0) < 0.0 for e in trial.fit.model.having(trial.key))


def _spreads_both_ways(trial: Trial, sessions: list[Session]) -> bool:
    """A spread grows with depth or shrinks, not both."""
    return len({np.sign(getattr(e, "growth", 0.0)) for e in trial.fit.model.having(("spread_depth", "skin"))}) > 1


def _is_no_skin(trial: Trial, sessions: list[Session]) -> bool:
    """Skin is no filter and no brake (see `unlike_skin`). That flowing arms of relaxation, which was named before, come to slip beside a
    fault of a sensor does not speak against that fault."""
    model = trial.fit.model
    if trial.ranked.where.startswith(SENSORS):
        model = replace(model, effects=tuple(e for e in model.effects if not isinstance(e, EyringRelaxation)))
    return unlike_skin(model)


def _yields_once(trial: Trial, sessions: list[Session]) -> bool:
    """An element of a loop whose threshold is more than half as far as anything ever goes yields on the way to the farthest point, if at
    all, and never again: it is a stiffness, and a zero that this point has set. Bouc-Wen's yields little by little."""
    if trial.ranked.cause != "hysteresis":
        return False
    far = ONCE * _farthest(trial, sessions)
    return all(_threshold(e) >= far for e in trial.fit.model.having(trial.key))


def _threshold(loop: Effect) -> float:
    """From where an element of a loop yields, m or N; 0 where it always does."""
    return loop.threshold / (LITTLE if isinstance(loop, BoucWenHysteresis) else 1.0) if hasattr(loop, "threshold") else 0.0


def _farthest(trial: Trial, sessions: list[Session]) -> float:
    """The greatest depth, m, or the greatest reading of a sensor, N."""
    if trial.ranked.where == "skin":
        return max(float(motion_under(s, trial.fit.model.dispersion).x.max()) for s in sessions)
    own = [sessions[0].channels.index(c) for c in own_channels(trial.ranked.where, sessions[0].channels)]
    return max(float(np.abs(s.bridged[own]).max(initial=0.0)) for s in sessions)


def _drives(trial: Trial, sessions: list[Session]) -> bool:
    """Skin is no motor: damping that depends on speed returns no more energy than it takes, neither under the taxels nor in all, but for
    what a late reading may make it seem to return."""
    model = trial.fit.model
    if not model.having(DAMPING):
        return False
    without, skin = model.lacking(DAMPING), model.dispersion
    under_taxels, in_all = least_damping(skin, LATE * sessions[0].longest_period)
    spare = [(0, skin.b1 + skin.b2 - in_all)] if "force" in sessions[0].channels else []
    if model.shares:
        spare.append((int(np.argmax(model.shares)) - len(model.shares), skin.b1 - under_taxels))
    taken, linear = np.zeros(len(spare)), 0.0
    for s in sessions:
        more, moved = simulated(model, s) - simulated(without, s), motion_under(s, skin)
        taken += [float(np.sum(more[row] * moved.v)) for row, _ in spare]
        linear += float(np.sum(moved.v**2 * (moved.x > 0.0)))
    return bool(np.any(taken + linear * np.array([b for _, b in spare]) < 0.0))


def _pulls_unseen(trial: Trial, sessions: list[Session]) -> bool:
    """Skin that pulls on the plunger shows in the record."""
    return trial.key == ADHESION and not is_pulled(trial.fit.model, trial.fit.model.lacking(trial.key), sessions)


def _passes_by_the_load_cell(trial: Trial, sessions: list[Session]) -> bool:
    """What reaches a taxel has passed the load cell. So the load cell feels an effect of the skin as the taxels do, unless the skin only
    hands the force round the taxels."""
    channels = sessions[0].channels
    if trial.ranked.where != "skin" or trial.ranked.cause.startswith(("spread", "dead_zone")):
        return False
    if "force" not in channels or len(channels) == 1:
        return False
    changed = felt(trial.fit.model, trial.key, sessions)
    return not changed[0] > FELT * changed[1:].max()  # NaN breaks the rule, too


RULES: tuple[Callable[[Trial, list[Session]], bool], ...] = (
    _leaks_less_than_nothing,
    _spreads_both_ways,
    _is_no_skin,
    _yields_once,
    _drives,
    _pulls_unseen,
    _passes_by_the_load_cell,
)
