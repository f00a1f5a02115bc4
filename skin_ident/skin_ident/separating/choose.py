"""Chooses the motion that decides between rivals in the least time, and says how much it is expected to tell."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, count

import numpy as np
import yaml

from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.search.named import Criticism, Named
from skin_ident.criticism.search.proposals import Direction
from skin_ident.criticism.search.rivals import REACH
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import cause_at, spoken
from skin_ident.separating.by_hand import shown_by_hand
from skin_ident.separating.candidates import AIR, Candidate
from skin_ident.separating.contest import Contender, Contest, contest, rehearsed
from skin_ident.separating.path import lasts
from skin_ident.separating.unrecorded import unrecorded

FLOOR = 100.0  # squared whitened units (ten times the criticism's): the distance of two rivals must exceed what other causes could make
SHORTEST = 20.0  # s, shortest session: held-out data are resampled in blocks of 2 s, and a few blocks say nothing
MARGIN = 1.5  # times the criticism's own bound; more than 1 because real skins differ a little from the fitted forms
PATIENCE = 75.0  # s of recording, the most for an experiment that is not expected to tell any pair apart
TELLS_NOTHING = 1.0  # expected log-likelihood ratio below which no experiment is proposed: the names stand for one and the same signal
HELPS = 0.1  # an experiment helps if it closes this share of the gap to MARGIN
MOST_RUNS = 3  # times that a candidate may be repeated in one session
PERIOD = 0.01  # s, sampling period of simulated candidates


@dataclass(frozen=True)
class Experiment:
    """A battery to record, and how much it is expected to tell.

    `evidence` and `recorded` are expected log-likelihood ratios: of the new recording, and of what was recorded before. Both are for one
    pair of rivals: of the pairs expected to be told apart (of all, if there are none), the one to which the experiment adds least.

    -   `rivals` are the names it was chosen for, the named cause first; `unasked` are alternatives without a model, which it cannot test.
    -   `together` are pairs of rivals that are not expected to be told apart even then; `hopeless` says that no other motion that was tried
        tells any of these pairs apart; `known` are the pairs that the existing recordings tell apart.
    -   `apart` says that one rival is in the skin and another is not.
    -   `by_hand` are tests that tell pairs in `together` apart and are more than a motion (see `shown_by_hand`).

    `name` and `text` are empty where even the best motion is of no help.
    """

    name: str
    text: str
    seconds: float
    evidence: float
    recorded: float
    rivals: tuple[str, ...]
    together: tuple[tuple[str, str], ...]
    unasked: tuple[str, ...] = ()
    apart: bool = False
    hopeless: bool = False
    known: tuple[tuple[str, str], ...] = ()
    by_hand: tuple[str, ...] = ()

    @property
    def helps(self) -> bool:
        """Whether there is anything to record."""
        return bool(self.name)

    @property
    def decides(self) -> bool:
        """Whether the experiment is expected to leave a single name."""
        return not self.together

    def sentence(self, file: str) -> str:
        """The sentence about the experiment in findings.json; `file` is the battery's file name."""
        if not self.helps:
            other = "; press another skin with the same rig and sensors: what is in these stays, and what is in the skin goes with it"
            none = "no motion that was tried in simulation tells them apart clearly better than what was recorded"
            return none + self._tests + (other if self.apart else "")
        rest = f"; it says nothing of {' or '.join(self.unasked)}" if self.unasked else ""
        return f"record {file} ({self.name}; {self.seconds:.0f} s): it {self._does}{rest}"

    @property
    def _tests(self) -> str:
        """What a person can do about rivals that no motion tells apart; empty where nothing is known."""
        return f"; what would tell them apart: {'; or '.join(self.by_hand)}" if self.by_hand else ""

    @property
    def _does(self) -> str:
        every = " from ".join(self.rivals)
        if len(self.rivals) > 2:
            every = f"{', '.join(self.rivals[:-1])} and {self.rivals[-1]} apart"
        if self.decides:
            return f"would clearly tell {every}, which what was recorded cannot"
        told = [pair for pair in combinations(self.rivals, 2) if pair not in (*self.together, *self.known)]
        if told:
            most = "no motion that was tried in simulation tells" if self.hopeless else "it may not tell"
            return f"would clearly tell {_from(told, 'and')}; {most} {_from(self.together, 'or')}{self._tests}"
        left = " and ".join(" with ".join(pair) for pair in self.together)
        return f"does most to tell {every}, though it may leave {left}{self._tests}"

    @property
    def numbers(self) -> dict[str, float]:
        """Expected log-likelihood ratios, for programs that read findings.json."""
        return {"expected": self.evidence, "recorded": self.recorded}


