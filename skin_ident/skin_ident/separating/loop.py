"""The closed loop: record, criticise, record what would separate the rivals that are left, and so on until one name is left.

Every experiment is recorded twice, once to fit and once to be predicted, by another draw of what is random in its motion; everything
recorded so far is criticised together.
"""

from collections.abc import Callable
from dataclasses import dataclass

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.telling.outcome import Outcome
from skin_ident.recordings.recording import Recording
from skin_ident.separating.candidates import random_motion, redrawn

Record = Callable[[str, str], Recording]  # words or YAML of a battery, and a name for the session
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Step:
    """One experiment and the criticism of everything up to it: `left` are the names of every finding, the first being the one chosen."""

    battery: str
    seconds: float
    left: tuple[tuple[str, ...], ...]
    verdict: str

    @property
    def unnamed(self) -> bool:
        """Whether nothing has a name, or something that is left has none."""
        return not self.left or self.verdict == "partly_explained"

    @property
    def words(self) -> str:
        """What is left, as a person says it."""
        unnamed = "something without a name" if self.verdict == "unexplained" else "nothing"
        return "; ".join(" or ".join(names) for names in self.left) or unnamed


@dataclass(frozen=True)
class Course:
    """All steps, the last outcome, and every recording."""

    steps: tuple[Step, ...]
    outcome: Outcome
    recordings: tuple[Recording, ...]

    @property
    def seconds(self) -> float:
        """Length of everything recorded."""
        return sum(s.seconds for s in self.steps)


def until_named(record: Record, first: str, rich: str, budget: float, progress: Progress = lambda stage: None) -> Course:
    """Begin with the battery `first` and go on until one name is left, `budget` (s of recording) is spent, or nothing would help.

    A name that was not among those left before is none yet: in a poor battery its rivals, and whatever else is wrong, may not show. It is
    held against random motion first, as the thesis validates what it fitted to sines (section 4.3.2). Where something has no name the
    battery may have been too poor to show one: then the battery `rich` is next, once.
    """
    train, held, steps, battery = [], [], [], first
    while battery:
        progress(f"experiment {len(steps) + 1}: recording twice")
        train.append(record(battery, f"experiment_{len(steps) + 1}"))
        held.append(record(redrawn(battery), f"experiment_{len(steps) + 1}_again"))
        outcome = diagnose(train, held, None, progress)
        steps.append(
            Step(battery, sum(float(r.t[-1] - r.t[0]) for r in (train[-1], held[-1])), _left(outcome), outcome.findings["verdict"])
        )
        progress(f"left: {steps[-1].words}")
        spent = sum(s.seconds for s in steps) >= budget
        battery = "" if spent else _next(steps, outcome, rich, float(train[0].depth.max()))
    return Course(tuple(steps), outcome, (*train, *held))


def _next(steps: list[Step], outcome: Outcome, rich: str, deepest: float) -> str:
    """What to record next, no deeper than `deepest` (m): what separates rivals, what may show what has no name yet, what a new name is held
    against; empty where there is nothing to ask any more."""
    done = [s.battery for s in steps]
    before = {name for names in steps[-2].left for name in names} if len(steps) > 1 else set()
    new = any(before.isdisjoint(names) for names in steps[-1].left)
    wanted = [*outcome.batteries.values()]
    wanted += [rich] if steps[-1].unnamed else [random_motion(deepest)] if new and rich not in done else []
    return next((battery for battery in wanted if battery not in done), "")


def _left(outcome: Outcome) -> tuple[tuple[str, ...], ...]:
    findings = outcome.findings["findings"]
    return tuple((_name(f), *(_name(a) for a in f["alternatives"])) for f in findings)


def _name(entry: dict) -> str:
    return f"{entry['cause']} in the {entry['where']}"
