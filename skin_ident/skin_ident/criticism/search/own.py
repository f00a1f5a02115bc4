"""Courses that sessions have of their own, as findings of the search: a zero that steps, a gain that drifts, a clock that slips."""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.fitting import Fit, cost_of, fit, grown_noise_of, noise_of
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.courses.carriers import DELAY, DEPTH, SLOPE, ZERO
from skin_ident.criticism.courses.course import added, fitted
from skin_ident.criticism.courses.gate import believed, course_gain, helps, stands
from skin_ident.criticism.courses.kinds import STEPS
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.gates.another_skin import with_own_skin
from skin_ident.criticism.gates.gate import Gain
from skin_ident.criticism.gates.second_opinion import may_be_another_skin
from skin_ident.criticism.gates.uncertain import left_open
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.search.doubt import unproven, wandering
from skin_ident.criticism.search.hardware import tare_does
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.own_skin import too_few_for_a_pattern
from skin_ident.criticism.search.rivals import Rival, own_rivals, reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.tared import untared, with_own_zeros, zero_held
from skin_ident.criticism.search.trial import Trial
from skin_ident.criticism.sessions.session import Session, with_zeros
from skin_ident.criticism.vocabulary import Key
from skin_models.model import Model

SEARCHED = 1.5  # times the least gain worth naming, which a course must explain whose moments are searched for
AT_ONCE_S = 0.3  # s; the most that is explained within one window so long does not count for a searched course
UNREAD = 0.5  # of the encoder's step, by which a change of a depth is not sure to be read
MOSTLY = 0.8  # share of a course's score above which what is the same in all sessions counts as most of it


def fit_beside(search: Search, run: Run) -> tuple[Fit, float]:
    """The model fitted again beside a course, and the course's score with that fit, measured as a trial's is."""
    after = fit(search.present.model, added(search.train, run.values), search.noise)
    return after, search.present.cost - after.cost - run.charge


def own_course(search: Search, run: Run, runs: list[Run], trials: list[Trial]) -> tuple[Run, Named] | None:
    """A finding from a course of each session's own, where the blocks between support it; the other `runs` and the `trials` may be its
    rivals."""
    search.progress(f"trying {run.course.cause} in the {run.course.where}, session by session")
    after, score = fit_beside(search, run)
    gain = _gain_of(search, run, search.present.model, after.model)
    score = max(run.score, score)
    near = reach(_alike_in_all(run, trials, score))
    rivals = tuple(Rival(*t.key, score - t.score) for t in trials if t.score > near and t.key[0] != run.course.cause)
    rivals += own_rivals(runs, run.score, {run.course.key, *(r.key for r in rivals)})
    rivals += _of_other_channels(search, run, runs, {r.key for r in rivals})
    searched = run.course.shape == STEPS or run.course.carrier == SLOPE  # moments are searched for, and some are found in any noise
    least = SEARCHED * search.least(after.count)
    told = score - _at_once(run, search) > least if searched else score > _of_wandering(run, search.least(after.count))
    told = told and score > search.form_of_others(*run.course.key) and not search.shadows(gain)
    stood = stands(run, gain, search.present.model, search.train)
    stood = stood and (run.course.slopes or helps(run, search.present.model, after.model, search.train, search.held, search.noise))
    if not (told and stood) or search.steps_do(run.course.key, gain, after.model):
        predicts, slips = believed(gain, run.course), run.course.carrier == DELAY
        search.wandering = search.wandering if predicts else max(search.wandering, run.score)
        if told and score > least and not predicts and (not slips or gain.ci95[0] > 0.0):
            search.doubts[run.course.key] = unproven() if slips else wandering(run)
        return None
    return run, Named(run.course.cause, run.course.where, gain, score, rivals, courses=run.said)


def _of_other_channels(search: Search, run: Run, runs: list[Run], told: set[Key]) -> tuple[Rival, ...]:
    """The opposite gain of the load cell, of a gain that all taxels have, and the reverse. The channels alone show only that they have come
    apart; which of them has changed, the depth must tell, and a change by less than half a step of the encoder is none to be sure of."""
    other = {"taxel": "load_cell", "load_cell": "taxel"}.get(run.course.where)
    deepest = max(float(s.motion.x.max()) for s in search.train)
    if run.course.carrier != SLOPE or run.largest * deepest > UNREAD * search.encoder_step:
        return ()
    others = [r for r in runs if r.course.carrier == SLOPE and r.course.where == other and r.course.key not in told]
    return tuple(Rival(*r.course.key, run.score - r.score) for r in others[:1])


def _gain_of(search: Search, run: Run, before: Model, after: Model) -> Gain:
    """Gain of a course beside `after` over `before`, under noise that is fitted beside the course: the search's own noise model has taken
    the course for noise as well."""
    noise = grown_noise_of(after, added(search.train, run.values))
    having = [s for s in search.train if np.any(run.values[s.name])]
    return course_gain(run.course, before, after, search.train, _of_any_skin(search, run, before, search.held, noise), noise, having)


def _of_any_skin(search: Search, run: Run, model: Model, held: list[Session], noise: Whitener) -> list[Session]:
    """The held-out sessions as a course is compared in them. Another skin looks like another zero of depth; and where few sessions were
    fitted, like what is constant of a gain that steps in them. There it is another skin that they have, and a course must gain, and is
    fitted, beside that. A gain that is constant in every session is nothing else, and is told from skin by how it goes from one to the
    next."""
    stepping = (run.course.carrier, run.course.shape) == (SLOPE, STEPS)
    like_skin = run.course.carrier == DEPTH or (stepping and too_few_for_a_pattern(search.train))
    if not (like_skin and held and may_be_another_skin(model, held)):
        return held
    return [with_own_skin(model, s, noise) for s in held]


