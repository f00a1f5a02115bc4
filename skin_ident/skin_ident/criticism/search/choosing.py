"""Which is believed: a cause that all sessions share, or what each has of its own."""

from skin_ident.criticism.baseline.fitting import Fit
from skin_ident.criticism.courses.carriers import DELAY, SLOPE
from skin_ident.criticism.courses.course import BEHIND, MARGIN
from skin_ident.criticism.courses.kinds import CONSTANT
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.search.believing import first_believed
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.own import own_course, refitted
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.trial import Trial

BESIDE = 0.6  # of what a course explains that predicts nothing, the least that a shared cause must explain to be asked beside it


def choose(search: Search, trials: list[Trial], runs: list[Run]) -> tuple[tuple[Run, Named] | None, tuple[Fit, Named] | None]:
    """What each session has of its own, where that explains clearly more than any shared cause or where held-out data refuse those. Of
    one cause at one place that form is taken which explains more.

    Where it explains clearly more and yet predicts nothing, noise wanders more than the noise model knows, and no cause is named that
    explains far less. A clock that slips wherever it helps is no noise: where it predicts nothing, it is passed over.
    """
    best = max((t.score for t in trials), default=0.0)
    plain = runs and runs[0].course.shape == CONSTANT and runs[0].course.carrier != SLOPE  # one number, and no other depths feign it
    first = runs and runs[0].score > (best if plain else max(MARGIN * best, best + 10.0))
    same = trials and runs and trials[0].key == runs[0].course.key
    score = runs[0].score if runs else 0.0
    if same and not first:  # in another form than the best trial, which has been refitted, too
        score = max(score, refitted(search, runs[0])[1])
    own = own_course(search, runs, trials) if first or (same and score > best) else None
    if first and not own and runs[0].course.carrier == DELAY:
        return choose(search, trials, [r for r in runs if r.course.carrier != runs[0].course.carrier])
    asked = not own and (not first or best > BESIDE * runs[0].score)
    shared = first_believed(search, trials, runs) if asked else None
    if not (own or shared or first) and runs and score > BEHIND * best:
        own = own_course(search, runs, trials)
    return own, shared
