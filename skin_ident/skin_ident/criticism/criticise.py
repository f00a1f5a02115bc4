"""The loop: survey, try the best few, let held-out sessions decide, repeat, eliminate, and ask what is left."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.fitting import Fit, fit, fit_effects
from skin_ident.criticism.gate import Gain, held_out_gain
from skin_ident.criticism.growing import grow
from skin_ident.criticism.proposals import Direction, directions
from skin_ident.criticism.ranking import Ranked
from skin_ident.criticism.session import Session, without_parting
from skin_ident.criticism.start import dispersion_start
from skin_ident.criticism.survey import Survey, survey
from skin_ident.criticism.whitening import Whitener
from skin_models.model import Model

MOST_FINDINGS = 5
SHORTLIST = 4  # causes that are refitted before one is chosen
WITHIN = 0.4  # of the best score: further down, no refit makes up for it
NUMBERS = 0.1  # relative fall of the held-out error by which given numbers are called wrong: an imperfect effect bends them a little
SHADOW = 0.03  # of the largest fall of a mean square so far, below which a further cause is not named
REACH = 0.05  # a rival explaining all but this share of the best cause's gain cannot be told from it

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Rival:
    """A cause that explains the data almost as well: by how much less (squared whitened units), and the model fitted with it."""

    cause: str
    where: str
    short_by: float
    model: Model | None = None


@dataclass(frozen=True)
class Named:
    """One cause in the extended model, with its evidence, and the models fitted without it (`before`) and with it, when it was named."""

    cause: str
    where: str
    gain: Gain
    explained: float
    alternatives: tuple[Rival, ...]
    before: Model | None = None
    model: Model | None = None


@dataclass(frozen=True)
class Criticism:
    """Everything the criticism found, before it is written down."""

    baseline: Fit
    extended: Fit
    named: tuple[Named, ...]
    last: Survey
    refused: tuple[Named, ...]
    rounds: tuple[tuple[Survey, str | None], ...] = ()


def criticise(
    train: list[Session], held: list[Session], given: Model | None = None, progress: Progress = lambda stage: None, mass: float = 0.0
) -> Criticism:
    """Find what the baseline gets wrong on `train`, believing only what also predicts `held` better. `mass` is that of the skin, kg."""
    which = directions(train[0])
    progress("fitting the baseline")
    start = given or dispersion_start(train, mass)
    train, held = ([without_parting(s, start.dispersion) for s in sessions] for sessions in (train, held))
    first = survey(start, train, which)
    fitted = fit(first.model, train, first.noise)
    baseline = fit(given, train, first.noise, 0) if given else fitted
    present, named, refused, rounds, befores = fitted, [], [], [], {}
    while True:
        progress("surveying every cause")
        last = survey(present.model, train, which)
        present = replace(present, cost=fit(present.model, train, last.noise, 0).cost)
        if len(rounds) == MOST_FINDINGS:
            break
        trials = _trials(present, last, train, which, progress)
        largest = max((n.gain.squares for n in named), default=0.0)
        accepted = _first_believed(present, trials, last.noise, train, held, refused, largest)
        rounds.append((last, accepted and accepted[1].cause))
        if accepted is None:
            break
        before, (present, finding) = present, accepted
        named = _with(named, finding, befores, before, present, train, held, last.noise)
        progress(f"named {finding.cause} in the {finding.where}")
    kept, named = _eliminated(present, named, train, held, last.noise)
    if given:
        kept, named = _numbers_checked(given, kept, named, train, held, last.noise)
    if kept is not present:
        last = survey(kept.model, train, which)
    return Criticism(baseline, kept, tuple(named), last, tuple(refused), tuple(rounds))


def _numbers_checked(given: Model, kept: Fit, named: list[Named], train, held, noise: Whitener) -> tuple[Fit, list[Named]]:
    """Whether the numbers of the given model are wrong once every named cause is in it; where they are not, they stay as given."""
    as_given = replace(kept.model, dispersion=given.dispersion, shares=given.shares, name=given.name, source=given.source)
    frozen = fit_effects(as_given, train, noise)
    gain = held_out_gain(frozen.model, kept.model, train, held, noise, fit_effects)
    if not gain.passed or gain.before - gain.after < NUMBERS * gain.before:
        return frozen, named
    return kept, [Named("parameters", "skin", gain, frozen.cost - kept.cost, ()), *named]


@dataclass(frozen=True)
class _Trial:
    ranked: Ranked
    fit: Fit
    score: float


def _trials(present: Fit, last: Survey, train, which: tuple[Direction, ...], progress: Progress) -> list[_Trial]:
    """The most promising causes, each grown and refitted, the best first."""
    able = [r for r in last.ranked if r.score > max(0.0, WITHIN * last.ranked[0].score)][:SHORTLIST]
    trials = []
    for r in able:
        progress(f"trying {r.cause} in the {r.where}")
        grown = grow(present, r, train, which, last.noise)
        charge = np.log(grown.count) * (len(grown.unknowns) - len(present.unknowns))
        trials.append(_Trial(r, grown, present.cost - grown.cost - charge))
    return sorted(trials, key=lambda t: -t.score)


def _first_believed(present: Fit, trials: list[_Trial], noise: Whitener, train, held, refused: list[Named], explained: float):
    """The best trial that held-out data support, as (fit, finding), or None. What they do not support is kept in `refused`.

    `explained` is the largest fall of a mean square so far (N^2): what is small beside it may be the imperfect form of that effect.
    """
    for trial in trials:
        if trial.score <= 0.0:
            continue
        gain = held_out_gain(present.model, trial.fit.model, train, held, noise)
        rivals = [t for t in trials if t is not trial and t.score > trial.score - max(10.0, REACH * trial.score)]
        alternatives = tuple(Rival(t.ranked.cause, t.ranked.where, trial.score - t.score, t.fit.model) for t in rivals)
        finding = Named(trial.ranked.cause, trial.ranked.where, gain, trial.score, alternatives, present.model, trial.fit.model)
        if gain.passed and gain.squares > SHADOW * explained:
            return trial.fit, finding
        refused.append(finding)
    return None


def _with(named: list[Named], finding: Named, befores: dict, before: Fit, after: Fit, train, held, noise: Whitener) -> list[Named]:
    """`named` with one more finding. More of a cause that is there already joins it, and its gain then counts from before the first."""
    key = (finding.cause, finding.where)
    start = befores.setdefault(key, before)
    same = next((n for n in named if (n.cause, n.where) == key), None)
    if same is None:
        return [*named, finding]
    gain = held_out_gain(start.model, after.model, train, held, noise)
    return [replace(n, gain=gain, explained=n.explained + finding.explained) if n is same else n for n in named]


def _eliminated(present: Fit, named: list[Named], train, held, noise: Whitener) -> tuple[Fit, list[Named]]:
    """Take out every cause, last found first, without which the rest predicts held-out data just as well."""
    for finding in reversed(named[:-1]):
        rest = tuple(e for e in present.model.effects if (e.cause, e.where) != (finding.cause, finding.where))
        without = fit(replace(present.model, effects=rest), train, noise)
        gain = held_out_gain(without.model, present.model, train, held, noise)
        if not gain.passed:
            present, named = without, [n for n in named if n is not finding]
    return present, named
