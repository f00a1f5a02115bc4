"""Skin parameters of each session's own: a specimen is a hundredth stiffer or softer by where it lies today, or how warm it is.

k1, b1, k2 and b2 of a session are the shared ones times 1 + theta. What theta explains is the marginal likelihood of `gates.another_skin`,
with the shared parameters projected out of the residual and tangents of all sessions; it is compared with what any cause explains. Where it
is more, sessions keep parameters of their own. These belong to the baseline, as the zeros of tares do, and held-out sessions have theirs
fitted by themselves. Where a stiffness differs by more than that of specimens does (`NATURAL`), the finding is `parameters` of the skin,
with the numbers of every session. What differs by more than `FARTHEST` mostly has another cause; up to `LARGEST` it is taken for skin where
this explains far more than anything else, or where a held-out session is quiet only with a skin of its own.
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from skin_ident.criticism.baseline.fitting import cost_of, fit, tangents, whitened
from skin_ident.criticism.baseline.residual import placed, residual, stiffness
from skin_ident.criticism.baseline.unknowns import Unknown, unknowns
from skin_ident.criticism.courses.carriers import DEPTH, SLOPE
from skin_ident.criticism.courses.course import added
from skin_ident.criticism.courses.kinds import CONSTANT
from skin_ident.criticism.courses.run import LEAST_SCORE, Run
from skin_ident.criticism.gates.another_skin import SETTLED, TIMES, changes, deviating, deviations, of_the_skin, solved, with_own_skin
from skin_ident.criticism.gates.gate import Gain, gain_of_residuals
from skin_ident.criticism.noise.whitening import stack
from skin_ident.criticism.projection import basis, projected_off
from skin_ident.criticism.said import Said
from skin_ident.criticism.search.alone import courses_alone
from skin_ident.criticism.search.hardware import skin_does, specimens_do
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.only_held import mean_square
from skin_ident.criticism.search.rivals import reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.tared import untared, zero_held
from skin_ident.criticism.sessions.session import FITTED, KEPT, Session
from skin_ident.criticism.vocabulary import PARAMETERS
from skin_models.model import Model

FARTHEST, LARGEST = 0.1, 0.5  # largest relative deviation of any parameter, as specimens differ, and where it explains nearly everything
FAR_AHEAD = 2.0  # times what anything else explains, from which it may be that large: what changes by more than FARTHEST mostly has a cause
NEARLY_AS_LITTLE = 4.0  # times the mean square of fitted sessions, below which another skin explains held-out ones
AHEAD = 1.1  # times the score of a course that skin parameters must explain to go before it
NEARLY = 0.85  # share of the score of a course, or of a cause of skin or rig, which is enough where it may as well be such parameters
MOSTLY = 0.75  # share of a gain's or zero's score from which it is constant in every session but for details
MUCH = 0.5  # share of what skin parameters explain, above which a gain or a zero of depth is reported as in doubt
PATTERN = 4  # sessions from which on a gain that steps looks different from skin that strays
NATURAL = 0.045  # relative deviation of a stiffness that may occur where specimens differ by a hundredth; a larger one is named
SETTLED_IN_NOISE = 1e-3  # change of a parameter below which fits stop that find the noise anew
GAINS_NOTHING = 10.0  # squared whitened units, as little as another instance of a cause must explain: fitted once more, nothing changes
WORTH_SAYING = 0.002  # relative deviation of a parameter from which it is reported


def explained_by_own_skin(search: Search, best: float) -> float:
    """What skin parameters of each session's own explain of training, twice nats. 0 where one would be off by more than specimens are and
    the `best` of everything else does not explain far less, or where they are not considered for these data."""
    if not _asked(search) or len(search.train) < 2:
        return 0.0
    theta, explained = _of_train(search)
    return explained * (np.abs(theta).max() <= (LARGEST if explained > FAR_AHEAD * best else FARTHEST))


def take_own_skin(search: Search, explained: float, best: float, runs: list[Run], refused: bool = False) -> bool:
    """Let the skin differ between sessions where this has `explained` as much as the `best` shared cause, and clearly more than the `runs`
    of one sensor or clock; return whether it was done. Two skin parameters may mimic a gain, or a zero of depth. A gain shows in how it
    goes from session to session beside other channels; with few sessions or a lone channel it does not. There, a gain that strays no
    farther than skin does is left to the skin, if the skin explains nearly as much. So is a zero of depth anywhere. Runs that have been
    `refused` compete no longer. That it may be one of these is noted."""
    whole = {r.course.key: r.score for r in runs if r.course.shape == CONSTANT}
    worth = 0.0 if refused else max((_worth(search, r, whole.get(r.course.key, 0.0)) for r in runs), default=0.0)
    if explained <= max(LEAST_SCORE, reach(best), worth):
        return False
    others = [r for r in runs if r.course.carrier in (SLOPE, DEPTH) and r.score > MUCH * explained]
    search.tared |= {r.course.key: skin_does(r) for r in sorted(others, key=lambda r: r.score)}  # of one key the best is kept
    search.progress("letting the skin differ from session to session")
    search.own_skin = True  # they are fitted where the next round begins
    return True


def _worth(search: Search, run: Run, whole: float) -> float:
    """What skin parameters must explain to go before a run, of whose course a constant explains `whole`. Where that is most of it, further
    steps within sessions are looked for once the skin is another in each."""
    if not _may_be_skin(search, run):
        return AHEAD * run.score
    return NEARLY * (whole if whole > MOSTLY * run.score else run.score)


def take_own_skin_at_last(search: Search, explained: float, runs: list[Run]) -> bool:
    """The same where neither cause nor course is believed though some explain more, if no parameter strays farther than skin does. The
    right cause fails in held-out sessions as long as the model has the skin of others there."""
    if explained <= LEAST_SCORE or np.abs(_of_train(search)[0]).max() > NATURAL:
        return False
    return take_own_skin(search, explained, search.least(search.present.count), runs, refused=True)


def too_few_for_a_pattern(sessions: list[Session]) -> bool:
    """Whether there are too few sessions to show a pattern from one to the next, by which a gain is told from a skin that strays."""
    return len(sessions) < PATTERN


def _may_be_skin(search: Search, run: Run) -> bool:
    """Whether a run may as well be skin: a zero of depth, which another slope makes up for; or, where nothing tells a gain from skin, a
    gain that differs between sessions by no more than skin does, from the mean or from one to the next."""
    alike = too_few_for_a_pattern(search.train) or _is_lone(search.train[0])
    farthest = NATURAL / 2.0 if run.course.shape == CONSTANT else NATURAL
    return run.course.carrier == DEPTH or (alike and _strays_as_skin(run, farthest))


def _is_lone(s: Session) -> bool:
    """Whether the load cell stands alone: no other channel shows whether its gain is off, or the skin is another."""
    return s.channels == ("force",)


def _strays_as_skin(run: Run, farthest: float) -> bool:
    return run.course.carrier == SLOPE and run.largest < farthest


def take_own_skin_of_held(search: Search, of_train: float, runs: list[Run]) -> bool:
    """The same for held-out sessions alone, unless the `runs` of training sessions explain more of training than skin parameters do
    (`of_train`). A lone training session cannot show that."""
    if not _asked(search) or not search.held or (len(search.train) > 1 and runs and AHEAD * runs[0].score > of_train):
        return False
    held = [_with_its_own(search, s) for s in search.held]
    if _farthest(search, held) > FARTHEST:
        return False
    best = courses_alone(search)[:1]
    zeros = all(r.course.carrier == DEPTH for r in best)  # such a zero may be a skin that strays
    gains = _is_lone(search.held[0]) and all(_strays_as_skin(r, NATURAL) for r in best)
    ahead = 1.0 if zeros else NEARLY if gains else AHEAD
    now, left, left_by_course = _left_of_held(search, held, best)
    return now - left > ahead * (now - left_by_course) and take_own_skin(search, now - left, 0.0, runs, refused=True)


def take_other_specimen(search: Search) -> bool:
    """The same before anything is named, where held-out sessions press a skin that is far from the fitted one: as long as it is taken for
    that one, whatever is fitted there stands for the difference. It must leave nearly as little as is left of the fitted sessions, and far
    less than courses do."""
    if search.named or not (_asked(search) and search.held):
        return False
    model = search.present.model
    little = NEARLY_AS_LITTLE * mean_square(search, model, search.train)
    if mean_square(search, model, search.held) <= little:
        return False
    held = [_with_its_own(search, s) for s in search.held]
    if not FARTHEST < _farthest(search, held) <= LARGEST or mean_square(search, model, held) > little:
        return False
    now, left, left_by_course = _left_of_held(search, held, courses_alone(search)[:1])
    return left_by_course > FAR_AHEAD * left and take_own_skin(search, now - left, 0.0, [], refused=True)


def _left_of_held(search: Search, held: list[Session], best: list[Run]) -> tuple[float, float, float]:
    """The cost of held-out sessions: as they are, with skin parameters of their own as in `held`, and with the best course. The parameters
    are charged, and so is the course, since its moments were searched for."""
    model, noise = search.present.model, search.noise
    now, by_skin = (cost_of(model, sessions, noise) for sessions in (search.held, held))
    charge = len(_which(search)) * sum(np.log(max(np.count_nonzero(s.weight), 1)) for s in held)
    return now, by_skin + charge, min([now, *(cost_of(model, added(search.held, r.values), noise) + r.charge for r in best)])


def _farthest(search: Search, sessions: list[Session]) -> float:
    """The largest relative deviation of any skin parameter in some sessions; 0 without any."""
    return max((float(np.abs(deviations(search.present.model, s)).max()) for s in sessions), default=0.0)


def _asked(search: Search) -> bool:
    return not search.own_skin and bool(_which(search))


def settle_skin(search: Search) -> None:
    """Where sessions have skin parameters of their own, fit these once more, and the shared ones beside them; also in the noise that is
    left then, since a large difference between sessions was part of the noise before. A fit that gains nothing is not kept: what was looked
    at need not be looked at again."""
    if not search.own_skin:
        return
    if search.zeros_of_held and not any(s.skin for s in search.held):  # found beside the skin that all sessions shared
        search.held = [_with_its_own(search, s) for s in untared(search)]
        zero_held(search, {})
    for _ in range(TIMES):
        before, as_it_was, cost = _present_of_all(search), (search.train, search.held, search.present), _cost(search)
        if len(search.train) > 1:
            _settle_train(search)
        search.held = [_with_its_own(search, s) for s in search.held]
        if cost - _cost(search) < GAINS_NOTHING:
            search.train, search.held, search.present = as_it_was
        search.look()
        if np.abs(_present_of_all(search) - before).max() < SETTLED_IN_NOISE:
            return


def _cost(search: Search) -> float:
    """The cost of all sessions in the present noise."""
    return cost_of(search.present.model, [*search.train, *search.held], search.noise)


def tell_of_skin(search: Search) -> None:
    """Where the skin may differ between sessions, report by how much; name it where a stiffness differs by more than specimens do and than
    the encoder reads."""
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
        search.tared[PARAMETERS] = specimens_do(largest, lone=sessions[0].name.endswith((FITTED, KEPT)))


def _off(model: Model, s: Session) -> float:
    """Largest relative deviation of the stiffness of any channel in a session from the shared one. Where taxels have shares of a session's
    own, which take up any stiffness, only the load cell shows it."""
    own, channels = placed(model, replace(s, spread=None)), s.channels if s.spread is None else ("force",)
    return max((abs(stiffness(own, c) / stiffness(model, c) - 1.0) for c in channels if stiffness(model, c) > 0.0), default=0.0)


def strays(model: Model, sessions: list[Session]) -> float:
    """The largest relative difference between the sessions' skins in the stiffness of any channel; 0 without such sessions."""
    if not sessions:
        return 0.0
    stiff = np.array([[stiffness(placed(model, replace(s, spread=None)), c) for c in s.channels] for s in sessions])
    return float(np.max(np.ptp(stiff, axis=0) / np.maximum(np.mean(stiff, axis=0), 1e-300)))


