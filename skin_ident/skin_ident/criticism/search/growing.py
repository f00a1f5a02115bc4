"""Adding one cause to a model: as many instances of its effect as the data support, each refitted with everything else."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache

import numpy as np

from skin_ident.criticism.baseline.fitting import Fit, approached, fit
from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.baseline.settling import settled
from skin_ident.criticism.baseline.unknowns import effect_unknowns, shown, unknowns
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.search.proposals import PROBE, Direction
from skin_ident.criticism.search.ranking import Ranked
from skin_ident.criticism.search.survey import survey
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import Key
from skin_models.catalogue import effects
from skin_models.dispersion import Dispersion
from skin_models.effect import Effect
from skin_models.effects.eyring_relaxation import EyringRelaxation
from skin_models.effects.hysteresis import LoadedHysteresis
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.model import Model
from skin_models.parameter import AMPLITUDE, SHAPE, clipped, parameters_of

MOST = 3  # instances of one cause at one place, at most
LARGE = 1.0  # whitened gain per sample from which an effect is large: it explains as much as all noise
AT_SHAPE = 4  # iterations of a first fit, with the shape held, or beside settled shares
PROMISED = 0.5  # share of the ranked gain; a fit that gains less is begun anew in other ways
EXCEEDED, FARTHER = 3.0, 2.0  # times the ranked gain above which the fit is begun anew, from FARTHER times the amount that it found
LITTLE = 0.05  # share of the ranked amount from which a careful fit begins
IN_TURN = 3  # alternations of settling the shares and fitting the rest
INSTANCE, FORM = 10.0, 20.0  # squared whitened units that another instance, or a finer form, must explain
WORTH = 0.02  # share of the first instance's gain that another instance must explain
SURE = 2.0  # standard errors that the size of a further instance must exceed
FINER = 0.002  # the same for a finer form, which is the same name with one number more
AT_ONCE = 0.05  # s, time constant of what passes the common band as damping does
SLIPPING = 3e-6  # m, a path so short that skin is not bent by it before it slips


def grow(start: Fit, best: Ranked, sessions: list[Session], which: tuple[Direction, ...], noise: Whitener) -> tuple[Fit, ...]:
    """Add the cause `best` to the fitted model `start`, instance by instance, until another one is not worth its parameters. Return the fit
    with all instances and, where there are several, also the fit with the first alone."""
    present, first, stages = start, 0.0, []
    while len(stages) < MOST and (own := tuple(d for d in which if d.key == best.key and _adds(d, present.model))):
        ranked = best if present is start and best.best in own else survey(present.model, sessions, own, noise).ranked[0]
        if present is not start and ranked.best_gain < max(INSTANCE, WORTH * first):
            break
        trial, sessions = _settled(_with_instance(present, ranked, sessions, noise), sessions, noise)
        gained = present.cost - trial.cost
        first = first or gained
        if gained < max(INSTANCE, WORTH * first) or not (present is start or (determined(trial) and not unlike_skin(trial.model))):
            break
        present = _refined(trial, gained, sessions, noise)
        stages.append(present)
    return (present, stages[0]) if len(stages) > 1 else (present,)


def spared(present: Fit, key: Key, sessions: list[Session], noise: Whitener) -> Fit:
    """The fit without those of several instances of a cause that explain nothing now that all others are known: what was named first, in
    one form, others may have taken over."""
    while len(own := present.model.having(key)) > 1:
        fewer = min((fit(present.model.without(e), sessions, noise) for e in own), key=lambda f: f.cost)
        if fewer.cost - present.cost >= INSTANCE:
            break
        present = fewer
    return present


def _with_instance(present: Fit, ranked: Ranked, sessions: list[Session], noise: Whitener) -> Fit:
    """The fit with one more instance. A large effect is begun in each of its forms and the best is taken, because the ranking is by small
    amounts, which do not tell the forms apart."""
    forms = _forms(ranked) if ranked.gain >= LARGE * present.count else [ranked]

    @cache  # forms share some beginnings
    def begun_at(d: Direction, amount: float) -> Fit:
        return _begun_at(d, amount, present, sessions, noise)

    begun = (f for r in forms for f in (_in_form(present, r, begun_at), *_beside_sound_damping(present, r, sessions, noise)))
    return min(begun, key=lambda f: f.cost)


def _forms(ranked: Ranked) -> list[Ranked]:
    """The cause as ranked, and the same begun at the largest amount of each other form that helps to explain it."""
    found = {type(ranked.best.effect): ranked}
    for d, z in sorted(zip(ranked.used, ranked.amounts, strict=True), key=lambda used: -abs(used[1])):
        found.setdefault(type(d.effect), replace(ranked, best=d, best_amount=float(z)))
    return [*found.values()]


def _in_form(present: Fit, ranked: Ranked, begun_at: Callable[[Direction, float], Fit]) -> Fit:
    """The fit with one more instance in the ranked form; `begun_at` fits it from an amount of a direction. It begins at the ranked shape,
    which is held at first: there the fit is nearly linear, while a shape that is free at once runs away. Beginnings are, in turn:

    - the ranked amount; or little of it, where the whole amount leaves the fit worse than before because the model's own unknowns must
      change with the effect;
    - where far more is gained than the ranking promised, twice the amount found, since the way may go on;
    - where little of the promised gain is kept: little of the amount (beside a delay, damping is far off and makes the ranked amount too
      large); the amounts at which the effect was scanned (no small delay shows the way to one of half a period of the motion); and the
      finer forms (damping may have taken all that a plain lag would explain, and left what only a lag of a part does).
    """
    for share in (1.0, LITTLE):
        trial = begun_at(ranked.best, share * ranked.best_amount)
        if trial.cost < present.cost:
            break
    gained = present.cost - trial.cost
    if gained > EXCEEDED * ranked.gain:
        found = getattr(trial.model.effects[-1], ranked.best.parameter) / ranked.best.size
        return min(trial, begun_at(ranked.best, FARTHER * found), key=lambda f: f.cost)
    if gained > PROMISED * ranked.gain:
        return trial
    large = [(d, np.sign(z) * d.probe) for d, z in zip(ranked.used, ranked.amounts, strict=True) if d.probe != PROBE]
    finer = [(replace(ranked.best, effect=e), ranked.best_amount) for e in _finer(ranked.best.effect)]
    little = [(ranked.best, LITTLE * ranked.best_amount)] if share == 1.0 else []
    others = [*little, *large, *finer]
    return min([trial, *(begun_at(d, float(z)) for d, z in others)], key=lambda f: f.cost)


def _beside_sound_damping(present: Fit, ranked: Ranked, sessions: list[Session], noise: Whitener) -> Iterator[Fit]:
    """For a cause whose size is a time, where the fitted damping gives back energy, which looks like a delay: the fit begun at damping that
    does not, and a delay that makes up for it. Step by step a fit does not get there, because all the way one takes the place of the
    other."""
    amplitude = next(p for p in parameters_of(ranked.best.effect) if p.name == ranked.best.parameter)
    if amplitude.unit != "s" or sessions[0].drive is not None:
        return
    sound, late = sound_damping(present.model.dispersion)
    if late <= 0.0:
        return
    amount = ranked.best_amount + late / ranked.best.size
    begun = _extended(replace(present.model, dispersion=sound), _ready(ranked.best, amount, sessions[0]))
    yield fit(approached(begun, sessions, noise, AT_SHAPE, tuple(effect_unknowns(begun, sessions[0]))), sessions, noise)


def sound_damping(skin: Dispersion) -> tuple[Dispersion, float]:
    """The skin with damping that gives back no energy anywhere, and the delay, s, that looks like the damping it had.

    - Total damping is negative: both b1 and b2 are made non-negative, and everything is late.
    - b1 < 0: the taxels are late. b2 < 0: the load cell is late. In both cases the springs get damping in proportion to their stiffness.
    """
    whole, damping = skin.k1 + skin.k2, skin.b1 + skin.b2
    if whole <= 0.0:
        return skin, 0.0
    if damping < 0.0:
        sound = replace(skin, b1=max(skin.b1, 0.0), b2=max(skin.b2, 0.0))
        return sound, (sound.b1 + sound.b2 - damping) / whole
    if skin.b1 < 0.0 < skin.k1:
        b1 = damping * skin.k1 / whole
        return replace(skin, b1=b1, b2=damping - b1), (b1 - skin.b1) / skin.k1
    if skin.b2 < 0.0 < skin.k1:
        b2 = skin.b1 * skin.k2 / skin.k1
        return replace(skin, b2=b2), (b2 - skin.b2) / whole
    return skin, 0.0


def _begun_at(d: Direction, amount: float, present: Fit, sessions: list[Session], noise: Whitener) -> Fit:
    model = _extended(present.model, _ready(d, amount, sessions[0]))
    new = len(model.effects) - 1
    sizes = tuple(u for u in unknowns(model, sessions[0]) if not (u.part == new and u.parameter.role == SHAPE))
    return fit(approached(model, sessions, noise, AT_SHAPE, sizes), sessions, noise)


def _settled(trial: Fit, sessions: list[Session], noise: Whitener) -> tuple[Fit, list[Session]]:
    """The fit with the sessions' own shares settled under it, both in turn: an effect on a taxel's reading acts on that taxel's share of
    the force."""
    if sessions[0].spread is None or not trial.model.effects[-1].where.startswith("taxel"):
        return trial, sessions
    for _ in range(IN_TURN):
        sessions = [settled(trial.model, s) for s in sessions]
        trial = fit(trial.model, sessions, noise, AT_SHAPE)
    return trial, sessions


def determined(trial: Fit, std: dict[str, float] | None = None) -> bool:
    """Whether the last instance has a size that is clearly not zero, by its standard errors or by those in `std`. Two instances that all
    but cancel have none, nor has an instance that the model's own unknowns can imitate."""
    last = len(trial.model.effects) - 1
    sizes = [p for p in parameters_of(trial.model.effects[last]) if p.role == AMPLITUDE]
    std = trial.std if std is None else std
    return any(abs(p.value) > SURE * std.get(trial.model.listed_as(last, p.name), 0.0) for p in sizes)


