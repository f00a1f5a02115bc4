"""Courses that only held-out sessions have: a zero that stepped there, a clock that slipped, where nothing was fitted."""

import numpy as np

from skin_ident.criticism.baseline.fitting import cost_of, cost_with_own, grown_noise_of
from skin_ident.criticism.courses.course import added, beside_the_rest, fitted
from skin_ident.criticism.courses.gate import course_gain, nearer, stands
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.gates.gate import Gain
from skin_ident.criticism.gates.uncertain import left_open
from skin_ident.criticism.search.doubt import unproven
from skin_ident.criticism.search.hardware import tare_does
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.only_held import note_cause_of_held
from skin_ident.criticism.search.rivals import own_rivals, plainest_first, reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.tared import add_to_held, take_tare_of_held, take_zeros_of_held, taken_off
from skin_ident.criticism.vocabulary import Key

ALONE = 0.9  # largest ratio of errors, after to before, of what is wrong in held-out sessions alone: a smaller fall may be due to the model
FORM = 0.25  # share of the largest fall so far that it must exceed: another form of a named cause mends as much where nothing was fitted
WANDERING = 3.0  # times what unpredictive courses explained in training, which one in held-out sessions alone must explain,
PLAIN = 0.5  # if it leaves more than this share of the error
CERTAIN = 30.0  # likelihood gain in the noise of held-out sessions that is enough for a course of theirs, where much else is left as well
FEW = 3  # steps of a course that only held-out sessions have: no cause of the catalogue is there to explain what more of them follow
TARES = 20  # zeros that may be taken from held-out sessions on the way: each channel has one, and the depth
EXTRAORDINARY = 3.0  # times its size in training sessions, which a course in held-out sessions alone must have


def take_alone(search: Search) -> bool:
    """Name one thing that is wrong in held-out sessions alone: a course of theirs, where the blocks between support it. Return whether
    there was one. Zeros as their tares leave them are taken on the way, and the rest is tested again."""
    if search.alone or not search.held:
        return False
    for _ in range(TARES):
        runs = courses_alone(search)
        run = next(iter(runs), None)
        if run is not None and run.of_the_tare:
            if not _take_zero_alone(search, run):
                return False
            continue
        gain = _gain_alone(search, run) if run else None
        if gain is None:
            return False
        if take_tare_of_held(search, run.course.cause, run.score):
            continue
        cause = _cause_instead(search, run)
        if cause:
            search.doubts[cause] = unproven()
            return False
        restless = _is_restless(run)
        if note_cause_of_held(search, None if restless else run) or restless:
            return False
        _name_alone(search, run, gain, runs)
        return True
    return False


def courses_alone(search: Search) -> list[Run]:
    """Courses that held-out sessions may have and that have not been taken yet, the simplest first."""
    had = {r.course for r in search.runs}
    runs = beside_the_rest(search.present.model, search.train, search.held, search.noise, search.encoder_step)
    return [r for r in plainest_first([r for r in runs if r.worth(search.encoder_step)]) if r.course not in had]


def _take_zero_alone(search: Search, run: Run) -> bool:
    """Take a zero of held-out sessions alone that is a tare's; return whether it was taken. Where the sessions come nearer with it, it is
    the zero of one channel. Else zeros of several channels, in the noise of a quiet mixture of them, may look like that one, and all of
    them are taken."""
    if not nearer(run, search.present.model, search.held):
        return take_zeros_of_held(search, run.score)
    add_to_held(search, run.values)
    search.tared[run.course.key] = tare_does(run.largest, run.tare)
    return True


def _gain_alone(search: Search, run: Run) -> Gain | None:
    """Gain of a course of held-out sessions alone, if it is believed, else None. It must lower their error clearly, be far larger than the
    same course in training, and be more than hardware does."""
    model = search.present.model
    least = search.least(sum(np.count_nonzero(s.weight) for s in search.held))
    if run.score < least or _in_their_noise(search, run) < min(least, CERTAIN):
        return None
    gain = course_gain(run.course, model, model, search.train, search.held, search.noise)
    much = gain.after < ALONE * gain.before and gain.squares > FORM * search.fallen(gain.channel)
    wanders = run.score < WANDERING * search.wandering and gain.after > PLAIN * gain.before
    if not (much and stands(run, gain, model, search.held) and not wanders):
        return None
    if run.size < EXTRAORDINARY * fitted(run.course, model, search.train, search.noise).size:
        return None
    return None if search.steps_do(run.course.key, gain, model) else gain


def _is_restless(run: Run) -> bool:
    """Whether a course steps so often in one session that it follows the motion, as an effect without a name there would make it."""
    return max((moments.size for moments in run.moments.values()), default=0) > FEW


def _cause_instead(search: Search, run: Run) -> Key | None:
    """A cause that training sessions support and that, with its own unknowns fitted to the held-out ones, explains as much of these as the
    course does: they may have more of it, or training sessions less of what shows it."""
    most = cost_of(search.present.model, search.held, search.noise) - reach(run.score)
    for key, grown in search.grown.items():
        supported = grown.score_over(search.present) > search.least(search.present.count)
        if supported and cost_with_own(grown.model, key, search.held, search.noise) < most:
            return key
    return None


def _name_alone(search: Search, run: Run, gain: Gain, runs: list[Run]) -> None:
    search.runs.append(run)
    search.held, search.alone = added(search.held, run.values), run
    rivals = own_rivals(runs, run.score, {run.course.key})
    search.named.append(Named(run.course.cause, run.course.where, gain, run.score, rivals, courses=run.said))
    search.progress(f"named {run.course.cause} in the {run.course.where}, in what was held out alone")


def drop_alone(search: Search) -> bool:
    """Take out what was named in held-out sessions alone if, beside the causes that were named after it, it would not be named any more.
    Return whether it was taken out."""
    run = search.alone
    if run is None or all(n.courses for n in search.named):
        return False
    without = search.ahead(search.present)
    without.held = taken_off(search.held, run.values)
    without.runs = [r for r in search.runs if r is not run]
    without.named = [n for n in search.named if n.courses is not run.said]
    again = next((r for r in courses_alone(without) if r.course == run.course), None)
    if again and _gain_alone(without, again):
        return False
    search.held, search.runs, search.named, search.alone = without.held, without.runs, without.named, None
    return True


def _in_their_noise(search: Search, run: Run) -> float:
    """Score of a course of held-out sessions in the noise that is left there with it: their noise may wander further than that of the
    others."""
    model = search.present.model
    noise = grown_noise_of(model, added(search.held, run.values))
    return fitted(run.course, model, search.held, noise, left_open(model, search.train, search.held, noise)).score
