"""Rivals of a named cause: shared causes and courses that explain almost as much."""

from dataclasses import dataclass

from skin_ident.criticism.courses.kinds import CONSTANT
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.vocabulary import Key
from skin_models.model import Model

EQUAL = 0.003  # share of the best course's score by which a constant course may be worse and still go before it
TARED = 0.1  # the same for a zero no larger than a step of the converter
CHANCE_SCORE = 10.0  # twice nats within which two causes explain as much
PROMISING = 0.8  # share of what one account explains that another must promise in the survey to be fitted, too
REACH = 0.05  # a rival explaining all but this share of the best cause's gain cannot be told from it


@dataclass(frozen=True)
class Rival:
    """A cause that explains the data almost as well: by how much less (squared whitened units), and the model fitted with it."""

    cause: str
    where: str
    short_by: float
    model: Model | None = None

    @property
    def key(self) -> Key:
        """Cause and place."""
        return self.cause, self.where


def reach(score: float) -> float:
    """The score from which a rival cannot be told from a cause that scores `score`."""
    return score - max(CHANCE_SCORE, REACH * score)


def own_rivals(runs: list[Run], score: float, said: set[Key]) -> tuple[Rival, ...]:
    """Courses that explain as much as the score `score`, and other names of the same courses, unless in `said` already; the best first."""
    near = sorted((r for r in runs if r.score > reach(score)), key=lambda r: -r.score)
    short: dict[Key, float] = {}
    for r in near:
        for key in r.course.keys:
            if key not in said:
                short.setdefault(key, score - r.score)
    return tuple(Rival(*key, by) for key, by in short.items())


def plainest_first(runs: list[Run]) -> list[Run]:
    """The courses, simplest first. A zero within a converter's step, as every tare leaves one, goes before what explains little more; then
    constant courses go before others that explain no more; the rest follows by score."""
    best = runs[0].score if runs else 0.0
    tared, lasting = (1.0 - TARED) * best, best - max(CHANCE_SCORE, EQUAL * best)
    return sorted(runs, key=lambda r: (not r.within_a_step or r.score < tared, r.course.shape != CONSTANT or r.score < lasting, -r.score))
