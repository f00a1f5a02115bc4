"""The closed loop: record, criticise, record what would separate the rivals that are left, and so on until one name is left.

Every experiment is recorded twice, once to fit and once to be predicted, and everything recorded so far is criticised together.
"""

from collections.abc import Callable
from dataclasses import dataclass

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.telling.outcome import Outcome
from skin_ident.recordings.recording import Recording

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
    def decided(self) -> bool:
        """Whether something is named, and no finding has a rival any more."""
        return bool(self.left) and all(len(names) == 1 for names in self.left)

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

    Where nothing is named there are no rivals to separate, and the first battery may have been too poor to show anything: then the battery
    `rich` is next, once. So it is where no motion would tell the rivals apart: what else it shows may change the names.
    """
    train, held, steps, battery = [], [], [], first
    while True:
        progress(f"experiment {len(steps) + 1}: recording twice")
        train.append(record(battery, f"experiment_{len(steps) + 1}"))
        held.append(record(battery, f"experiment_{len(steps) + 1}_again"))
        outcome = diagnose(train, held, None, progress)
        steps.append(
            Step(battery, sum(float(r.t[-1] - r.t[0]) for r in (train[-1], held[-1])), _left(outcome), outcome.findings["verdict"])
        )
        progress(f"left: {steps[-1].words}")
        battery = next((b for b in (*outcome.batteries.values(), rich) if b not in [s.battery for s in steps]), "")
        if steps[-1].decided or not battery or sum(s.seconds for s in steps) >= budget:
            return Course(tuple(steps), outcome, (*train, *held))


def _left(outcome: Outcome) -> tuple[tuple[str, ...], ...]:
    findings = outcome.findings["findings"]
    return tuple((_name(f), *(_name(a) for a in f["alternatives"])) for f in findings)


def _name(entry: dict) -> str:
    return f"{entry['cause']} in the {entry['where']}"