def felt(model: Model, key: Key, sessions: list[Session]) -> np.ndarray:
    """What a cause at a place changes in every channel of the sessions, (C,) N: root of the sum of squares."""
    without = model.lacking(key)
    return np.sqrt(sum(np.sum((simulated(model, s) - simulated(without, s)) ** 2, axis=1) for s in sessions))


def unlike_skin(model: Model) -> bool:
    """Whether the skin of a model acts as a filter or a brake. An arm of half the skin's stiffness or more that relaxes at once is the lag
    of a sensor. An element that slips or flows at once, or that is stiffer than the whole skin until it slips, and be it hardly loaded, is
    friction or play."""
    whole, own = model.dispersion.k1 + model.dispersion.k2, [e for e in model.effects if e.where == "skin"]

    def unlike(e: Effect) -> bool:
        if isinstance(e, StressRelaxation):
            return e.tau < AT_ONCE and 2.0 * (e.k_sensed + e.k_dispersed) > whole
        if isinstance(e, EyringRelaxation):
            return e.stretch < SLIPPING
        unloaded = 1.0 - e.growth if isinstance(e, LoadedHysteresis) else 1.0
        return e.cause == "hysteresis" and (e.threshold < SLIPPING or unloaded * (e.k_sensed + e.k_dispersed) > whole)

    return any(map(unlike, own))


