"""Which of the ranked causes are refitted with everything else before one is chosen."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice

from skin_ident.criticism.search.by_nature import likelier_place
from skin_ident.criticism.search.ranking import Ranked
from skin_ident.criticism.search.rivals import reach
from skin_ident.criticism.search.trial import Trial
from skin_ident.criticism.vocabulary import CAUSES, LAG_OF_TAXELS, LATE_TAXELS, Key

SHORTLIST, LONGEST = 4, 7  # causes that are refitted before one is chosen; and the same with those that physics rules out
LARGE = 9.0  # times all noise, from which LONGEST are refitted: small amounts, by which causes are ranked, say little of what large ones do
TIED = 4.0  # twice nats: a likelihood ratio of seven
ORDER = {cause.name: i for i, cause in enumerate(CAUSES)}
TWINS = {LATE_TAXELS: LAG_OF_TAXELS}  # what differs only in the fit: of a short time, damping takes up nearly all
WITHIN = 0.35  # share of the best score, below which no refit makes up for the difference


def shortlisted(
    ranked: Sequence[Ranked],
    tried: Callable[[Iterable[Ranked]], Iterator[Trial]],
    known: set[Key],
    suspected: set[Key],
    count: int,
) -> list[Trial]:
    """The most promising causes as trials, the best first, and of equals the commoner. `tried` fits them and leaves out what physics rules
    out.

    - More causes are tried where the best explains many times the noise of the `count` whitened samples.
    - A cause that is `known` already is tried wherever it ranks, and goes before rivals that it equals.
    - A likelier place of the same cause goes before another.
    - A cause that is `suspected`, because the record itself has shown it, goes first if it reaches `WITHIN` of the best score.
    """
    shown = [r for r in ranked if r.key in suspected - known and r.score > 0.0]
    others = [r for r in ranked if r.score > 0.0 and r not in shown]
    most = LONGEST if ranked and ranked[0].score > LARGE * count else SHORTLIST
    trials = [*tried(shown), *_best(others, tried, known, most)]
    enough = WITHIN * max((t.score for t in trials), default=0.0)
    trials.sort(key=lambda t: (t.ranked not in shown or t.score < enough, -t.score))
    trials = trials if trials and trials[0].ranked in shown else _commoner_first(trials)
    again = [t for t in trials if t.key in known and t.score > reach(trials[0].score)]
    first = again[:1] or likelier_place(trials)
    return first + [t for t in trials if t not in first]


def _commoner_first(trials: list[Trial]) -> list[Trial]:
    """The trials; of those that explain practically as much as the best, the one that comes first in the vocabulary goes first: skins are
    nonlinear more often than joints are loose."""
    tied = [t for t in trials if t.score > trials[0].score - TIED]
    first = min(tied, key=lambda t: ORDER.get(t.key[0], len(ORDER)), default=None)
    return trials if first is None else [first, *(t for t in trials if t is not first)]


def _best(ranked: Sequence[Ranked], tried: Callable[[Iterable[Ranked]], Iterator[Trial]], known: set[Key], most: int) -> list[Trial]:
    """Trials of the best few causes, at most `most`, and of those near them that are known. Causes that physics rules out are no measure
    for the others: where the best is ruled out, those near the next best are tried; where all are, those that rank next. The twin of the
    best is tried wherever it ranks."""
    twin = TWINS.get(ranked[0].key) if ranked else None
    near = [r for r in ranked if r.score > WITHIN * ranked[0].score or r.key == twin]
    queue, keys = iter(near[:LONGEST]), {r.key for r in near}
    after = [r for r in ranked if r.key not in keys]
    trials = list(islice(tried(queue), most))
    trials += tried([r for r in (*queue, *near[LONGEST:]) if r.key in known or r.key == twin])
    if not trials:
        return _best(after, tried, known, most) if after else []
    best = max(t.ranked.score for t in trials)
    if best < ranked[0].score:
        trials += islice(tried(r for r in after[:LONGEST] if r.score > WITHIN * best), max(most - len(trials), 0))
    return trials
