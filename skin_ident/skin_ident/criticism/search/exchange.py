"""Whether what was named while other causes were still hidden is the best account now that these are known.

A search that only goes forward keeps what it took first, and of two effects the first to be named was chosen to explain some of the other
as well. So each cause is taken out once the others are known, and everything is asked again what explains the rest (P. Pudil, J.
Novovičová, J. Kittler, Floating search methods in feature selection, Pattern Recognition Letters 15 (1994) 1119-1125).
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from skin_ident.criticism.baseline.fitting import Fit, cost_of, fit
from skin_ident.criticism.search.growing import lacking
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.own import take_course
from skin_ident.criticism.search.together import lasts

if TYPE_CHECKING:
    from skin_ident.criticism.search.search import Search

PROMISING = 0.8  # of what a cause explains, or seems to at first glance, from which another one may explain more once it is fitted


def exchange(search: "Search") -> bool:
    """Put the better account in the place of the first finding that has one, and say whether there was one; where the same cause is found
    again, its rivals are those it has now. Not asked of short records. `search` is the state of `criticise`."""
    several = len(search.named) > 1 and lasts(search)
    return several and any(_exchanged(search, finding) for finding in tuple(search.named) if not finding.courses)


def _exchanged(search: "Search", finding: Named) -> bool:
    search.progress(f"asking again what {finding.cause} in the {finding.where} stands for")
    ahead, key = _without(search, finding), (finding.cause, finding.where)
    last = ahead.look()
    explained = _explained(search.present, ahead)
    runs = ahead.own_courses()
    glance = {(r.cause, r.where): r.score for r in last.ranked}
    itself = min(explained, glance.pop(key, explained))
    if max([*glance.values(), *(r.score for r in runs)], default=0.0) < PROMISING * itself:
        return False
    trials = ahead.trials(last)
    explained = max([explained, *(t.score for t in trials if t.key == key)])
    own, shared = ahead.choose(trials, runs)
    if not (own or shared):
        return False
    other = (own or shared)[1]
    if (other.cause, other.where) == key:
        known = {(n.cause, n.where) for n in ahead.named}
        again = replace(finding, alternatives=tuple(a for a in other.alternatives if a.key not in known))
        search.named = [again if n is finding else n for n in search.named]
    if other.cause == finding.cause or other.explained <= explained:
        return False
    search.named, search.present, search.noise = ahead.named, ahead.present, ahead.noise
    search.befores.pop(key, None)
    if own:
        take_course(search, *own)
    else:
        search.accept(*shared)
    return True


def _without(search: "Search", finding: Named) -> "Search":
    """The state in which everything but `finding` has been named."""
    rest = lacking(search.present.model, finding.cause, finding.where)
    ahead = search.ahead(fit(rest, search.train, search.noise))
    ahead.named = [n for n in search.named if n is not finding]
    return ahead


def _explained(present: Fit, without: "Search") -> float:
    """What `present` explains beyond the state `without`, as a trial's score is."""
    cost = cost_of(present.model, without.train, without.noise)
    charge = np.log(present.count) * (len(present.unknowns) - len(without.present.unknowns))
    return float(without.present.cost - cost - charge)
