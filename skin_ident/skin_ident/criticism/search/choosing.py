"""Which is believed: a cause that all sessions share, or what each has of its own."""

from dataclasses import replace

from skin_ident.criticism.baseline.fitting import Fit
from skin_ident.criticism.courses.carriers import DELAY, SLOPE
from skin_ident.criticism.courses.kinds import CONSTANT
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.search.believing import first_believed
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.own import fit_beside, own_course
from skin_ident.criticism.search.rivals import CHANCE
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.trial import Trial

MARGIN = 1.1  # times the likelihood gain of the best shared cause that a course must reach to go first
BEHIND = 0.9  # times the same to be tried at all, where held-out data refuse that cause
NEARLY = 0.9  # of what a course that bends explains, which one that lasts must
BESIDE = 0.6  # of what a course explains that predicts nothing, the least that another cause must explain to be asked beside it


def choose(search: Search, trials: list[Trial], runs: list[Run]) -> tuple[tuple[Run, Named] | None, tuple[Fit, Named] | None]:
    """What each session has of its own, where that explains clearly more than any shared cause or where held-out data refuse those. Of
    one cause at one place that form is taken which explains more.

    Where it explains clearly more and yet predicts nothing, noise wanders more than the noise model knows, and no cause is named that
    explains far less. A clock that slips, or a zero that jumps, wherever it helps is no noise: where it predicts nothing, it is passed
    over; what explains far less than a clock that is in doubt is not named.
    """
    chosen = _chosen(search, trials, runs)
    if any(chosen) or not runs or not runs[0].course.jumps:
        return chosen
    return _chosen(search, trials, [r for r in runs if not r.course.jumps])


def _chosen(search: Search, trials: list[Trial], runs: list[Run]) -> tuple[tuple[Run, Named] | None, tuple[Fit, Named] | None]:
    if not runs:
        return None, first_believed(search, trials, runs)
    first, best = runs[0], max((t.score for t in trials), default=0.0)
    leads = first.score > (best if _is_one_number(first) else max(MARGIN * best, best + CHANCE))
    same, score = bool(trials) and trials[0].key == first.course.key, first.score
    if same and not leads:  # in another form than the best trial, which has been refitted, too
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


def _own(search: Search, runs: list[Run], trials: list[Trial]) -> tuple[Run, Named] | None:
    """A finding from the first of the courses, or, where that bends and predicts nothing, from the constant that is nearly all of it: what
    bends there is of another cause."""
    first = runs[0]
    kept = [r for r in runs[1:] if r.course == replace(first.course, shape=CONSTANT) and r.score > NEARLY * first.score]
    return next(filter(None, (own_course(search, r, runs, trials) for r in (first, *kept))), None)


def _is_one_number(run: Run) -> bool:
    """Whether a course is one number of each session, which other depths do not feign."""
    return run.course.shape == CONSTANT and run.course.carrier != SLOPE
