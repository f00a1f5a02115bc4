"""The whole criticism of a baseline: search, repeat what later findings may change, eliminate, and report what is left."""

from dataclasses import replace

from skin_ident.criticism.baseline.comparing import comparable
from skin_ident.criticism.baseline.fitting import Fit, fit
from skin_ident.criticism.baseline.residual import residual, rmse
from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.search.alone import drop_alone
from skin_ident.criticism.search.doubt import unproven
from skin_ident.criticism.search.driving import with_load_cell
from skin_ident.criticism.search.exchange import exchange
from skin_ident.criticism.search.given_numbers import check_numbers
from skin_ident.criticism.search.named import Criticism
from skin_ident.criticism.search.only_held import tell_of_held
from skin_ident.criticism.search.own_again import drop_gain, settle_courses
from skin_ident.criticism.search.own_skin import settle_skin, tell_of_skin
from skin_ident.criticism.search.proposals import Direction, directions
from skin_ident.criticism.search.search import eliminate, run
from skin_ident.criticism.search.state import MOST_FINDINGS, Progress, Search
from skin_ident.criticism.search.survey import noise_beside
from skin_ident.criticism.search.unread_play import leave_play_to_hardware
from skin_ident.criticism.search.weighing import unweigh, weighs_as_skin
from skin_ident.criticism.sessions.session import Session, longest, weighed_as
from skin_ident.criticism.telemetry.pull import find_pull
from skin_ident.criticism.usable import enough_is_compared
from skin_ident.criticism.vocabulary import Key
from skin_models.model import Model

WORSE = 1.1  # ratio to the baseline's error in a channel, above which an extended model is worse


def criticise(
    train: list[Session],
    held: list[Session],
    given: Model | None = None,
    progress: Progress = lambda stage: None,
    mass: float = 0.0,
    more: tuple[Direction, ...] = (),
    encoder_step: float = 0.0,
    mass_declared: bool = False,
    most: int = MOST_FINDINGS,
) -> Criticism:
    """Find what the baseline gets wrong on `train`, accepting only what also predicts `held` better. `mass` is that of the skin, kg,
    assumed unless `mass_declared`; `more` are directions beside those of the catalogue; `encoder_step` is the step of the depth, m; `most`
    is the number of rounds at most. Raises `DiagnosisError` where too little of the sessions can be compared."""
    progress("fitting the baseline")
    start = given or dispersion_start(train, mass)
    train, held = comparable(train, held, start, start)
    enough_is_compared(train, held)
    every = (*directions(longest(train)), *more)
    noise = noise_beside(start, train, _asked(every, set()))
    fitted = fit(start, train, noise)

    def searched(suspected: set[Key]) -> Search:
        which, weighable = _asked(every, suspected), given is None or (weighs_as_skin(given) and not mass_declared)
        search = Search(
            train,
            held,
            which,
            progress,
            encoder_step=encoder_step,
            weighable=weighable,
            declared=mass_declared,
            only_lighter=given is not None,
            suspected=suspected,
            most=most,
        )
        search.baseline = fitted
        _name_all(search)
        return search

    shown = _shown(fitted.model, train)
    search = searched(shown)
    late = (_shown(search.present.model, [*search.train, *search.held]) & _in_whose_place(search)) - shown
    search = searched(late) if late else search  # beside the baseline's residual these could not be seen
    unweigh(search)
    settle_skin(search)
    tell_of_skin(search)
    tell_of_held(search)
    if given:
        check_numbers(search, given)
    leave_play_to_hardware(search)
    named = with_load_cell(search.named, search.present.model, search.runs, [*search.train, *search.held])
    told = (tuple(named), search.survey(), tuple(search.rounds))
    c = Criticism(search.baseline, search.present, *told, tuple(search.train), tuple(search.held), search.not_named, search.grown)
    c = replace(c, baseline=fit(given, train, noise, 0) if given else _baseline_beside(c, start, train))
    return _without_names(c, train, held) if _predicts_worse(c) else c


def _asked(every: tuple[Direction, ...], suspected: set[Key]) -> tuple[Direction, ...]:
    """The directions to be tested. Some effects are tested only where the record itself shows their cause, so that it is `suspected`."""
    return tuple(d for d in every if d.key in suspected or not d.effect.only_if_shown)


def _shown(model: Model, sessions: list[Session]) -> set[Key]:
    """The causes that the record itself shows beside a model."""
    return {(s.cause, s.where) for s in find_pull(model, sessions)}


def _in_whose_place(search: Search) -> set[Key]:
    """Causes in whose place another may have been named: the rivals of findings, and causes that ranked above the named one."""
    places = {a.key for n in search.named for a in n.alternatives}
    for survey, cause in search.rounds:
        first = next((i for i, r in enumerate(survey.ranked) if r.cause == cause), 0)
        places |= {r.key for r in survey.ranked[:first]}
    return places


def _name_all(search: Search) -> None:
    """Name one cause after the other, replace findings by causes that explain more in their place, and take out what nothing needs."""
    run(search, search.baseline)
    while len(search.rounds) < search.most and exchange(search):
        run(search, search.present)
    if settle_courses(search):
        run(search, search.present)
    drop_alone(search)
    if drop_gain(search):
        run(search, search.present)
    if eliminate(search) and _resumed(search):
        eliminate(search)


def _baseline_beside(c: Criticism, start: Model, train: list[Session]) -> Fit:
    """The plain model, as near to the record as it can be: fitted again in the noise that is left beside all causes. Where the mass is
    another, or sessions have a skin, zeros or a delay that are no finding, it has these, too."""
    plain = [c.as_before(s, own) for s, own in zip(train, c.train, strict=True)]
    as_weighed = c.train[0]
    if not (c.named or as_weighed.hung or as_weighed.free_mass or any(s.skin or s.late or s.beyond is not None for s in plain)):
        return c.baseline
    begin = replace(start, dispersion=replace(start.dispersion, m=c.extended.model.dispersion.m))
    return fit(begin, weighed_as(plain, as_weighed), c.last.noise)


def _predicts_worse(c: Criticism) -> bool:
    """Whether causes were named although, with them, no channel of held-out sessions is predicted better than by the baseline, and one
    clearly worse. Then each was compared with a model that others, or another mass, had led astray."""
    if not (c.named and c.held):
        return False
    before, after = (
        [rmse([residual(fitted.model, s)], [s]) for s in sessions]
        for fitted, sessions in ((c.baseline, [c.before(s) for s in c.held]), (c.extended, c.held))
    )
    times = [a[channel] / max(b[channel], 1e-300) for b, a in zip(before, after, strict=True) for channel in b]
    return min(times) >= 1.0 and max(times) > WORSE


def _without_names(c: Criticism, train: list[Session], held: list[Session]) -> Criticism:
    """The criticism with the baseline alone; all that was named is noted as in doubt."""
    bare = (
        tuple(replace(c.before(own), lacks=s.lacks) for own, s in zip(found, sessions, strict=True))
        for found, sessions in ((c.train, train), (c.held, held))
    )
    doubts = {n.key: unproven() for n in c.named}
    last = c.rounds[0][0] if c.rounds else c.last
    return Criticism(c.baseline, c.baseline, (), last, c.rounds, *bare, c.not_named | doubts, c.grown)


def _resumed(search: Search) -> bool:
    """Whether the findings change when the search goes on after causes were taken out."""
    named = list(search.named)
    search.go_on()
    run(search, search.present)
    return search.named != named