def _gain(search: Search) -> Gain:
    """Gain of the sessions' own skin parameters in held-out sessions, or in training where none are held out."""
    tested = search.held or search.train
    before, after = ([residual(search.present.model, s) for s in sessions] for sessions in (_bare(tested), tested))
    return gain_of_residuals(before, after, tested, search.noise, f"{', '.join(s.name for s in tested)}, with numbers of their own")


def _bare(sessions: list[Session]) -> list[Session]:
    return [replace(s, skin={}) for s in sessions]


def _said(s: Session) -> Said:
    return Said.of(", ".join(f"{name} {100.0 * (x - 1.0):+.1f} %" for name, x in s.skin.items()), [x - 1.0 for x in s.skin.values()], "1")


def _settle_train(search: Search) -> None:
    """Fit the skin parameters of training sessions and the shared ones in turn."""
    for _ in range(TIMES):
        before = np.array([deviations(search.present.model, s) for s in search.train])
        theta, _ = _of_train(search)
        search.train = [deviating(search.present.model, s, row) for s, row in zip(search.train, theta, strict=True)]
        search.present = fit(search.present.model, search.train, search.noise)
        if np.abs(theta - before).max() < SETTLED:
            return


def _which(search: Search) -> tuple[Unknown, ...]:
    return of_the_skin(search.present.model, search.train[0])


def _rows(search: Search, s: Session) -> np.ndarray:
    """Whitened change of a session per unit of each theta, (R, U)."""
    return stack([changes(search.present.model, s)], [s], search.noise)


def _present_of_all(search: Search) -> np.ndarray:
    """theta (S, U) as it is in training sessions and in held-out ones after them."""
    return np.array([deviations(search.present.model, s) for s in (*search.train, *search.held)])


def _of_train(search: Search) -> tuple[np.ndarray, float]:
    """theta (S, U) of the training sessions, and its log-likelihood ratio, in twice nats."""
    sessions, noise, model = search.train, search.noise, search.present.model
    Q = basis(stack(tangents(model, sessions, unknowns(model, sessions[0])), sessions, noise))
    J, now = block_diag(*(_rows(search, s) for s in sessions)), np.concatenate([deviations(search.present.model, s) for s in sessions])
    r = whitened(model, sessions, noise) + J @ now
    J, r = projected_off(J, Q), projected_off(r, Q)
    theta, explained = solved(J, r)
    return theta.reshape(len(sessions), -1), explained


def _with_its_own(search: Search, s: Session) -> Session:
    """A held-out session with skin parameters of its own."""
    return with_own_skin(search.present.model, s, search.noise)