@dataclass(frozen=True)
class _Option:
    """Candidates to be recorded in one session, and the contest on them. The contests of several candidates are summed; this is a lower
    bound, because one fit to all of them can imitate less than a fit to each."""

    parts: tuple[Candidate, ...]
    new: Contest

    @property
    def seconds(self) -> float:
        """Duration of the session, s."""
        return sum(p.seconds for p in self.parts)

    def and_then(self, other: "_Option") -> "_Option":
        """The candidates of both options in one session."""
        return _Option((*self.parts, *other.parts), self.new + other.new)

    @property
    def name(self) -> str:
        """Name of the session: the names of its candidates, with the number of repetitions."""
        counted = Counter(p.name for p in self.parts)
        return " and ".join(name if n == 1 else f"{name}, {n} times" for name, n in counted.items())


def separating_experiment(
    named: Named,
    train: list[Session],
    noise: Whitener,
    which: tuple[Direction, ...],
    progress: Callable[[str], None] = lambda stage: None,
) -> Experiment | None:
    """The best experiment for the rivals of one finding on the sessions `train`; `which` are all directions that were ranked. None where
    there is no rival with a model, where force drives the test, so that no depth can be commanded, or where no candidate is usable."""
    rivals = contenders(named)
    if len(rivals) < 2 or train[0].drive is not None:
        return None
    unasked = tuple(dict.fromkeys(cause_at(a.cause, a.where) for a in named.alternatives if a.model is None))
    progress("looking for the motion that separates " + " from ".join(r.cause for r in rivals))

    def judged(sessions: list[Session]) -> Contest:
        return contest(rivals, named.before, sessions, noise, which)

    known = as_criticised(judged(train), named)
    deepest = max(float(s.motion.x.max()) for s in train)
    tried = unrecorded(deepest, max(PERIOD, train[0].band.dt), train)
    singles = [_Option((k,), judged([rehearsed(k.motion, train[0], rivals[0].model)])) for k in tried]
    options = list(filter(_usable, _options(singles)))
    best = min(options, key=lambda o: _cost(known, o), default=None)
    return best and replace(_experiment(rivals, known, best), unasked=unasked, hopeless=_hopeless(known, best, options))


def separating_experiments(
    c: Criticism, progress: Callable[[str], None] = lambda stage: None
) -> dict[tuple[str, str], tuple[str, Experiment]]:
    """The best experiment for every finding that has rivals, by cause and place, with the name of its file (empty where it does not help).

    Only samples that the criticism compares count. Rivals may differ in samples that it leaves out, but that does not tell them apart.
    """
    train = list(c.train)
    each = {n.key: separating_experiment(n, train, c.last.noise, c.last.projected.which, progress) for n in c.named}
    wanted = {key: e for key, e in each.items() if e is not None and e.evidence > TELLS_NOTHING}
    files = (f"separating{f'_{i}' if i > 1 else ''}.yaml" for i in count(1))
    return {key: (next(files) if e.helps else "", e) for key, e in wanted.items()}


def contenders(named: Named) -> tuple[Contender, ...]:
    """The named cause and its rivals, each with the model fitted with it."""
    every = [c for c in (named, *named.alternatives) if c.model is not None]
    return tuple(Contender(*c.key, c.model) for c in every)


def as_criticised(known: Contest, named: Named) -> Contest:
    """The contest on the existing recordings, with distances no larger than the criticism found them.

    The criticism kept a rival because it explains less than the named cause by only `short_by`. A larger distance comes from forms of the
    causes that are free in the criticism but fixed in the contest.
    """
    short = [a.short_by for a in named.alternatives if a.model is not None]
    share = np.clip(np.array(short) / max(named.explained, 1e-300), 0.0, REACH)
    distance = known.distance.copy()
    distance[0, 1:] = np.minimum(distance[0, 1:], share * known.explained[0])
    distance[1:, 0] = np.minimum(distance[1:, 0], share * known.explained[1:])
    return replace(known, distance=distance)


