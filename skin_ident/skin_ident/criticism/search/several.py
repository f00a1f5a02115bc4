"""A cause that explains most only by several instances of it may stand for several causes.

A load cell that lags and skin that stiffens are both explained, nearly, by skin that relaxes twice, once within milliseconds and once over
hours; either one of those explains less than the lag does. So where with one instance each another cause explains more, it is taken for
granted, and the search looks one step further: if what comes next beside it makes the better account of the two, it is asked first.
"""

from dataclasses import replace

from skin_ident.criticism.baseline.fitting import Fit, cost_of
from skin_ident.criticism.search.rivals import reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.trial import Trial


def in_order(search: Search, trials: list[Trial]) -> list[Trial]:
    """The trials, the best first; before one of several instances that other which explains more alone, and more than it with the next."""
    best, others = (trials[0], trials[1:]) if trials else (None, [])
    if best is None or best.plainer is None or not search.lasts:
        return trials
    alone = max((t for t in others if t.key[0] != best.key[0]), key=_alone, default=None)
    if alone is None or _alone(alone) <= _alone(best) or not _leads_further(search, alone, best):
        return trials
    return [alone.forms[-1], *(t for t in trials if t is not alone)]


def _alone(trial: Trial) -> float:
    """What the first instance explains."""
    return trial.forms[-1].score


def _leads_further(search: Search, first: Trial, best: Trial) -> bool:
    """Whether `first` alone and the cause that explains most beside it are clearly better than the `best` by its several instances, which
    that cause is not."""
    search.progress(f"asking what is beside {first.key[0]} in the {first.key[1]}")
    ahead = search.ahead(first.forms[-1].fit)
    following = ahead.trials(ahead.look())
    if not following or best.key[0] in (t.key[0] for t in following[:1]):
        return False
    pair = following[0]

    def weighed(fit: Fit) -> Fit:
        return replace(fit, cost=cost_of(fit.model, ahead.train, ahead.noise))

    before = weighed(search.present)
    together, several = (weighed(t.fit).gain_over(before) for t in (pair, best))
    return reach(together) > several
