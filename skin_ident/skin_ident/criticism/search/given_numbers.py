"""Whether the numbers of a given model are wrong: those of its skin, or of the effects that it has."""

from collections.abc import Callable
from dataclasses import replace

from skin_ident.criticism.baseline.fitting import ITERATIONS, Fit, fit, fit_effects
from skin_ident.criticism.baseline.unknowns import effect_unknowns
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.search.hardware import encoder_does
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.sessions.session import Session
from skin_models.effect import Effect
from skin_models.model import Model

PARAMETERS, DAMPING = ("parameters", "skin"), ("rate_dependence", "skin")
AS_STIFF, AS_DAMPED = 0.02, 0.1  # share by which stiffness, or damping, is the same: an imperfect effect bends it by as much
WRONG = 0.1  # relative fall of the held-out error by which given numbers are called wrong: an imperfect effect bends them a little


def check_numbers(search: Search, given: Model) -> None:
    """Name `parameters` where the numbers of the given model are wrong once every named cause is in it; where they are not, they stay.
    Those of its effects alone are changed where that is enough: a simulation may have what the record has not."""
    every = search.present
    as_given = replace(given, effects=(*given.effects, *_added(given, every.model)))

    def fit_added(model: Model, sessions: list[Session], noise: Whitener, iterations: int = ITERATIONS) -> Fit:
        free = tuple(u for u in effect_unknowns(model) if u.part >= len(given.effects))
        return fit(model, sessions, noise, iterations, free)

    kept = fit_added(as_given, search.train, search.noise)
    if not _wrong(search, given, kept, every, fit_added):
        search.present = kept
        return
    effects = fit_effects(as_given, search.train, search.noise)
    search.present = every if not given.effects or _wrong(search, given, effects, every, fit_effects) else effects
    gain = search.gain(kept.model, search.present.model, "skin", fit_added)
    finding = Named(*PARAMETERS, gain, kept.cost - search.present.cost, (), given, search.present.model)
    search.named.insert(0, finding)


def _wrong(search: Search, given: Model, before: Fit, after: Fit, refit_before: Callable) -> bool:
    """Whether numbers that `before` holds are wrong, as `after` has changed them, and it is no hardware that bends them."""
    gain = search.gain(before.model, after.model, "skin", refit_before)
    if not (gain.passed and gain.before - gain.after > WRONG * gain.before and _others(given, after.model)):
        return False
    as_if = DAMPING if _as_stiff(before.model, after.model) else PARAMETERS
    why = encoder_does(as_if, gain, before.model, after.model, search.train, search.encoder_step)
    search.hardware |= {PARAMETERS: why} if why else {}
    return why is None


def _others(given: Model, after: Model) -> bool:
    """Whether numbers of the skin, or of the effects that were given, are others by what anybody would care for."""
    damping = given.dispersion.b1 + given.dispersion.b2
    pairs = [(getattr(given.dispersion, name), getattr(after.dispersion, name)) for name in ("b1", "b2")]
    damped = any(abs(a - b) > AS_DAMPED * abs(damping) for b, a in pairs)
    shared = any(abs(a - b) > AS_STIFF for b, a in zip(given.shares, after.shares, strict=True))
    return damped or shared or not _as_stiff(given, after) or given.effects != after.effects[: len(given.effects)]


def _as_stiff(before: Model, after: Model) -> bool:
    """Whether two skins differ by damping alone: noise of the depth, or of a force that drives the test, does as much to that."""
    pairs = ((before.dispersion.k1, after.dispersion.k1), (before.dispersion.k2, after.dispersion.k2))
    return all(abs(b - a) <= AS_STIFF * abs(b) for b, a in pairs)


def _added(given: Model, extended: Model) -> tuple[Effect, ...]:
    """The effects of an extended model that are not those of the given one, whatever their numbers have become."""
    had, added = [(type(e), e.where) for e in given.effects], []
    for e in extended.effects:
        if (type(e), e.where) in had:
            had.remove((type(e), e.where))
        else:
            added.append(e)
    return tuple(added)