def _options(singles: list[_Option]) -> Iterator[_Option]:
    """Every candidate, repeated up to MOST_RUNS times, and every pair of candidates."""
    for o in singles:
        repeated = o
        for _ in range(MOST_RUNS):
            yield repeated
            repeated = repeated.and_then(o)
    for a, b in combinations(singles, 2):
        yield a.and_then(b)


def _usable(o: _Option) -> bool:
    return o.seconds >= SHORTEST and any(p.rich for p in o.parts)


def _cost(known: Contest, o: _Option) -> tuple[int, float]:
    """Sort key of an option, the smallest being the best: the number of pairs that it leaves together, then its duration. Where it tells no
    pair apart, the second entry is minus the smallest margin of a pair, or 0 for options longer than PATIENCE."""
    together = _together(known, o)
    if together.sum() < together.size:
        return int(together.sum()), o.seconds
    return together.size, -float((known + o.new).margin(FLOOR, REACH).min()) * (o.seconds <= PATIENCE)


def _together(known: Contest, o: _Option) -> np.ndarray:
    """For every pair of rivals, in the order of `_pairs`, whether it is expected not to be told apart."""
    return (known + o.new).margin(FLOOR, REACH)[_pairs(known)] < MARGIN


def _hopeless(known: Contest, best: _Option, options: list[_Option]) -> bool:
    """Whether every pair that the best option leaves together is left together by all other options, too."""
    left = _together(known, best)
    return all(bool(np.all(_together(known, o)[left])) for o in options)


def _pairs(of: Contest) -> tuple[np.ndarray, np.ndarray]:
    return np.triu_indices(of.explained.size, 1)


def _experiment(rivals: tuple[Contender, ...], known: Contest, best: _Option) -> Experiment:
    together, pairs = _together(known, best), _pairs(known)
    before = known.margin(FLOOR, REACH)[pairs] >= MARGIN
    added, recorded = best.new.evidence[pairs], known.evidence[pairs]
    worst = int(np.argmin(np.where(together & ~together.all(), np.inf, added)))
    words, places = _words(rivals), {r.where for r in rivals}
    left, told = (tuple((words[i], words[j]) for i, j, t in zip(*pairs, which, strict=True) if t) for which in (together, before))
    said = (best.name, _text(best), lasts(_text(best))) if _helps(known, best) else ("", "", 0.0)
    apart = "skin" in places and len(places) > 1
    by_hand = shown_by_hand(rivals[k].cause for i, j, t in zip(*pairs, together, strict=True) if t for k in (i, j))
    return Experiment(*said, float(added[worst]), float(recorded[worst]), words, left, apart=apart, known=told, by_hand=by_hand)


def _helps(known: Contest, o: _Option) -> bool:
    """Whether an option brings some pair that the existing recordings do not tell apart at least the share HELPS nearer to MARGIN."""
    before, after = (c.margin(FLOOR, REACH)[_pairs(known)] for c in (known, known + o.new))
    return bool(np.any((before < MARGIN) & (after - before > HELPS * (MARGIN - before))))


def _text(o: _Option) -> str:
    """The battery of all candidates of an option, as YAML; one wait in the air between two of them."""
    profiles: list[dict] = []
    for content in (yaml.safe_load(p.text) for p in o.parts):
        parts = [content] if content.get("name") else content["profiles"]
        profiles += parts[1:] if profiles and parts[0]["type"] == profiles[-1]["type"] == AIR["type"] else parts
    about = {"type": "battery", "name": "separating", "about": o.name}
    return yaml.safe_dump({**about, "profiles": profiles}, sort_keys=False, width=140)


def _words(rivals: tuple[Contender, ...]) -> tuple[str, ...]:
    """The names of the rivals, with their places where one cause occurs at two places."""
    twice = len({r.cause for r in rivals}) < len(rivals)
    return tuple(cause_at(r.cause, r.where) if twice else spoken(r.cause) for r in rivals)


def _from(pairs: Sequence[tuple[str, str]], word: str) -> str:
    """Pairs in words: "a from b", joined by `word`; where all pairs share one name, "name from b, c `word` d"."""
    shared = set.intersection(*map(set, pairs))
    if len(pairs) == 1 or not shared:
        return f", {word} ".join(" from ".join(pair) for pair in pairs)
    (one,) = shared
    others = [a if b == one else b for a, b in pairs]
    return f"{one} from {', '.join(others[:-1])} {word} {others[-1]}"
