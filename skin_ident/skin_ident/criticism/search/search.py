"""The loop of a search for causes: survey all, try the best few, let held-out sessions decide, repeat."""

from dataclasses import dataclass

from skin_ident.criticism.baseline.fitting import Fit, fit
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.search.absent import take_where_held
from skin_ident.criticism.search.alone import take_alone
from skin_ident.criticism.search.choosing import choose
from skin_ident.criticism.search.growing import spared
from skin_ident.criticism.search.lateness import settle_lateness
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.own import take_course
from skin_ident.criticism.search.own_skin import (
    explained_by_own_skin,
    settle_skin,
    take_other_specimen,
    take_own_skin,
    take_own_skin_at_last,
    take_own_skin_of_held,
)
from skin_ident.criticism.search.partly import take_partly
from skin_ident.criticism.search.rivals import Rival, reach
from skin_ident.criticism.search.several import single_before_several
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.survey import Survey
from skin_ident.criticism.search.tared import beside_zeros, settle_zeros, take_tare, take_zeros
from skin_ident.criticism.search.together import take_pair, two_at_once
from skin_ident.criticism.search.trial import Trial
from skin_ident.criticism.search.unstuck import unstuck
from skin_ident.criticism.search.wandering import take_wave
from skin_ident.criticism.search.weighing import hang, hung_mass, may_wait, other_mass, unveils, weigh, weighs
from skin_ident.criticism.search.zero_of_play import is_zero_of_play

GOOD_PART = 0.25  # share of what refused causes explain, from which skin parameters go before two causes that hide each other
PASSES = 40  # rounds at most; some name nothing and only mend the baseline, and searches settle long before


def run(search: Search, fitted: Fit) -> None:
    """Name one cause after the other, beginning with the fitted baseline, until held-out data support no more."""
    search.present = fitted
    for _ in range(PASSES):
        if len(search.rounds) >= search.most or not _round(search):
            return


@dataclass(frozen=True)
class _Look:
    """What a look at the residual has shown.

    `survey` ranks all causes; `trials` are those that were fitted and `runs` the courses of sessions, each with the best first. `best` is
    the highest score of both, and `of_skin` that of skin parameters of each session's own. `mass` is a fit with another mass, to be taken
    where no cause is found.
    """

    survey: Survey
    trials: list[Trial]
    runs: list[Run]
    best: float
    of_skin: float
    mass: Fit | None


def _round(search: Search) -> bool:
    """Take what explains most of the present model's residual, if it is believed; return whether to look again."""
    search.begin_round()
    settle_skin(search)
    last = search.look()
    if settle_zeros(search) or settle_lateness(search, last) or take_other_specimen(search):
        return True
    trials, runs = single_before_several(search, search.trials(last)), search.own_courses()
    of_trials = max((t.score for t in trials), default=0.0)
    best = max([0.0, of_trials, *(r.score for r in runs)])
    hung = hung_mass(search, best)
    if hung:
        hang(search, hung)
        return True
    mass = other_mass(search)
    if mass and (weighs(search, mass, best) or unveils(search, mass, trials, best)):
        weigh(search, mass)
        return True
    of_skin = explained_by_own_skin(search, best)
    look = _Look(last, trials, runs, best, of_skin, mass if mass and may_wait(search, mass) else None)
    if take_partly(search, last, best, of_skin, runs) or take_where_held(search, last, max(best, of_skin), trials, runs):
        return True
    if of_skin > best and take_zeros(search, of_skin):  # a zero is one number per session, a skin four: the simpler account goes first
        return True
    if take_own_skin(search, of_skin, of_trials, runs):
        return True
    return _take_believed(search, look) or _believing_none(search, look)


