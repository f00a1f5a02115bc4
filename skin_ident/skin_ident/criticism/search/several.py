"""A cause that explains most only by several instances of it may stand for several causes.

A load cell that lags and skin that stiffens are both explained, nearly, by skin that relaxes twice, once within milliseconds and once over
hours; either one of those explains less than the lag does. So where with one instance each another cause explains more, or nearly as much,
it is taken for granted, and the search looks one step further: if what comes next beside it makes the better account of the two, it is
asked first. Clearly the better one, or, where the several instances are of several laws and hardly one cause, any.
"""

from skin_ident.criticism.search.rivals import reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.trial import Trial

NEARLY = 0.9  # of what the first instance explains, from which another cause alone is asked what comes beside it


def single_before_several(search: Search, trials: list[Trial]) -> list[Trial]:
    """The trials, the best first; before one of several instances that other which explains nearly as much alone, and more than it with the
    next; not before one that the record itself has shown."""
    if not (trials and trials[0].plainer and search.lasts) or trials[0].key in search.suspected:
        return trials
    best = trials[0]
    other = max((t for t in trials if t.key[0] != best.key[0]), key=_alone, default=best)
    if other is best or _alone(other) <= NEARLY * _alone(best) or not _leads_further(search, other.forms[-1], best):
        return trials
    return [other.forms[-1], *(t for t in trials if t is not other)]


def _alone(trial: Trial) -> float:
    """What the first instance explains."""
    return trial.forms[-1].score


def _leads_further(search: Search, first: Trial, best: Trial) -> bool:
    """Whether `first` and the cause that explains most beside it, which is not that of the `best`, are better than its several instances;
    clearly so where these are of one law."""
    search.progress(f"asking what is beside {first.key[0]} in the {first.key[1]}")
    ahead = search.ahead(first.fit)
    following = ahead.trials(ahead.look())
    if not following or following[0].key[0] == best.key[0]:
        return False
    before, both, several = (fit.under(ahead.noise, ahead.train) for fit in (search.present, following[0].fit, best.fit))
    laws = {type(e) for e in best.fit.model.effects[len(search.present.model.effects) :]}
    gained = both.gain_over(before)
    return (gained if len(laws) > 1 else reach(gained)) > several.gain_over(before)
