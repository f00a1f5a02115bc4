"""The mass of the dispersion model, where it is not that of the skin.

A mass m under the plunger takes m g from the force while they touch, and nothing in the air. The skin's own mass weighs next to nothing
(0.4 g, thesis 4.3.1), so it is set. But fits with a free mass, as those of Tables 4-1 to 4-4, find some 0.2 kg, which is 2 N. Three kinds
of record would be misread with the mass that was set:

- that of such a model, or of a plunger that really leans on the skin, as three faults of sensors;
- one whose declared mass hangs on a load cell tared with it, likewise;
- one of a skin that weighs less than the 4 mN that were set: a good load cell would show it as a curvature.

So when something is wrong the mass is tried beside all causes; that of a given model only where it is of skin, which may weigh nothing
after a tare. A declared mass hangs where that, and some cause beside it, explains as much as any cause beside its weight; only its inertia
belongs to the baseline then. Where a free mass accounts for the record better than any cause, it does. A mass that was assumed, because
nobody declared one, is only an upper bound. Where a smaller one explains enough, whatever else is wrong, the mass is fitted between zero
and that bound. It is held again at the end if it need not have been fitted.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.fitting import Fit, fit
from skin_ident.criticism.gates.gate import MATERIAL_FALL, breadth_of
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.search.rivals import CHANCE_SCORE, reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.trial import Trial
from skin_ident.criticism.sessions.session import Session, having_all, hung, weighed
from skin_models.effects.inertia import Inertia
from skin_models.model import Model
from skin_models.signals import GRAVITY

LIGHTER = 0.5  # of the mass that was set; a fitted one below this contradicts it
COUNTS = 0.25  # of what the best of all causes explains; a mass that explains less waits
# kg, of a few square centimetres as thick as a finger's width: the most that skin under a plunger may weigh. A mass that was set to this or
# more may hang on the load cell.
OF_SKIN = 0.005


def other_mass(search: Search) -> Fit | None:
    """The fit with the mass free, where the mass may differ as the free one does and that explains enough to matter."""
    free = with_mass(search.present, search.train, search.noise) if search.weighable else None
    return free if free and (lighter(search.present.model, free.model) or not search.only_lighter) else None


def with_mass(present: Fit, sessions: list[Session], noise: Whitener) -> Fit | None:
    """The fit with the mass free, where it was set and that explains enough to matter."""
    if not _is_set(sessions[0]):
        return None
    free = fit(present.model, weighed(sessions), noise)
    return free if free.score_over(present) > _least(free, sessions) else None


def with_hanging(present: Fit, sessions: list[Session], noise: Whitener) -> tuple[Fit, list[Session]] | None:
    """The fit with the mass hanging on the load cell as heavy as it was set, and the sessions as it sees them, where that explains enough
    to matter; else None."""
    m = present.model.dispersion.m
    if m < OF_SKIN or not _is_set(sessions[0]):
        return None
    sessions = hung(sessions, m)
    found = fit(replace(present.model, dispersion=replace(present.model.dispersion, m=0.0)), sessions, noise)
    return (found, sessions) if found.score_over(present) > _least(found, sessions) else None


def _is_set(session: Session) -> bool:
    """Whether the mass is set in a session that could show it."""
    return not session.free_mass and session.drive is None and "force" in session.channels


def weighs_as_skin(given: Model) -> bool:
    """Whether the mass of a given model is one that skin may have, so that its weight may be missing from the record without a fault."""
    return 0.0 < given.dispersion.m < OF_SKIN


def heaviest_of(present: Model, free: Model) -> float:
    """The mass up to which it is to be fitted, kg: one that came out lighter than what was set does not become heavier than that."""
    return present.dispersion.m if lighter(present, free) else np.inf


def held_again(present: Fit, sessions: list[Session], noise: Whitener) -> Fit | None:
    """The fit with the mass held at its upper bound, where that is as good; else None."""
    m = sessions[0].heaviest
    if not 0.0 < m < np.inf:
        return None
    held = fit(replace(present.model, dispersion=replace(present.model.dispersion, m=m)), weighed(sessions, 0.0), noise)
    return held if present.score_over(held) < _least(held, sessions) else None


def hung_mass(search: Search, best: float) -> Fit | None:
    """The fit with a declared mass that hangs, where some cause beside it explains as much as the `best` one beside the mass as it was set,
    which must account for the missing weight as well: whatever bends does that, and then the right cause is not seen."""
    hanging = with_hanging(search.present, search.train, search.noise) if search.declared and search.weighable else None
    if hanging is None:
        return None
    found, sessions = hanging
    ahead = search.ahead(found)
    ahead.train = sessions
    beside = max((t.score for t in ahead.trials(ahead.survey())), default=0.0)
    return found if found.score_over(search.present) + beside > reach(best) else None


def weighs(search: Search, free: Fit, best: float) -> bool:
    """Whether the mass is taken as it was fitted, `free`, where `best` is the most that any cause explains."""
    present = search.present
    if lighter(present.model, free.model) and not search.declared and counts_beside(search, free, best):
        return True
    return tells_more(free, present, best, may_be_skin(search, free)) or settles(search, free, best)


def may_wait(search: Search, free: Fit) -> bool:
    """Whether the `free` mass may be taken where no cause is found: it is lighter than what was set, or may be the skin's."""
    return lighter(search.present.model, free.model) or may_be_skin(search, free)


def may_be_skin(search: Search, free: Fit) -> bool:
    """Whether the `free` mass, where none was declared, is one that skin may have, with several channels to tell it from a cause."""
    return not search.declared and len(search.train[0].channels) > 1 and free.model.dispersion.m < OF_SKIN