def _of_wandering(run: Run, least: float) -> float:
    """Score that a course of a zero may owe to noise that wanders from session to session: the `least` that is worth naming. 0 for
    others."""
    return least if run.course.carrier == ZERO else 0.0


def _at_once(run: Run, search: Search) -> float:
    """The most that a course of one channel explains within one short window, of the squared whitened error. Noise that wanders and has
    heavy tails jumps for good now and then, which looks like a step. A jump in all channels at once is no noise of theirs."""
    most = 0.0
    if run.course.carrier not in (SLOPE, ZERO):
        return most
    for s in search.train:
        before = residual(search.present.model, s)
        after = before - s.band.thin(run.values[s.name])
        fall = sum(np.sum(sign * search.noise.apply(e, s) ** 2, axis=0) for sign, e in ((1.0, before), (-1.0, after)))
        width = max(round(AT_ONCE_S / s.band.spacing), 1)
        most = max(most, float(np.convolve(fall, np.ones(width)).max()))
    return most


def _alike_in_all(run: Run, trials: list[Trial], score: float) -> float:
    """Score of the shared cause with the same name as the course, where that is most of the course's `score`; else `score`. Rivals are
    shared by all sessions, so they are compared with what sessions share of the course. The rest of it may belong to another cause."""
    shared = max((t.score for t in trials if t.key == run.course.key), default=0.0)
    return shared if shared > MOSTLY * score else score


def take_course(search: Search, run: Run, finding: Named) -> None:
    """Give every session its course, and name it unless it is no more than a tare leaves; the search goes on with what is left. The course
    was found in noise that held it as well, and its moments may be off. So it is fitted once more in the noise that is left with it, there
    and in held-out sessions."""
    run, finding = _in_place_of_drift(search, run, finding)
    train = added(search.train, run.values)
    model = fit(search.present.model, train, search.noise).model
    noise = noise_of(model, train, search.noise.growth)
    again = fitted(run.course, model, search.train, noise)
    moved = added(search.train, again.values)
    if cost_of(model, moved, noise) < cost_of(model, train, noise):
        run, train = again, moved
    search.present = fit(model, train, search.noise)
    held = untared(search)
    other = _in_held(search, run, train, held, noise) if held else None
    tared, of_tares = held is not search.held, run.of_the_tare and (other is None or other.of_the_tare)
    run = run.joined(other) if other else run
    search.runs.append(run)
    put = with_zeros if of_tares else added
    search.train, search.held = put(search.train, run.values), put(held, run.values)
    if tared:
        zero_held(search, {})
    if of_tares:
        search.tared[run.course.key] = tare_does(run.largest, run.tare)
        return
    search.named.append(replace(finding, courses=run.said))
    search.progress(f"named {finding.cause} in the {finding.where}")


def _in_held(search: Search, run: Run, train: list[Session], held: list[Session], noise: Whitener) -> Run:
    """The course in held-out sessions, which are without their zeros in `held`: fitted beside another skin, beside that of the others, or
    beside the zeros that they had; whichever leaves less of them, with what the numbers of a skin are charged."""
    model, tared = search.present.model, held is not search.held
    free, charge = left_open(model, train, held, noise), np.log(max(sum(np.count_nonzero(s.weight) for s in held), 2))

    def fit_in(sessions: list[Session], left_in: list[Session]) -> tuple[float, Run]:
        own = fitted(run.course, model, sessions, noise, free)
        with_it = added(left_in, own.values)
        left = cost_of(model, with_own_zeros(search, with_it) if tared else with_it, noise)
        return left + own.charge + charge * sum(len(s.skin) for s in left_in), own

    another = _of_any_skin(search, run, model, held, noise)
    fits = [fit_in(held, held)]
    fits += [fit_in(another, another)] if another is not held else []
    fits += [fit_in(search.held, held)] if tared else []
    return min(fits, key=lambda each: each[0])[1]


def _in_place_of_drift(search: Search, run: Run, finding: Named) -> tuple[Run, Named]:
    """The course of a zero, and its finding. If a drift of the same zero was named, and it explains next to nothing beside a course fitted
    without it, the drift is taken out and that course is returned: the drift was what jumps of all sessions have in common."""
    drift = next((n for n in search.named if n.key == ("drift", run.course.where) and not n.courses), None)
    if run.course.carrier != ZERO or drift is None:
        return run, finding
    bare = fit(search.present.model.lacking(drift.key), search.train, search.noise)
    alone = fitted(run.course, bare.model, search.train, search.noise)
    after = fit(bare.model, added(search.train, alone.values), search.noise)
    beside, _ = fit_beside(search, run)
    if after.cost + alone.charge - beside.cost - run.charge > search.least(after.count):
        return run, finding
    gain = _gain_of(search, alone, bare.model, after.model)
    if not believed(gain, run.course):
        return run, finding
    search.named.remove(drift)
    search.befores.pop(drift.key, None)
    search.present = bare
    return alone, replace(finding, gain=gain, explained=bare.cost - after.cost - alone.charge)