def _take_believed(search: Search, look: _Look) -> bool:
    """Take the cause that is believed, a shared one or a course; or, in its place, zeros that explain as much, or the better minimum to
    which it led. Return whether any cause was believed."""
    own, shared = choose(search, look.trials, look.runs)
    if own and not take_tare(search, own[1]):
        search.end_round(look.survey, own[1].cause)
        take_course(search, *own)
    elif shared and not (take_tare(search, shared[1]) or unstuck(search, *shared) or is_zero_of_play(search, shared[1])):
        search.end_round(look.survey, shared[1].cause)
        after, finding = shared
        search.accept(after, _beside_dropped(search, look.survey, beside_zeros(search, finding)))
    return bool(own or shared)


def _believing_none(search: Search, look: _Look) -> bool:
    """Where no cause is believed, take what else may be there, the simplest first. Return whether to look again.

    - zeros as tares leave them, unless a cause is kept from being named by hardware, or by doubt and explains more, or skin parameters of
      each session's own explain more;
    - skin parameters of each session's own, in all sessions or in held-out ones;
    - what else is wrong in held-out sessions alone;
    - another mass, if nothing has been named;
    - skin parameters of each session's own, though causes that were refused explain more, if they explain a good part of that;
    - two causes that hide each other, if nothing has been named and hardware does as much as none of the best trials;
    - a wave;
    - skin parameters of each session's own, though causes that were refused explain far more.
    """
    scores = [*((t.key, t.score) for t in look.trials), *((r.course.key, r.score) for r in look.runs)]
    doubted = max((score for key, score in scores if key in search.doubts), default=0.0)
    if not search.hardware and take_zeros(search, max(reach(doubted), look.of_skin)):
        search.doubts = {}
        return True
    if take_own_skin(search, look.of_skin, look.best, look.runs, refused=True) or take_own_skin_of_held(search, look.of_skin, look.runs):
        return True
    if take_alone(search):
        search.end_round(look.survey, search.named[-1].cause)
        return True
    if look.mass and not search.named:
        weigh(search, look.mass)
        return True
    if look.of_skin > GOOD_PART * look.best and take_own_skin_at_last(search, look.of_skin, look.runs):
        return True
    by_hardware = any(t.key in search.hardware and t.score > reach(look.best) for t in look.trials)
    pair = None if search.named or search.stage or by_hardware else two_at_once(search, look.trials, look.runs)
    if pair:
        search.end_round(look.survey, pair.findings[0].cause)
        take_pair(search, pair)
        return True
    if take_wave(search):
        search.end_round(look.survey, search.named[-1].cause)
        return True
    if take_own_skin_at_last(search, look.of_skin, look.runs):
        return True
    search.end_round(look.survey, None, refused=max((t.score for t in look.trials), default=0.0))
    return False


def _beside_dropped(search: Search, last: Survey, finding: Named) -> Named:
    """The finding, with causes among its alternatives that were taken out again but would explain as much of the residual in the survey
    `last`."""
    score = {p.key: p.score for p in last.ranked}
    mine = score.get(finding.key, 0.0)
    return finding.with_rivals(Rival(*key, mine - score[key]) for key in sorted(search.dropped) if score.get(key, 0.0) > reach(mine))


def eliminate(search: Search) -> bool:
    """Take out causes, last found first, without which the rest predicts as well, and instances of those that are kept which explain
    nothing any more; return whether causes were taken out. The last one was tested just before if nothing came after it, and is then not
    tested again."""
    named = search.named
    asked = named[:-1] if named and search.is_new(named[-1]) else named
    for finding in reversed([n for n in asked if not (n.courses or n.only)]):
        without = fit(search.present.model.lacking(finding.key), search.train, search.noise)
        gain = search.gain(without.model, search.present.model, finding.where)
        if not (gain.passed or search.second_opinion(without.model, search.present.model, finding.where, gain).passed):
            search.present, search.named = without, [n for n in search.named if n is not finding]
            search.dropped.add(finding.key)
            search.befores.pop(finding.key, None)
    for finding in search.named:
        search.present = spared(search.present, finding.key, search.train, search.noise)
    return search.named != named
