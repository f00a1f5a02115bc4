"""Whether the numbers of a given model are wrong: those of its skin, or of its effects."""

from collections.abc import Callable
from dataclasses import replace

from skin_ident.criticism.baseline.fitting import ITERATIONS, Fit, fit, fit_effects
from skin_ident.criticism.baseline.unknowns import effect_unknowns
from skin_ident.criticism.gates.claim import Claim
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.search.hardware import encoder_does
from skin_ident.criticism.search.named import Named, NotNamed
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import DAMPING, PARAMETERS
from skin_models.effect import Effect
from skin_models.model import Model

# Relative change up to which stiffness, or damping, counts as the same: an imperfect effect bends it by as much.
AS_STIFF, AS_DAMPED = 0.02, 0.1
WRONG = 0.1  # relative fall of the held-out error from which given numbers are called wrong: an imperfect effect bends them a little


def check_numbers(search: Search, given: Model) -> None:
    """Name `parameters` where the numbers of the given model are wrong even with every named cause in it; where they are not, the given
    numbers stay. Those of its effects alone are changed where that is enough: a simulation may contain an effect that the record has
    not."""
    every = search.present
    skin = replace(given.dispersion, m=every.model.dispersion.m)  # the weight of skin that a tare took away is no wrong number
    as_given = replace(given, dispersion=skin, effects=(*given.effects, *_added(given, every.model)))

    def fit_added(model: Model, sessions: list[Session], noise: Whitener, iterations: int = ITERATIONS) -> Fit:
        free = tuple(u for u in effect_unknowns(model, sessions[0]) if u.part >= len(given.effects))
        return fit(model, sessions, noise, iterations, free)

    kept = fit_added(as_given, search.train, search.noise)
    wrong, why = _wrong(search, given, kept, every, fit_added)
    if not wrong:
        search.hardware |= {PARAMETERS: why} if why else {}
        search.present = kept
        return
    effects = fit_effects(as_given, search.train, search.noise)
    search.present = every if not given.effects or _wrong(search, given, effects, every, fit_effects)[0] else effects
    gain = search.gain(kept.model, search.present.model, "skin", fit_added)
    finding = Named(*PARAMETERS, gain, kept.cost - search.present.cost, (), given, search.present.model)
    search.named.insert(0, finding)


def _wrong(search: Search, given: Model, before: Fit, after: Fit, refit_before: Callable) -> tuple[bool, NotNamed | None]:
    """Whether numbers that `before` holds are wrong, as `after` has changed them. If hardware accounts for the change, they are not, and
    the reason is returned too."""
    gain = search.gain(before.model, after.model, "skin", refit_before)
    if not (gain.passed and gain.before - gain.after > WRONG * gain.before and _others(given, after.model)):
        return False, None
    # Noise of the depth, or of a force that drives the test, biases damping by as much.
    as_if = DAMPING if _but_for_damping(given, after.model) else PARAMETERS
    why = encoder_does(Claim(as_if, gain, before.model, after.model, search.train), search.noise, search.encoder_step)
    return why is None, why


def _others(given: Model, after: Model) -> bool:
    """Whether numbers of the skin, or of the given effects, have changed by an amount that matters."""
    damping = AS_DAMPED * abs(given.dispersion.b1 + given.dispersion.b2)
    was, now = ((m.dispersion.b1, m.dispersion.b2) for m in (given, after))
    return not _but_for_damping(given, after) or any(abs(n - w) > damping for w, n in zip(was, now, strict=True))


def _but_for_damping(given: Model, after: Model) -> bool:
    """Whether stiffness and shares are practically the same, and the given effects exactly: then only damping may have changed."""
    was, now = ((m.dispersion.k1, m.dispersion.k2, *m.shares) for m in (given, after))
    same = all(abs(n - w) <= AS_STIFF * abs(w) for w, n in zip(was, now, strict=True))
    return same and given.effects == after.effects[: len(given.effects)]


def _added(given: Model, extended: Model) -> tuple[Effect, ...]:
    """The effects of an extended model beyond those of the given one, matched by class and place whatever their numbers have become."""
    had, added = [(type(e), e.where) for e in given.effects], []
    for e in extended.effects:
        if (type(e), e.where) in had:
            had.remove((type(e), e.where))
        else:
            added.append(e)
    return tuple(added)
