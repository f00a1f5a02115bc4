"""The skin as each session had it: a specimen is a hundredth stiffer where it lies today, or how warm it is.

k1, b1, k2 and b2 of a session are those that all share, times 1 + theta. What theta explains, by the marginal likelihood of
`gates.another_skin`, with residual and tangents of all sessions beside what the shared numbers may do, is held against what any cause does.
Where that is more, sessions keep numbers of their own, which belong to the baseline as the zeros of their tares do; held-out sessions have
theirs by themselves. Where a stiffness differs by more than that of specimens does (`NATURAL`), the finding is `parameters` of the skin,
with the numbers of every session.
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from skin_ident.criticism.baseline.fitting import cost_of, fit, tangents, whitened
from skin_ident.criticism.baseline.residual import placed, residual, stiffness
from skin_ident.criticism.baseline.unknowns import Unknown, unknowns
from skin_ident.criticism.courses.carriers import DEPTH, SLOPE
from skin_ident.criticism.courses.course import added, basis
from skin_ident.criticism.courses.kinds import CONSTANT
from skin_ident.criticism.courses.run import LEAST, Run
from skin_ident.criticism.gates.another_skin import changes, of_the_skin, solved
from skin_ident.criticism.gates.gate import Gain, gain_of_residuals
from skin_ident.criticism.noise.whitening import stack
from skin_ident.criticism.said import Said
from skin_ident.criticism.search.hardware import skin_does, specimens_do
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.own import courses_alone
from skin_ident.criticism.search.rivals import reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import PARAMETERS
from skin_models.model import Model

FARTHEST = 0.1  # that any number may be off: what changes by more has a cause
AHEAD = 1.1  # times what a course explains, which other numbers must to go before it
NEARLY = 0.85  # of what one does that may as well be such numbers
MUCH = 0.5  # of what other numbers explain, which a gain or a zero must that is said to be in doubt
PATTERN = 4  # sessions in which a gain that steps differs from skin that strays
NATURAL = 0.045  # that a stiffness may be off where specimens differ by a hundredth; what differs by more is told
TIMES, SETTLED = 4, 1e-4  # that numbers of all and of each are fitted in turn, until they move by less
WORTH_SAYING = 0.002  # of a number


def explained_by_own_skin(search: Search) -> float:
    """What numbers of each session's own explain of what was fitted: nothing where some would be farther off than specimens are, or where
    they are not asked of these data."""
    if not _asked(search) or len(search.train) < 2:
        return 0.0
    theta, explained = _of_train(search)
    return explained * (np.abs(theta).max() <= FARTHEST)


def take_own_skin(search: Search, explained: float, best: float, runs: list[Run]) -> bool:
    """Whether numbers of each session's own have `explained` as much as the `best` cause of all sessions, and clearly more than the `runs`
    of one sensor or clock, and were taken: two numbers of a skin may be a gain, or a zero of depth. Whether it is a gain shows in how it
    goes from session to session beside other channels, and in few sessions, or a lone channel, it does not: what strays there no farther
    than skin does is left to it where it explains nearly as much. So is a zero of depth anywhere. That it may be one of these is noted."""
    worth = max((r.score * (NEARLY if _may_be_skin(search, r) else AHEAD) for r in runs), default=0.0)
    if explained <= max(LEAST, reach(best), worth):
        return False
    others = [r for r in runs if r.course.carrier in (SLOPE, DEPTH) and r.score > MUCH * explained]
    search.tared |= {r.course.key: skin_does(r) for r in reversed(others)}  # of one key the first is said, which explains most
    search.progress("letting the skin differ from session to session")
    search.own_skin = True  # they are fitted where the next round begins
    return True


def too_few_for_a_pattern(sessions: list[Session]) -> bool:
    """Whether sessions cannot show how something goes from one to the next, by which a gain is known from a skin that strays."""
    return len(sessions) < PATTERN


def _may_be_skin(search: Search, run: Run) -> bool:
    """Whether a run is a zero of depth, that a slope makes up for; or, where nothing tells a gain from skin, one that differs between
    sessions by no more than skin does, about its mean, or from one to the next."""
    if run.course.carrier == DEPTH:
        return True
    alike = too_few_for_a_pattern(search.train) or search.train[0].channels == ("force",)
    return alike and run.course.carrier == SLOPE and run.largest < (NATURAL / 2.0 if run.course.shape == CONSTANT else NATURAL)


def take_own_skin_of_held(search: Search, of_train: float, runs: list[Run]) -> bool:
    """The same of what is left in held-out sessions alone, unless `runs` of those that were fitted explain more of these than the numbers
    do, `of_train`."""
    if not _asked(search) or not search.held or (runs and AHEAD * runs[0].score > of_train):
        return False
    each = [_of_one(search, s) for s in search.held]
    explained = sum(x for _, x in each) * all(np.abs(theta).max() <= FARTHEST for theta, _ in each)
    with_own_skin = [_with(s, search, theta) for s, (theta, _) in zip(search.held, each, strict=True)]
    best = courses_alone(search)[:1]
    now, by_skin, *by_course = (
        cost_of(search.present.model, sessions, search.noise)
        for sessions in (search.held, with_own_skin, *(added(search.held, r.values) for r in best))
    )
    zeros = all(r.course.carrier == DEPTH for r in best)
    ahead = 1.0 if zeros else AHEAD  # such a zero may be a skin that strays; a gain of held-out sessions alone is told from one
    worth = max((now - cost - r.charge for cost, r in zip(by_course, best, strict=True)), default=0.0)  # a moment was searched for
    return now - by_skin > ahead * worth and take_own_skin(search, explained, 0.0, [])


def _asked(search: Search) -> bool:
    return not search.own_skin and bool(_which(search))


def settle_skin(search: Search) -> None:
    """Fit the numbers that every session has of its own once more, and those that all share beside them, where they were taken."""
    if not search.own_skin:
        return
    if len(search.train) > 1:
        _settle_train(search)
    search.held = [_with(s, search, _of_one(search, s)[0]) for s in search.held]


def tell_of_skin(search: Search) -> None:
    """Say how far the skin of sessions differs, where it was let, or name it where a stiffness differs by more than that of any specimen
    does, or than an encoder reads."""
    sessions = [s for s in (*search.train, *search.held) if s.skin]
    if not sessions:
        return
    deepest = max(float(s.motion.x.max()) for s in sessions)
    far = max(_off(search.present.model, s) for s in sessions) > max(NATURAL, search.encoder_step / deepest)
    gain = _gain(search)
    largest = {u.label: max(abs(s.skin[u.label] - 1.0) for s in sessions) for u in _which(search)}
    if far and gain.passed:
        explained = cost_of(search.present.model, _bare(search.train), search.noise) - search.present.cost
        search.named.append(Named(*PARAMETERS, gain, explained, (), courses={s.name: _said(s) for s in sessions}))
        search.progress("named another skin in every session")
    elif max(largest.values()) > WORTH_SAYING:
        search.tared[PARAMETERS] = specimens_do(largest)


def _off(model: Model, s: Session) -> float:
    """By how much the load cell or the taxels are stiffer or softer in a session than in all, as a share."""
    own = placed(model, replace(s, spread=None))
    return max(abs(stiffness(own, c) / stiffness(model, c) - 1.0) for c in s.channels if stiffness(model, c) > 0.0)


def _gain(search: Search) -> Gain:
    """What numbers of their own gain in held-out sessions, or in those that were fitted where none are."""
    tested = search.held or search.train
    before, after = ([residual(search.present.model, s) for s in sessions] for sessions in (_bare(tested), tested))
    return gain_of_residuals(before, after, tested, search.noise, f"{', '.join(s.name for s in tested)}, with numbers of their own")


def _bare(sessions: list[Session]) -> list[Session]:
    return [replace(s, skin={}) for s in sessions]


def _said(s: Session) -> Said:
    return Said.of(", ".join(f"{name} {100.0 * (x - 1.0):+.1f} %" for name, x in s.skin.items()), [x - 1.0 for x in s.skin.values()], "1")


def _settle_train(search: Search) -> None:
    """The numbers of sessions that were fitted, in turn with those that all share."""
    for _ in range(TIMES):
        before = np.array([_present(search, s) for s in search.train])
        theta, _ = _of_train(search)
        search.train = [_with(s, search, row) for s, row in zip(search.train, theta, strict=True)]
        search.present = fit(search.present.model, search.train, search.noise)
        if np.abs(theta - before).max() < SETTLED:
            return


def _which(search: Search) -> tuple[Unknown, ...]:
    return of_the_skin(search.present.model, search.train[0])


def _rows(search: Search, s: Session) -> np.ndarray:
    """What a unit of each theta changes in a session, whitened, (R, U)."""
    return stack([changes(search.present.model, s)], [s], search.noise)


def _present(search: Search, s: Session) -> np.ndarray:
    return np.array([s.skin.get(u.label, 1.0) - 1.0 for u in _which(search)])


def _of_train(search: Search) -> tuple[np.ndarray, float]:
    """theta (S, U) of the sessions that were fitted, and what it explains: twice a log likelihood ratio."""
    sessions, noise, model = search.train, search.noise, search.present.model
    Q = basis(stack(tangents(model, sessions, unknowns(model, sessions[0])), sessions, noise))
    J, now = block_diag(*(_rows(search, s) for s in sessions)), np.concatenate([_present(search, s) for s in sessions])
    r = whitened(model, sessions, noise) + J @ now
    J, r = J - Q @ (Q.T @ J), r - Q @ (Q.T @ r)
    theta, explained = solved(J, r)
    return theta.reshape(len(sessions), -1), explained


def _of_one(search: Search, s: Session) -> tuple[np.ndarray, float]:
    """theta (U,) of a session that was held out, and what it explains."""
    J = _rows(search, s)
    return solved(J, whitened(search.present.model, [s], search.noise) + J @ _present(search, s))


def _with(s: Session, search: Search, theta: np.ndarray) -> Session:
    return replace(s, skin={u.label: 1.0 + float(x) for u, x in zip(_which(search), theta, strict=True)})
