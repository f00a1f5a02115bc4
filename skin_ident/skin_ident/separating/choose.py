"""The motion that decides between rivals in the least time, with its numbers."""

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
from skin_ident.separating.candidates import Candidate
from skin_ident.separating.contest import Contender, Contest, contest, rehearsed
from skin_ident.separating.unrecorded import unrecorded

FLOOR = 100.0  # squared whitened units, ten times the criticism's: causes that nobody thinks of now must not stand between the two
SHORTEST = 20.0  # s: held-out data are judged by blocks of 2 s, and a few of them say nothing
MARGIN = 1.5  # times the criticism's own bound: real skins are not quite of the forms that were fitted
PATIENCE = 75.0  # s of recording, for an experiment that is not sure to decide
TELLS_NOTHING = 1.0  # expected log likelihood ratio: names for one and the same signal are not worth an experiment
HELPS = 0.1  # of what is missing to `MARGIN`, which an experiment that does not decide must bring
MOST_RUNS = 3
PERIOD = 0.01  # s, at which candidates are simulated


@dataclass(frozen=True)
class Experiment:
    """A battery to record, and why: the expected log likelihood ratio it adds, beside that of what was recorded.

    Both are of the pair, among those expected to be told apart, for which it adds least. `together` are pairs of rivals that are expected
    to stay together even so, `hopeless` whether every other motion that was tried leaves them so, too, and `known` those pairs that what
    was recorded tells apart; `rivals` are the names it was chosen for, the named cause first, and `unasked` the others. Where even the
    best motion is of no help there is no `name` and no `text`. `apart` says whether the rivals are in skin and rig.
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

    @property
    def helps(self) -> bool:
        """Whether there is anything to record."""
        return bool(self.name)

    @property
    def decides(self) -> bool:
        """Whether one name is then expected to be left."""
        return not self.together

    def sentence(self, file: str) -> str:
        """What findings.json says of it, where `file` is the battery's name."""
        if not self.helps:
            other = "; press another skin with the same rig and sensors: what is in these stays, and what is in the skin goes with it"
            none = "no motion that was tried in simulation tells them apart clearly better than what was recorded"
            return none + (other if self.apart else "")
        rest = f"; it says nothing of {' or '.join(self.unasked)}" if self.unasked else ""
        return f"record {file} ({self.name}; {self.seconds:.0f} s): it {self._does}{rest}"

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
            return f"would clearly tell {_from(told, 'and')}; {most} {_from(self.together, 'or')}"
        left = " and ".join(" with ".join(pair) for pair in self.together)
        return f"does most to tell {every}, though it may leave {left}"

    @property
    def numbers(self) -> dict[str, float]:
        """The same for programs: expected log likelihood ratios."""
        return {"expected": self.evidence, "recorded": self.recorded}


@dataclass(frozen=True)
class _Option:
    """Candidates to be recorded in one session, and what they add. Sums are lower bounds: one joint refit can imitate less than several."""

    parts: tuple[Candidate, ...]
    new: Contest

    @property
    def seconds(self) -> float:
        """How long the session lasts."""
        return sum(p.seconds for p in self.parts)

    def and_then(self, other: "_Option") -> "_Option":
        """Both in one session."""
        return _Option((*self.parts, *other.parts), self.new + other.new)

    @property
    def name(self) -> str:
        """Of the session: its candidates, those that come again counted."""
        counted = Counter(p.name for p in self.parts)
        return " and ".join(name if n == 1 else f"{name}, {n} times" for name, n in counted.items())


def separating_experiment(
    named: Named,
    train: list[Session],
    noise: Whitener,
    which: tuple[Direction, ...],
    progress: Callable[[str], None] = lambda stage: None,
) -> Experiment | None:
    """The best motion for the rivals of one finding on the sessions `train`; `which` are all directions that were ranked. None where there
    is no rival, or no depth to command."""
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
    """The best experiment for every finding that has rivals, by its cause and place, with the name of the file it goes to; no file where
    it is of no help. Judged on the samples that the criticism compares: in those that it leaves out rivals may differ as much as they
    will, and are not told apart."""
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
    """What was recorded, saying no more than the criticism took from it: by so little it explains more with the named cause, and it kept
    the rival. What the contest sees beyond that is in forms that are free in a criticism and were held here."""
    short = [a.short_by for a in named.alternatives if a.model is not None]
    share = np.clip(np.array(short) / max(named.explained, 1e-300), 0.0, REACH)
    distance = known.distance.copy()
    distance[0, 1:] = np.minimum(distance[0, 1:], share * known.explained[0])
    distance[1:, 0] = np.minimum(distance[1:, 0], share * known.explained[1:])
    return replace(known, distance=distance)


def _options(singles: list[_Option]) -> Iterator[_Option]:
    """Every candidate once or several times, and every pair."""
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
    """How many pairs it leaves together, then its seconds; where it tells none apart, how near it comes within `PATIENCE`."""
    together = _together(known, o)
    if together.sum() < together.size:
        return int(together.sum()), o.seconds
    return together.size, -float((known + o.new).margin(FLOOR, REACH).min()) * (o.seconds <= PATIENCE)


def _together(known: Contest, o: _Option) -> np.ndarray:
    """For every pair of rivals, in the order of `_pairs`, whether it is expected to stay together."""
    return (known + o.new).margin(FLOOR, REACH)[_pairs(known)] < MARGIN


def _hopeless(known: Contest, best: _Option, options: list[_Option]) -> bool:
    """Whether no option tells any pair apart that the best leaves together."""
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
    said = (best.name, _text(best), best.seconds) if _helps(known, best) else ("", "", 0.0)
    apart = "skin" in places and len(places) > 1
    return Experiment(*said, float(added[worst]), float(recorded[worst]), words, left, apart=apart, known=told)


def _helps(known: Contest, o: _Option) -> bool:
    """Whether it tells a pair apart that what was recorded does not, or brings one clearly nearer to that."""
    before, after = (c.margin(FLOOR, REACH)[_pairs(known)] for c in (known, known + o.new))
    return bool(np.any((before < MARGIN) & (after - before > HELPS * (MARGIN - before))))


def _text(o: _Option) -> str:
    """The battery that does all parts of an option, as YAML."""
    about = {"type": "battery", "name": "separating", "about": o.name}
    return yaml.safe_dump({**about, "profiles": [yaml.safe_load(p.text) for p in o.parts]}, sort_keys=False, width=140)


def _words(rivals: tuple[Contender, ...]) -> tuple[str, ...]:
    """What to call the rivals: by place too where one cause is its own rival."""
    twice = len({r.cause for r in rivals}) < len(rivals)
    return tuple(cause_at(r.cause, r.where) if twice else spoken(r.cause) for r in rivals)


def _from(pairs: Sequence[tuple[str, str]], word: str) -> str:
    """Pairs as they are told apart: by the name that all of them share, where there is one."""
    shared = set.intersection(*map(set, pairs))
    if len(pairs) == 1 or not shared:
        return f", {word} ".join(" from ".join(pair) for pair in pairs)
    (one,) = shared
    others = [a if b == one else b for a, b in pairs]
    return f"{one} from {', '.join(others[:-1])} {word} {others[-1]}"