def _refined(present: Fit, gained: float, sessions: list[Session], noise: Whitener) -> Fit:
    """The fit with the last effect in a finer form (one that equals it when it is small), where such a form explains clearly more; else as
    it is."""
    *others, last = present.model.effects
    trials = [fit(replace(present.model, effects=(*others, e)), sessions, noise) for e in _finer(last)]
    best = min(trials, key=lambda trial: trial.cost, default=present)
    return best if present.cost - best.cost > max(FORM, FINER * gained) else present


def _finer(effect: Effect) -> list[Effect]:
    """The forms that equal an effect when it is small, with its values, or the nearest that they may have."""
    return [cls.typical(effect.where, **clipped(cls, **effect.values)) for cls in effects() if cls.refines is type(effect)]


def _ready(d: Direction, amount: float, session: Session) -> Effect:
    """The effect at the ranked amount. Its other amplitudes begin at a tenth of that where they cannot be negative, else at zero, so that
    every unknown can move; those that no channel shows stay at zero."""
    values, usual = {}, next(abs(p.typical) for p in parameters_of(d.effect) if p.name == d.parameter)
    for p in parameters_of(d.effect):
        if p.role != AMPLITUDE or p.typical != p.typical or not shown(p, session):
            continue
        share = 1.0 if p.name == d.parameter else (0.1 if p.lower >= 0.0 else 0.0)
        values[p.name] = amount * share * abs(p.typical) * d.size / usual
    return d.effect.with_values(**clipped(type(d.effect), **values))


def _extended(model: Model, effect: Effect) -> Model:
    """The model with one more effect. It takes the place of its plain form, to which it adds, where that has sizes alone: a delay beside a
    skewed clock, which has a delay of its own, is determined by nothing."""
    plain = next((e for e in model.effects if type(e) is effect.refines and e.where == effect.where and not _shaped(e)), None)
    if plain is None:
        return model.extended(effect)
    both = {name: value + getattr(effect, name) for name, value in plain.values.items()}
    return model.without(plain).extended(effect.with_values(**clipped(type(effect), **both)))


def _adds(d: Direction, model: Model) -> bool:
    """Whether another instance could add anything new: two delays are one delay, but two relaxation times are two. An encoder hangs on one
    coupling: several, or one beside play of the drive, bend into a law of damping."""
    own = model.having(d.key)
    if any(e.supple for e in (d.effect, *own)):
        return not own
    return _shaped(d.effect) or not any(type(d.effect) in (type(e), e.refines) for e in own)


def _shaped(effect: Effect) -> bool:
    return any(p.role == SHAPE for p in parameters_of(effect))
