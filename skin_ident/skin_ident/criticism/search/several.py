"""A cause that explains most only by several instances of it may stand for several causes.

Skin that relaxes twice, once within milliseconds and once over hours, explains nearly as much as a load cell that lags and skin that
stiffens; with one instance it explains less than the lag. So where, with one instance each, another cause explains more or nearly as much,
that cause is taken for granted, and the search looks one step further. If the cause that comes next beside it makes the better account of
the two, the other cause is tried first. It must be clearly better; any amount will do where the several instances follow several laws, and
so are hardly one cause. Where the first of the several instances does better with one other cause, it keeps its place, alone. Where
another cause explains as much with one instance, that is the plainer account, and goes first.
"""

from skin_ident.criticism.search.rivals import CHANCE_SCORE, reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.trial import Trial

NEARLY = 0.9  # share of the first instance's score, above which another cause is tried with what comes beside it


def single_before_several(search: Search, trials: list[Trial]) -> list[Trial]:
    """The trials, the best first. Before a best one of several instances goes another cause that explains nearly as much with one instance
    and, with the next cause, more than all of those. Not before a cause that the record itself has shown, nor where nothing explains enough
    to be named."""
    if not (trials and trials[0].plainer and search.lasts) or trials[0].key in search.suspected:
        return trials
    best = trials[0]
    by_chance = CHANCE_SCORE * len(best.fit.model.having(best.key))  # each instance had the chance
    plain = next((t for t in trials if t.plainer is None and t.score > best.score - by_chance), None)
    if plain:
        return [plain, *(t for t in trials if t is not plain)]
    if best.score < search.least(best.fit.count):
        return trials
    other = max((t for t in trials if t.key[0] != best.key[0]), key=_alone, default=best)
    if other is best or _alone(other) <= NEARLY * _alone(best):
        return trials
    first = other.forms[-1]
    led = _leads_to(search, first, best)
    if led is None:
        return trials
    own = _leads_to(search, best.plainer, best)
    if own is not None and own > led:
        first, other = best.plainer, best
    return [first, *(t for t in trials if t is not other)]


def _alone(trial: Trial) -> float:
    """Score of the first instance."""
    return trial.forms[-1].score


def _leads_to(search: Search, first: Trial, best: Trial) -> float | None:
    """What `first` and the cause that explains most beside it explain in the present noise. None where the `best` explains more with its
    several instances, or hardly less if these are of one law, and where that other cause is that of the `best`, unless `first` is as
    well."""
    search.progress(f"looking for a further cause beside {first.key[0]} in the {first.key[1]}")
    ahead = search.ahead(first.fit)
    following = ahead.trials(ahead.look())
    following = [t for t in following if t.key[0] != first.key[0]] if first.key == best.key else following
    if not following or following[0].key[0] == best.key[0]:
        return None
    before, both, several = (fit.under(ahead.noise, ahead.train) for fit in (search.present, following[0].fit, best.fit))
    laws = {type(e) for e in best.fit.model.having(best.key)}
    gained = both.score_over(before)
    if (gained if len(laws) > 1 else reach(gained)) <= several.score_over(before):
        return None
    return both.under(search.noise, search.train).score_over(search.present)
