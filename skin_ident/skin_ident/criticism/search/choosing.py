"""The choice between a cause that all sessions share and a course that each session has of its own."""

from dataclasses import replace

from skin_ident.criticism.baseline.fitting import Fit
from skin_ident.criticism.courses.carriers import DELAY, SLOPE
from skin_ident.criticism.courses.course import fitted
from skin_ident.criticism.courses.kinds import CONSTANT, STEPS
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.search.believing import first_believed
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.own import fit_beside, own_course
from skin_ident.criticism.search.rivals import CHANCE_SCORE
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.trial import Trial
from skin_models.model import Model

MARGIN = 1.1  # times the score of the best shared cause that a course must reach to go first
BEHIND = 0.9  # times the same, from which a course is tried where held-out data refuse that cause; and a cause counts as one of the best
NEARLY = 0.9  # share of a bending course's score that a constant course must reach to replace it
BESIDE = 0.6  # share of the score of a course that predicts nothing, which another cause must explain to be tried


def choose(search: Search, trials: list[Trial], runs: list[Run]) -> tuple[tuple[Run, Named] | None, tuple[Fit, Named] | None]:
    """The course or the shared cause that is believed, with its run or fit; the other one, or both, is None.

    A course is chosen where it explains clearly more than any shared cause, or where held-out data refuse those. Where both are the same
    cause at one place, the form that explains more is chosen. Where a course explains clearly more and yet predicts nothing, noise wanders
    more than the noise model knows, and no cause is named that explains far less. A clock that slips, or a zero that jumps, is no wandering
    noise: where it predicts nothing it is passed over, but what explains far less than a clock that is in doubt is not named.
    """
    chosen = _chosen(search, trials, runs)
    if any(chosen) or not runs or not runs[0].course.jumps:
        return chosen
    return _chosen(search, trials, [r for r in runs if not r.course.jumps])


def _chosen(search: Search, trials: list[Trial], runs: list[Run]) -> tuple[tuple[Run, Named] | None, tuple[Fit, Named] | None]:
    if not runs:
        return None, first_believed(search, trials, runs)
    first, best = runs[0], max((t.score for t in trials), default=0.0)
    leads = _leads(search, trials, first)
    same, score = bool(trials) and trials[0].key == first.course.key, first.score
    if same and not leads:  # in another form than the best trial, which was refitted with everything else, so this is refitted as well
        score = max(score, fit_beside(search, first)[1])
    own = _own(search, runs, trials) if leads or (same and score > best) else None
    if own:
        return own, None
    if leads and first.course.carrier == DELAY:
        least = BESIDE * first.score if first.course.key in search.doubts else 0.0
        others = [r for r in runs if r.course.carrier != DELAY and r.score > least]
        return _chosen(search, [t for t in trials if t.score > least], others)
    shared = first_believed(search, trials, runs) if not leads or best > BESIDE * first.score else None
    if not (shared or leads) and score > BEHIND * best:
        return _own(search, runs, trials), None
    return None, shared


def _leads(search: Search, trials: list[Trial], first: Run) -> bool:
    """Whether a course explains clearly more than any shared cause; one that steps, also more than a shared cause beside what is the same
    in a session from its start. For steps stand for both: a gain that creeps in skins that differ, for example."""
    best = max((t.score for t in trials), default=0.0)
    if first.score <= (best if _is_one_number(first) else max(MARGIN * best, best + CHANCE_SCORE)):
        return False

    def from_the_start(model: Model) -> float:
        at = {s.name: s.motion.t[:1] for s in search.train}
        return max(fitted(first.course, model, search.train, search.noise, at=at).score, 0.0)

    if first.course.shape != STEPS or from_the_start(search.present.model) > best:
        return True
    return first.score > max((t.score + from_the_start(t.fit.model) for t in trials if t.score > BEHIND * best), default=0.0)


def _own(search: Search, runs: list[Run], trials: list[Trial]) -> tuple[Run, Named] | None:
    """A finding from the first of the courses. Where that one bends and predicts nothing, from the constant course that explains nearly all
    of it: the bend then belongs to another cause."""
    first = runs[0]
    kept = [r for r in runs[1:] if r.course == replace(first.course, shape=CONSTANT) and r.score > NEARLY * first.score]
    return next(filter(None, (own_course(search, r, runs, trials) for r in (first, *kept))), None)


def _is_one_number(run: Run) -> bool:
    """Whether a course is one number per session that other depths do not mimic; a slope they do."""
    return run.course.shape == CONSTANT and run.course.carrier != SLOPE
