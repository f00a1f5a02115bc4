"""The closed loop: record, criticise, record what would separate the rivals that are left, and so on until one name is left.

Every experiment is recorded twice, to fit and to hold out; the second time with other seeds of its random motions. Everything recorded so
far is criticised together.
"""

from collections.abc import Callable
from dataclasses import dataclass

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.telling.outcome import Outcome
from skin_ident.recordings.recording import Recording
from skin_ident.separating.candidates import random_motion, redrawn

Record = Callable[[str, str], Recording]  # from the name or YAML of a battery, and a name for the session
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Step:
    """One experiment and the criticism of everything recorded up to it. `left` holds for every finding its cause, then its rivals."""

    battery: str
    seconds: float
    left: tuple[tuple[str, ...], ...]
    verdict: str

    @property
    def unnamed(self) -> bool:
        """Whether no cause was named, or the verdict is that something remains unexplained beside the named causes."""
        return not self.left or self.verdict == "partly_explained"

    @property
    def words(self) -> str:
        """What was named, in words, with the rivals that are left."""
        unnamed = "nothing, though something is wrong" if self.verdict == "unexplained" else "nothing"
        return "; ".join(" or ".join(names) for names in self.left) or unnamed


@dataclass(frozen=True)
class Course:
    """All steps, the last outcome, and every recording."""

    steps: tuple[Step, ...]
    outcome: Outcome
    recordings: tuple[Recording, ...]

    @property
    def seconds(self) -> float:
        """Duration of everything recorded."""
        return sum(s.seconds for s in self.steps)


def until_named(record: Record, first: str, rich: str, budget: float, progress: Progress = lambda stage: None) -> Course:
    """Begin with the battery `first` and go on until one name is left, `budget` (s of recording) is spent, or nothing would help.

    A new name, which was not among those of the step before, is not final yet: a poor battery may not excite its rivals, or other causes.
    It is tested on random motion first, as the thesis validates what it fitted to sines (section 4.3.2). Where something has no name, the
    battery may have excited too little: then the battery `rich` is recorded next, once.
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
        progress(f"named: {steps[-1].words}")
        spent = sum(s.seconds for s in steps) >= budget
        battery = "" if spent else _next(steps, outcome, rich, float(train[0].depth.max()))
    return Course(tuple(steps), outcome, (*train, *held))


def _next(steps: list[Step], outcome: Outcome, rich: str, deepest: float) -> str:
    """The battery to record next, no deeper than `deepest` (m), empty where there is none. In this order: one that separates rivals; the
    battery `rich` where something has no name; random motion where a name is new. No battery is recorded again."""
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
