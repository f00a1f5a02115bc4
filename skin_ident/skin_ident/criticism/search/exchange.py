"""Whether what was named while other causes were still hidden is the best account now that these are known.

A search that only goes forward keeps what it took first, and of two effects the first to be named was chosen to explain some of the other
as well. So each cause is taken out once the others are known, and the search looks again for what explains the rest (P. Pudil, J.
Novovičová, J. Kittler, Floating search methods in feature selection, Pattern Recognition Letters 15 (1994) 1119-1125).

Of two names for the same signal, the one that explains a little more may leave a rest that no other cause explains well, while beside its
rival another cause does. So where a cause explains much of the residual and is not believed, the rivals are tried, each in the place of its
finding.
"""

from dataclasses import replace

from skin_ident.criticism.baseline.fitting import Fit, cost_of, fit
from skin_ident.criticism.search.believing import first_believed
from skin_ident.criticism.search.choosing import choose
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.own import take_course
from skin_ident.criticism.search.rivals import CHANCE_SCORE, PROMISING, Rival, reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.together import beside
from skin_models.effect import Effect
from skin_models.model import Model

MUCH = 4.0  # times the least gain worth naming, which a cause that is not believed must explain for rivals to be tried
FEWER = 3  # parameters fewer, from which an account is clearly simpler


def exchange(search: Search) -> bool:
    """Put the better account in the place of the first finding that has one; return whether there was one. Where the same cause is found
    again, its rivals are replaced by those it has now. Not done for short records. `search` is the state of `criticise`."""
    if not search.lasts:
        return False
    several = len(search.named) > 1 or search.own_skin  # what was named first had to explain what differs between skins as well
    if several and any(_exchanged(search, finding) for finding in _shared(search) if not search.is_new(finding)):
        return True
    return search.refused > MUCH * search.least(search.present.count) and any(_for_rival(search, finding) for finding in _shared(search))


def _shared(search: Search) -> list[Named]:
    """The findings that all sessions share."""
    return [n for n in search.named if not (n.courses or n.only)]


def _exchanged(search: Search, finding: Named) -> bool:
    """Whether something explains more in the place of `finding`, and was put there."""
    search.progress(f"testing whether another cause explains more than {finding.cause} in the {finding.where}")
    ahead, key = _without(search, finding), finding.key
    last = ahead.look()
    explained = _explained(search.present, ahead)
    runs = ahead.own_courses()
    glance = {r.key: r.score for r in last.ranked}
    itself = min(explained, glance.pop(key, explained))
    if max([*glance.values(), *(r.score for r in runs)], default=0.0) < PROMISING * itself:
        return False
    trials = ahead.trials(last)
    explained = max([explained, *(t.score for t in trials if t.key == key)])
    own, shared = choose(ahead, trials, runs)
    if not (own or shared):
        return False
    other = (own or shared)[1]
    if other.cause == finding.cause:
        _renew_rivals(search, finding, (Rival(*other.key, 0.0, shared[0].model if shared else None), *other.alternatives))
        return False
    numbers = len(shared[0].unknowns) - len(search.present.unknowns) if shared else 0
    if other.key in search.put_out or not _better(other.explained, explained, numbers):
        if other.explained > reach(explained) and other.key not in {n.key for n in search.named}:
            near = Rival(*other.key, max(explained - other.explained, 0.0), shared[0].model if shared else None)
            _replace(search, finding, finding.with_rivals([near]))
        return False
    search.put_out.add(key)
    _become(search, ahead, finding)
    if own:
        take_course(search, *own)
    else:
        search.accept(*shared)
    return True


def _renew_rivals(search: Search, finding: Named, near: tuple[Rival, ...]) -> None:
    """Replace the alternatives of `finding` by the names that are `near` now that the other causes are known, if it is among these
    itself."""
    if finding.key in {a.key for a in near}:
        known = {n.key for n in search.named}
        _replace(search, finding, replace(finding, alternatives=tuple(a for a in near if a.key not in known)))


def _replace(search: Search, finding: Named, by: Named) -> None:
    search.named = [by if n is finding else n for n in search.named]


def _better(other: float, than: float, numbers: int) -> bool:
    """Whether one account explains more than another. With clearly fewer `numbers` (difference in parameters) it need only explain as much;
    with clearly more it must explain clearly more."""
    if numbers <= -FEWER:
        return other > reach(than)
    return reach(other) > than if numbers >= FEWER else other > than


def _for_rival(search: Search, finding: Named) -> bool:
    """Replace `finding` by the rival beside which another cause is believed, where both together explain more than the present account."""
    known = {n.key for n in search.named}
    for rival in (r for r in finding.alternatives if r.key not in known):
        own = rival.model.having(rival.key) if rival.model else ()
        if own and _taken(search, finding, rival, own):
            return True
    return False


def _taken(search: Search, finding: Named, rival: Rival, own: tuple[Effect, ...]) -> bool:
    """Whether the `own` effects of a rival were put in the place of `finding`: beside the rival another cause is believed, and the rival
    beside it."""
    search.progress(f"testing {rival.cause} in the {rival.where} with a second cause instead")
    rest = search.present.model.lacking(finding.key)
    ahead = _ahead(search, finding, replace(rest, effects=(*rest.effects, *own)))
    last, alone = ahead.look(), ahead.present
    lacks = alone.cost - cost_of(search.present.model, ahead.train, ahead.noise)
    if max((r.gain for r in last.ranked if r.cause not in (finding.cause, rival.cause)), default=0.0) < PROMISING * lacks:
        return False
    shared = first_believed(ahead, ahead.trials(last), [])
    if shared is None or shared[1].cause in (finding.cause, rival.cause):
        return False
    _, gain = beside(ahead, rival.key, shared[0].model)
    more = cost_of(search.present.model, ahead.train, ahead.noise) - shared[0].cost
    if gain is None or more <= MUCH * search.least(shared[0].count) or _as_good_with(search, ahead, finding, rival, shared[0]):
        return False
    _become(search, ahead, finding)
    search.befores[rival.key] = finding.before or rest
    search.accept(alone, Named(*rival.key, gain, finding.explained - rival.short_by, (), finding.before, rival.model))
    search.accept(*shared)
    return True


def _as_good_with(search: Search, ahead: Search, finding: Named, rival: Rival, after: Fit) -> bool:
    """Whether the fit `after`, of a `rival` and another cause beside it, is no better than with `finding` in the rival's place: then that
    other cause speaks for neither."""
    rest = after.model.lacking(rival.key)
    own = search.present.model.having(finding.key)
    return fit(replace(rest, effects=(*rest.effects, *own)), ahead.train, ahead.noise).cost < after.cost + CHANCE_SCORE


def _become(search: Search, ahead: Search, finding: Named) -> None:
    """Make the state of `search` that of `ahead`, without `finding`."""
    search.named, search.present, search.noise = ahead.named, ahead.present, ahead.noise
    search.befores.pop(finding.key, None)


def _without(search: Search, finding: Named) -> Search:
    """The state in which everything but `finding` has been named."""
    return _ahead(search, finding, search.present.model.lacking(finding.key))


def _ahead(search: Search, finding: Named, model: Model) -> Search:
    """The same, with `model` fitted."""
    ahead = search.ahead(fit(model, search.train, search.noise))
    ahead.named = [n for n in search.named if n is not finding]
    return ahead


def _explained(present: Fit, without: Search) -> float:
    """What `present` explains beyond the state `without`, measured as a trial's score is."""
    return present.under(without.noise, without.train).score_over(without.present)
