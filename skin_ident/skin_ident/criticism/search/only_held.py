"""A cause of the catalogue that only held-out sessions have: a filter that was switched on, a screw that came loose on the last day.

No fitted session has it, so nothing held out can confirm it, and it is named only once such a session is among the fitted ones. But a
course of these sessions that explains clearly less is not named either. So every cause is fitted to the held-out sessions in which the
residual is louder than in the fitted ones.
"""

import numpy as np

from skin_ident.criticism.baseline.fitting import Fit, fit, whitened
from skin_ident.criticism.courses.course import worthwhile
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.search.doubt import only_held
from skin_ident.criticism.search.rivals import reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.survey import survey
from skin_ident.criticism.search.trial import Trial
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

LOUD = 1.1  # ratio of the whitened mean square to that of the fitted sessions, above which held-out ones have something of their own
LESS = 0.9  # share of what a course leaves, which a cause may leave to be better


def tell_of_held(search: Search) -> None:
    """Note the cause that explains most of what held-out sessions alone have, where nothing is named there."""
    if search.alone is None and not search.doubts:
        note_cause_of_held(search)


def note_cause_of_held(search: Search, run: Run | None = None) -> bool:
    """Note that a cause which only held-out sessions have is in doubt, if numbers of these sessions' own do not explain what is wrong,
    and the cause explains clearly more of it than courses do, such as the `run` that is about to be named. Return whether it was noted."""
    model, usual = search.present.model, mean_square(search, search.present.model, search.train)
    odd = [s for s in search.held if mean_square(search, model, [s]) > LOUD * usual]
    plain = fit(model, odd, search.noise) if odd else None
    if plain is None or mean_square(search, plain.model, odd) <= LOUD * usual:
        return False
    trials = _trials(search, plain, odd)
    if not trials or trials[0].score < search.least(plain.count):
        return False
    as_good = [t for t in trials if t.score > reach(trials[0].score)]
    if run and (any(t.key in run.course.keys for t in as_good) or not _better(search, trials[0], plain, odd)):
        return False
    search.doubts |= {t.key: only_held(tuple(s.name for s in odd)) for t in as_good}
    return True


def mean_square(search: Search, model: Model, sessions: list[Session]) -> float:
    """The mean square of the whitened residual: 1 where it is noise."""
    r = whitened(model, sessions, search.noise)
    return float(r @ r) / max(np.count_nonzero(r), 1)


def _trials(search: Search, plain: Fit, sessions: list[Session]) -> list[Trial]:
    """The causes that explain most of some sessions beside `plain`, a fit to these."""
    ahead = search.ahead(plain)
    ahead.train, ahead.held = sessions, []
    return ahead.trials(survey(plain.model, sessions, search.which, search.noise))


def _better(search: Search, trial: Trial, plain: Fit, sessions: list[Session]) -> bool:
    """Whether a trial explains clearly more of some sessions than every course does, or leaves clearly less."""
    by_course = max((r.score for r in worthwhile(plain.model, sessions, search.noise, search.encoder_step)), default=0.0)
    return reach(trial.score) > by_course or plain.cost - trial.score < LESS * (plain.cost - by_course)
