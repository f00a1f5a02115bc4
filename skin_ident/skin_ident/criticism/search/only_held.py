"""A cause of the catalogue that only held-out sessions have: a filter that was switched on, a screw that came loose on the last day.

No fitted session has it, so nothing held out can confirm it, and it is named only once such a session is among the fitted ones. But a
course of these sessions that explains clearly less is not named either. So every cause is fitted to the held-out sessions in which the
residual is louder than in the fitted ones.
"""

import numpy as np

from skin_ident.criticism.baseline.fitting import cost_of, fit, whitened
from skin_ident.criticism.courses.course import fitted
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.gates.uncertain import left_open
from skin_ident.criticism.search.doubt import only_held
from skin_ident.criticism.search.rivals import reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.survey import survey
from skin_ident.criticism.search.trial import Trial
from skin_ident.criticism.sessions.session import Session

LOUD = 1.1  # ratio of the whitened mean square to that of the fitted sessions, above which a held-out session has something of its own
LESS = 0.9  # share of what a course leaves, which a cause may leave to be better


def tell_of_held(search: Search) -> None:
    """Note the cause that explains most of what held-out sessions alone have, where nothing is named there."""
    if search.alone is None and not search.doubts:
        note_cause_of_held(search)


def note_cause_of_held(search: Search, run: Run | None = None) -> bool:
    """Note that a cause which only held-out sessions have is in doubt, if it explains clearly more of them than a course does. Return
    whether it was noted."""
    odd = _louder(search)
    if not odd:
        return False
    trials = _trials(search, odd)
    if not trials or trials[0].score < search.least(trials[0].fit.count):
        return False
    as_good = [t for t in trials if t.score > reach(trials[0].score)]
    if run and (any(t.key in run.course.keys for t in as_good) or not _better(search, trials[0], run, odd)):
        return False
    search.doubts |= {t.key: only_held(tuple(s.name for s in odd)) for t in as_good}
    return True


def _louder(search: Search) -> list[Session]:
    """The held-out sessions whose residual is louder than that of the fitted ones."""
    usual = _mean_square(search, search.train)
    return [s for s in search.held if _mean_square(search, [s]) > LOUD * usual]


def _mean_square(search: Search, sessions: list[Session]) -> float:
    r = whitened(search.present.model, sessions, search.noise)
    return float(r @ r) / max(np.count_nonzero(r), 1)


def _trials(search: Search, sessions: list[Session]) -> list[Trial]:
    """The causes that explain most of some sessions beside numbers of their own."""
    ahead = search.ahead(fit(search.present.model, sessions, search.noise))
    ahead.train, ahead.held = sessions, []
    return ahead.trials(survey(ahead.present.model, sessions, search.which, search.noise))


def _better(search: Search, trial: Trial, run: Run, sessions: list[Session]) -> bool:
    """Whether a trial explains clearly more of some sessions than a course does, less charges, or leaves clearly less."""
    model, after = search.present.model, trial.fit
    before = cost_of(model, sessions, search.noise)
    explained = before - after.cost - np.log(after.count) * len(after.unknowns)
    by_course = fitted(run.course, model, sessions, search.noise, left_open(model, search.train, sessions, search.noise)).score
    return reach(explained) > by_course or before - explained < LESS * (before - by_course)
