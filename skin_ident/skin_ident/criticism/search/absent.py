"""A cause that all fitted sessions share and held-out ones lack: a filter that was taken out, a screw that was tightened on the last day.

Tested in all held-out sessions at once it seems refuted by them, and something of their own is named in its place. So each of them is asked
first whether it is clearly nearer without the best trial than with any amount of it. Where some are, the trial must pass every test in
those that are not. If all lack it, the fitted sessions must predict each other better with it; and the plain model, freed of what it had
taken up of the cause, must leave no more of the held-out ones than of the fitted, less than before, and less than any other cause does.
What passes is named with the sessions that have it. What only fitted sessions support is in doubt.
"""

from dataclasses import replace

from skin_ident.criticism.baseline.fitting import Fit, cost_of, cost_with_own
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.gates.gate import held_out_gain
from skin_ident.criticism.search.believing import DOUBTLESS, first_believed
from skin_ident.criticism.search.doubt import absent
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.only_held import mean_square
from skin_ident.criticism.search.partly import COIN, lacks, with_lacking
from skin_ident.criticism.search.rivals import reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.survey import Survey
from skin_ident.criticism.search.tared import take_tare
from skin_ident.criticism.search.trial import Trial
from skin_ident.criticism.sessions.session import Session

AS_WELL = 1.5  # ratio of the whitened mean square that is left of held-out sessions without the cause to that of fitted ones with it


def take_where_held(search: Search, last: Survey, best: float, trials: list[Trial], runs: list[Run]) -> bool:
    """Name the best trial with the sessions that have it, where held-out ones lack it, or note that it is in doubt. It must explain as much
    as the `best` of all other explanations. Return whether it was named."""
    trial = next(iter(trials), None)
    if trial is None or trial.key in {n.key for n in search.named} or not _explains_much(search, trial, best):
        return False
    lacking = [s for s in search.held if lacks(search, trial.fit, s, trial.key)]
    if not lacking:
        return False
    free = tuple(s.name for s in lacking)
    having = [s for s in search.held if s.name not in free]
    surely = not any(_has_its_own(search, trial, s) for s in lacking)
    believed = _believed(search, trial, trials, runs, having) if surely else None
    if not believed or not (having or _frees(search, trial, trials, runs)):
        asked = surely and not having
        if believed or (not asked and _believed(search, trial, trials, runs, [])):
            search.doubts[trial.key] = absent(free)
        return False
    fitted, named = believed
    named = replace(named, only=tuple(s.name for s in (*search.train, *having)), free=free)
    if take_tare(search, named):
        return True
    search.held = with_lacking(search.held, trial.key, free)
    search.end_round(last, trial.key[0])
    search.accept(fitted, named)
    return True


def _has_its_own(search: Search, trial: Trial, session: Session) -> bool:
    """Whether the cause in another amount or shape explains part of a session that is nearer without it than with what is fitted: where the
    plunger moves differently, an imperfect form may be worse than none."""
    key, model = trial.key, trial.fit.model
    having, lacking = (replace(session, lacks=lacks) for lacks in (session.lacks - {key}, session.lacks | {key}))
    return cost_with_own(model, key, [having], search.noise) < cost_of(model, [lacking], search.noise)


def _believed(search: Search, trial: Trial, trials: list[Trial], runs: list[Run], held: list[Session]) -> tuple[Fit, Named] | None:
    """The trial as a finding, if it is believed by these `held`-out sessions, or by each fitted one in turn where there are none."""
    if not held and len(search.train) < 2:
        return None
    ahead = search.ahead(search.present)
    ahead.held = held
    believed = first_believed(ahead, trials, runs)
    return believed if believed and believed[1].key == trial.key else None


def _frees(search: Search, trial: Trial, trials: list[Trial], runs: list[Run]) -> bool:
    """Whether the plain model without the cause predicts held-out sessions better than before the cause was fitted beside it, better than
    with another cause that is believed, and about as well as fitted sessions with it."""
    held, model = with_lacking(search.held, trial.key, [s.name for s in search.held]), trial.fit.model
    freed = held_out_gain(search.present.model, model, search.train, held, search.noise)
    if not freed.passed or mean_square(search, model, held) > AS_WELL * mean_square(search, model, search.train):
        return False
    other = first_believed(search.ahead(search.present), trials, runs)
    return other is None or freed.relative > other[1].gain.relative


def _explains_much(search: Search, trial: Trial, best: float) -> bool:
    """Whether a trial explains enough of training for a doubt; for every held-out session, having it or not is a choice."""
    coins = COIN * len(search.held)
    return trial.score - coins > max(reach(best), DOUBTLESS * search.least(trial.fit.count))
