"""Two causes that hide each other: a worn nut that takes load away where a stiffening skin adds it.

Neither predicts held-out data alone, because the fit bends it to stand for the other as well. So where no single cause is believed, each of
the best is taken for granted in turn, and the search looks one step further: is a second cause believed beside it, or a course that each
session has of its own, and is the first one then believed beside the second?
"""

from dataclasses import dataclass, replace

from skin_ident.criticism.baseline.fitting import Fit, fit
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.gates.claim import Claim
from skin_ident.criticism.gates.gate import MATERIAL_FALL, MUCH_FALL, Gain
from skin_ident.criticism.gates.resolution import resolved
from skin_ident.criticism.search.believing import first_believed
from skin_ident.criticism.search.choosing import choose
from skin_ident.criticism.search.hardware import encoder_does
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.own import take_course
from skin_ident.criticism.search.rivals import Rival, reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.trial import Trial, sized
from skin_ident.criticism.vocabulary import Key
from skin_models.model import Model

FILTERS = ("time_shift", "lag", "mount_compliance", "rate_dependence")  # causes of which two together smooth the steps of the depth
ASKED = 3  # causes that are taken for granted in turn


@dataclass(frozen=True)
class Pair:
    """Two findings: the `first` with its fit alone, the `second` with its fit beside the first, or as a course. `explained` is the score of
    both together over the present model, in the noise of the present search: each looks ahead in noise of its own."""

    first: tuple[Fit, Named]
    second: tuple[Fit | Run, Named]
    explained: float

    @property
    def findings(self) -> tuple[Named, Named]:
        """Both findings."""
        return self.first[1], self.second[1]


def two_at_once(search: Search, trials: list[Trial], runs: list[Run]) -> Pair | None:
    """The two findings that explain most together; `search` is the state of `criticise`. None where the record is short, where courses
    explain more than the causes, or where no two causes are believed beside each other."""
    promising = [t.forms[-1] for t in trials[:ASKED] if t.score > MATERIAL_FALL * t.fit.count and sized(t.forms[-1])]
    if not promising or not search.lasts or (runs and runs[0].score > promising[0].score):
        return None
    pairs = sorted(filter(None, (_beside(search, t) for t in promising)), key=lambda pair: -pair.explained)
    if not pairs:
        return None
    best, *others = pairs
    first, second = best.findings
    near = [p for p in others if p.findings[1].cause == second.cause and p.explained > reach(best.explained)]
    rivals = tuple(Rival(*p.findings[0].key, best.explained - p.explained) for p in near)
    return replace(best, first=(best.first[0], replace(first, alternatives=rivals)))


def _no_steps(search: Search, after: Model, both: Gain, keys: tuple[Key, Key]) -> bool:
    """Whether two causes gain more than the steps of an encoder may account for, and much more where one of them may smooth these steps."""
    steps = search.encoder_step
    much = both.relative > MUCH_FALL or not (steps and any(cause in FILTERS for cause, _ in keys))
    return much and all(resolved(search.claim(key, both, after), search.noise, steps, strict=True) for key in keys)


def take_pair(search: Search, pair: Pair) -> None:
    """Name both."""
    for found, finding in (pair.first, pair.second):
        if isinstance(found, Run):
            take_course(search, found, finding)
        else:
            search.accept(found, finding)


def _beside(search: Search, first: Trial) -> Pair | None:
    """`first` and the course or cause that is believed beside it, if `first` is believed beside that one."""
    ahead = search.ahead(first.fit)
    trials, runs = ahead.trials(ahead.look()), ahead.own_courses()
    own, shared = choose(ahead, trials, runs)
    pair = _with_course(search, ahead, first, *own) if own else None
    return pair or _with_cause(search, ahead, first, shared or first_believed(ahead, trials, []))


def _with_course(search: Search, ahead: Search, first: Trial, run: Run, finding: Named) -> Pair | None:
    if not _may_hide(first.key, finding.key):
        return None
    beside_it = ahead.ahead(first.fit)
    take_course(beside_it, run, finding)
    both = beside_it.present.under(search.noise, beside_it.train)
    return _with(beside_it, first, both.model, (run, finding), both.score_over(search.present) - run.charge)


def _with_cause(search: Search, ahead: Search, first: Trial, second: tuple[Fit, Named] | None) -> Pair | None:
    """Both, if they are believed together, too."""
    if second is None or not _may_hide(first.key, second[1].key):
        return None
    both = second[0].under(search.noise, search.train)
    gain = search.gain(search.present.model, both.model, "skin")
    told = gain.passed and _no_steps(search, both.model, gain, (first.key, second[1].key))
    return _with(ahead, first, both.model, second, both.score_over(search.present)) if told else None


def _may_hide(one: Key, other: Key) -> bool:
    """Whether two causes may be taken for granted beside each other: not if together they do no more than smooth the steps of the depth."""
    return one != other and not all(cause in FILTERS for cause, _ in (one, other))


def _with(ahead: Search, first: Trial, after: Model, second: tuple[Fit | Run, Named], explained: float) -> Pair | None:
    """Both, if `first` is believed beside the `second`, in the model `after`."""
    without, gain = beside(ahead, first.key, after)
    return Pair((first.fit, Named(*first.key, gain, first.score, (), without, after)), second, explained) if gain else None


def beside(ahead: Search, key: Key, after: Model) -> tuple[Model, Gain | None]:
    """The model `after` refitted without one cause and place `key`, and what that cause gains beside the rest; None where it is not
    believed."""
    without = fit(after.lacking(key), ahead.train, ahead.noise).model
    gain = ahead.gain(without, after, key[1])
    told = gain.passed and gain.shows_at(key[1])
    encoder = encoder_does(Claim(key, gain, without, after, ahead.train), ahead.noise, ahead.encoder_step) if told else None
    return without, gain if told and encoder is None else None
