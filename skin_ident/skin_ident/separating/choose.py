"""The motion that decides between rivals in the least time, with its numbers."""

from collections.abc import Callable
from dataclasses import dataclass

from skin_ident.criticism.criticise import REACH, Criticism, Named
from skin_ident.criticism.proposals import directions
from skin_ident.criticism.session import Session
from skin_ident.separating.candidates import Candidate, candidates
from skin_ident.separating.contest import Contender, Contest, contest, rehearsed

FLOOR = 10.0  # squared whitened units within which two causes are rivals whatever they explain
MARGIN = 2.0  # times the criticism's own bound: real skins are not quite of the forms that were fitted
MOST_RUNS = 4
PERIOD = 0.01  # s, at which candidates are simulated


@dataclass(frozen=True)
class Experiment:
    """A battery to record `runs` times, and why: the expected log likelihood ratio of one run beside that of what was recorded.

    `decides` says whether one name is then expected to be left; `rivals` are the causes, the named one first.
    """

    name: str
    text: str
    seconds: float
    runs: int
    evidence: float
    recorded: float
    decides: bool
    rivals: tuple[str, ...]

    @property
    def sentence(self) -> str:
        """What findings.json says of it."""
        times = "once" if self.runs == 1 else f"{self.runs} times"
        hope = "" if self.decides else "; even that may leave more than one name"
        return (
            f"to tell {' from '.join(self.rivals)}, record {self.name} {times} ({self.seconds:.0f} s each): "
            f"expected evidence {self.evidence:.3g} a run, against {self.recorded:.2g} for what was recorded{hope}"
        )


def separating_experiment(
    c: Criticism, named: Named, train: list[Session], progress: Callable[[str], None] = lambda stage: None
) -> Experiment | None:
    """The best candidate for the rivals of one finding. None where there is no rival, or no depth that could be commanded."""
    rivals = contenders(named)
    if len(rivals) < 2 or train[0].drive is not None:
        return None
    progress("looking for the experiment that separates " + " from ".join(r.cause for r in rivals))
    which = directions(train[0])
    known = contest(rivals, train, c.last.noise, which)
    deepest = max(float(s.motion.x.max()) for s in train)
    tried = candidates(deepest, max(PERIOD, train[0].band.dt))
    contests = [contest(rivals, [rehearsed(k.motion, train[0], rivals[0].model)], c.last.noise, which) for k in tried]
    candidate, new, runs = min(((k, t, _runs(known, t)) for k, t in zip(tried, contests, strict=True)), key=lambda o: _cost(known, *o))
    decides = _margin(known, new, runs) >= MARGIN
    words = tuple(dict.fromkeys(f"{r.cause} in the {r.where}" if _alike(rivals) else r.cause for r in rivals))
    return Experiment(candidate.name, candidate.text, candidate.seconds, runs, new.evidence, known.evidence, decides, words)


def contenders(named: Named) -> tuple[Contender, ...]:
    """The named cause and its rivals, each with the model fitted with it."""
    every = [c for c in (named, *named.alternatives) if c.model is not None]
    return tuple(Contender(c.cause, c.where, c.model) for c in every)


def _alike(rivals: tuple[Contender, ...]) -> bool:
    return len({r.cause for r in rivals}) < len(rivals)


def _margin(known: Contest, new: Contest, runs: int) -> float:
    return (known + runs * new).margin(FLOOR, REACH)


def _runs(known: Contest, new: Contest) -> int:
    """How often the motion must be recorded to decide; `MOST_RUNS` where that is not enough."""
    return next((n for n in range(1, MOST_RUNS + 1) if _margin(known, new, n) >= MARGIN), MOST_RUNS)


def _cost(known: Contest, candidate: Candidate, new: Contest, runs: int) -> tuple[float, float]:
    """Seconds until it decides; of those that do not, the evidence per second counts."""
    if _margin(known, new, runs) >= MARGIN:
        return runs * candidate.seconds, -new.evidence
    return float("inf"), -new.evidence / candidate.seconds