def tells_more(free: Fit, present: Fit, best: float, may_be: bool = False) -> bool:
    """Whether the `free` mass explains clearly more than the `best` of all causes does (squared whitened units). As much is enough where it
    is lighter than the mass that was set, or `may_be` the skin's."""
    gained, m = free.score_over(present), free.model.dispersion.m
    if lighter(present.model, free.model) or may_be:
        return gained > reach(best)
    return m > present.model.dispersion.m and reach(gained) > best


def counts_beside(search: Search, free: Fit, best: float) -> bool:
    """Whether the `free` mass explains enough to matter beside the `best` of all causes, and by itself rather than because the model was
    fitted once more. While newtons are unexplained, millinewtons of weight can wait."""
    again = fit(search.present.model, search.train, search.noise)
    return free.score_over(again) > max(COUNTS * best, _least(free, search.train))


def settles(search: Search, free: Fit, best: float) -> bool:
    """Whether the `free` mass explains more than the `best` of all causes, though not clearly, and leaves nothing worth naming for any of
    them."""
    if free.score_over(search.present) <= best:
        return False
    ahead = search.ahead(free)
    ahead.train = weighed(search.train, heaviest_of(search.present.model, free.model))
    return ahead.look().ranked[0].score < search.least(free.count)


def unveils(search: Search, free: Fit, trials: list[Trial], best: float) -> bool:
    """Whether beside the `free` mass, which may be the skin's, another cause explains clearly more than the `best` of all does beside the
    mass that was assumed, of which the first of `trials` is the best: it has to account for a few millinewtons of weight as well, which
    whatever bends does."""
    if not (trials and may_be_skin(search, free)):
        return False
    ahead = search.ahead(free)
    ahead.train = weighed(search.train, heaviest_of(search.present.model, free.model))
    survey, first = ahead.survey(), trials[0].key
    if survey.ranked[0].key == first:
        return False
    beside = max((t.score for t in ahead.trials(survey) if t.key != first), default=0.0)
    return free.score_over(search.present) + beside > best + max(CHANCE_SCORE, search.least(free.count))


def weigh(search: Search, free: Fit) -> None:
    """Take the fit with another mass, which is fitted from now on. What has been named without it must be found again, unless the mass is
    no more than what was assumed of the skin's own."""
    before = search.present.model
    heaviest, kept = heaviest_of(before, free.model), lighter(before, free.model) and not search.declared
    model = free.model if kept else replace(free.model, effects=())
    _take(search, model, *(weighed(sessions, heaviest) for sessions in (search.train, search.held)), kept)


def hang(search: Search, found: Fit) -> None:
    """Take the fit with the declared mass hanging on the load cell, where it stays as it was declared. What has been named without that
    must be found again."""
    m = search.present.model.dispersion.m
    _take(search, replace(found.model, effects=()), *(hung(sessions, m) for sessions in (search.train, search.held)), False)


def _take(search: Search, model: Model, train: list[Session], held: list[Session], kept: bool) -> None:
    """Take a model of another mass, with the sessions that it is fitted to and tested with; whether what was named is `kept`."""
    search.progress("fitting the mass, too")
    search.train, search.held = train, held
    search.present = fit(model, train, search.noise)
    # The noise with the other mass was that of a wrong model.
    search.present = fit(search.present.model, train, search.survey().noise)
    if not kept:
        search.train, search.held = having_all(train), having_all(held)
        search.named, search.befores, search.wandering = [n for n in search.named if n.courses], {}, 0.0
    search.go_on()


def unweigh(search: Search) -> None:
    """Hold the mass at what was assumed again where that does as well, now that causes are named."""
    held = None if search.declared else held_again(search.present, search.train, search.noise)
    if held:
        search.present, search.train, search.held = held, weighed(search.train, 0.0), weighed(search.held, 0.0)


def _least(free: Fit, sessions: list[Session]) -> float:
    """What the mass must explain to matter. Only the force shows it; as for every cause that few channels carry, less is enough then."""
    return MATERIAL_FALL * free.count * breadth_of(1, len(sessions[0].channels))


def with_hung(model: Model, session: Session) -> Model:
    """The model as it is written down: with the inertia of a mass that hangs on the load cell, where the session has one."""
    return model.extended(Inertia("rig", mass=session.hung)) if session.hung else model


def lighter(before: Model, after: Model) -> bool:
    """Whether the fitted mass is so much smaller that the mass that was set does not lean on the skin."""
    return after.dispersion.m < LIGHTER * before.dispersion.m


def mass_warnings(mass: float, before: float, declared: bool) -> Iterator[str]:
    """A warning that the mass was fitted, where it had been set to that of the skin, or as `declared`. None where skin is lighter than was
    assumed: that the load cell reads no weight of millinewtons in contact is common, for one after a tare, and no fault."""
    force = abs(mass - before) * GRAVITY
    if declared and mass == 0.0 and before >= OF_SKIN:
        yield (
            f"the declared mass ({before:.3g} kg) is taken to hang on a load cell that was tared with it, and to be felt by its inertia "
            f"alone: resting on the skin, its weight would take {force:.3g} N from the load cell while the plunger touches, and the record "
            "shows nothing of that (fit such recordings with --mass 0)"
        )
    elif declared and mass < before:
        yield (
            f"the model's mass was fitted, {mass:.3g} kg: with the declared one ({1e3 * before:.3g} g) the record cannot be explained, "
            f"since its weight would take {force:.3g} N from the load cell while the plunger touches"
        )
    elif mass >= before:
        of = "the declared one" if declared else "that of the skin"
        yield (
            f"the model's mass was fitted, {mass:.3g} kg: with {of} ({1e3 * before:.3g} g) the record cannot be explained. It "
            f"stands for a force of {force:.3g} N that is missing while the plunger touches; weigh what moves with the skin "
            "(moving_mass_kg in rig.yaml), or look for what else takes that force"
        )
