"""A cause that some sessions have and others lack: since a screw came loose, until a filter was taken out, in the cold of one day.

Fitted as a shared cause it is too small for some sessions and too large for the others, and another cause may fit better. So before a
shared cause is taken, the search asks whether a cause that some sessions lack would explain clearly more. Each session s is given an amount
of its own of a direction of the catalogue,

    amounts = G^-1 b,    b_s = d_s' P r,    G_st = [s = t] d_s' d_s - (Q' d_s)' (Q' d_t)

with whitened directions d, the whitened residual r, and P = I - Q Q', which projects off the model's own unknowns. Sorted by these amounts,
the sessions are split in two where a common amount in one part explains most. Which sessions have the cause is a choice, charged as one
coin per session. The cause is then fitted to these sessions, and every session, also a held-out one, is asked again whether it is nearer
with or without it.

Zeros, gains, clocks and drifts of each session's own are courses (see `courses.course`), whatever their amounts. A cause is such a course
where a constant one in the same sensor explains as much, charged as if those sessions shared one amount. Where the skin itself is another
in those sessions, any cause may seem to come and go with it. So other parameters of the plain model for these sessions are a rival. Nothing
is named where they explain clearly more, or most of a cause as slight as another day's skin.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.baseline.fitting import Fit, cost_of, fit, whitened
from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.courses.kinds import CAUSE_OF, CONSTANT
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.gates.gate import Gain, gain_of_residuals, held_out_gain, in_turn, left_by
from skin_ident.criticism.gates.second_opinion import halves_in_turn
from skin_ident.criticism.noise.whitening import stack
from skin_ident.criticism.projection import basis, projected_off
from skin_ident.criticism.search.believing import believed_in_part
from skin_ident.criticism.search.growing import felt
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.own_skin import NEARLY
from skin_ident.criticism.search.plausible import plausible
from skin_ident.criticism.search.rivals import PROMISING, Rival, reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.survey import Survey, survey
from skin_ident.criticism.search.tared import take_tare
from skin_ident.criticism.search.trial import Trial
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import AT_FULL_RATE, PARAMETERS, SENSORS, Key

ELSEWHERE = {AT_FULL_RATE, *CAUSE_OF.values()}  # causes that are looked for in every session by itself
FEWEST = 3  # training sessions, from which on some may have what others lack
MOST = 3  # causes that are fitted, at most
UNFELT = 1e-3  # ratio to what other sessions feel, and to what is felt before the model imitates it, below which a session tells nothing
COIN = 2.0 * np.log(2.0)  # twice nats, charge per session for having the cause or lacking it
TIMES = 3  # rounds in which sessions are asked whether they have it
TELLS = 6.0  # twice nats by which a session must be nearer without a cause to lack it
SLIGHT = 0.013  # share of a force by which skin may differ from day to day
AS_WELL = 0.7  # share of a cause's score above which other parameters stand for a slight cause, and a good stage for any


@dataclass(frozen=True)
class _Seen:
    """What a cause seems to explain to first order, less charges, and the names of the sessions that seem to lack it."""

    key: Key
    score: float
    lacking: frozenset[str]


@dataclass(frozen=True)
class _Tried:
    """A cause fitted to the sessions that have it: the state in which the others lack it, the trial, and its score less the coins."""

    ahead: Search
    trial: Trial
    score: float


def take_partly(search: Search, last: Survey, best: float, of_skin: float, runs: list[Run]) -> bool:
    """Name the best cause that some sessions lack, if it is believed and explains clearly more than the `best` of all others, than skin
    parameters of each session's own (`of_skin`) and than `runs` of its sensor. Return whether to look again."""
    if len(search.train) < FEWEST:
        return False
    least = max(best, of_skin, search.least(search.present.count))
    ground = _Ground.of(search, last)
    seen = [s for s in ground.seen() if s.score > PROMISING * least and s.key not in search.dropped][:MOST]
    tried = sorted(filter(None, (_tried(search, s) for s in seen)), key=lambda t: -t.score)
    if not tried or reach(tried[0].score) <= least:
        return False
    first, *others = tried
    if search.of_stage > AS_WELL * first.score or _is_course(first, runs, ground.charge):
        return False
    if of_skin > NEARLY * first.score and not first.trial.key[1].startswith(SENSORS):
        return False
    numbers = ground.of_other_numbers({s.name for s in first.ahead.train if first.trial.key not in s.lacks})
    if first.score <= reach(numbers) or (numbers > AS_WELL * first.score and _too_slight_to_tell(first)):
        return False
    gain = _gain(search, first)
    if not believed_in_part(first.ahead, first.trial, gain):
        return False
    rivals = [Rival(*t.trial.key, first.score - t.score, t.trial.fit.model) for t in others if t.score > reach(first.score)]
    rivals += [Rival(*PARAMETERS, first.score - numbers)] if numbers > reach(first.score) else []
    sessions = (*first.ahead.train, *first.ahead.held)
    only, free = (tuple(s.name for s in sessions if (first.trial.key in s.lacks) == lacks) for lacks in (False, True))
    named = Named(*first.trial.key, gain, first.score, tuple(rivals), search.present.model, first.trial.fit.model, only=only, free=free)
    if take_tare(search, named):
        return True
    search.train, search.held = first.ahead.train, first.ahead.held
    search.accept(first.trial.fit, named)
    search.end_round(last, named.cause)
    return True


@dataclass(frozen=True)
class _Ground:
    """Inner products of the whitened directions and the residual, by session.

    `squares` (S, M) of the directions, `products` (S, M) with the residual, `along` (S, U, M) with `Q` (R, U), the orthonormal basis of the
    tangents of the model's `own` unknowns (R, U). `left` (R,) is the residual beside these, and `begins` is where each session begins in R.
    """

    keys: tuple[Key, ...]
    names: tuple[str, ...]
    signs: np.ndarray
    squares: np.ndarray
    products: np.ndarray
    along: np.ndarray
    own: np.ndarray
    Q: np.ndarray
    left: np.ndarray
    begins: np.ndarray

    @classmethod
    def of(cls, search: Search, last: Survey) -> "_Ground":
        """From a survey's directions, session by session. They are whitened once more: to keep them from the survey would take as much
        memory as the directions themselves, and save a fiftieth of a search's time."""
        sessions, noise, which = search.train, search.noise, last.projected.which
        every, own = zip(*(last.directions_of(s) for s in sessions), strict=True)
        white = [stack([rows], [s], noise) for rows, s in zip(every, sessions, strict=True)]
        J = np.concatenate([a[:, : own[0]] for a in white])
        r, Q = whitened(search.present.model, sessions, noise), basis(J)
        r = projected_off(r, Q)
        begins = np.cumsum([len(a) for a in white])[:-1]
        parts = list(zip((a[:, own[0] :] for a in white), np.split(Q, begins), np.split(r, begins), strict=True))
        return cls(
            tuple(d.key for d in which),
            tuple(s.name for s in sessions),
            np.array([d.sign for d in which]),
            np.array([np.einsum("rm,rm->m", a, a) for a, _, _ in parts]),
            np.array([a.T @ left for a, _, left in parts]),
            np.array([q.T @ a for a, q, _ in parts]),
            *(J, Q, r, begins),
        )

    def of_other_numbers(self, having: set[str]) -> float:
        """What other parameters of the plain model for these sessions explain, less charges."""
        parts = zip(np.split(self.own, self.begins), self.names, strict=True)
        J = np.concatenate([part * (name in having) for part, name in parts])
        apart = basis(projected_off(J, self.Q))
        return float(np.sum((apart.T @ self.left) ** 2)) - self.charge * apart.shape[1]

    @property
    def charge(self) -> float:
        """Charge for one more parameter, twice nats."""
        return float(np.log(max(np.count_nonzero(self.left), 2)))

    def seen(self) -> list[_Seen]:
        """For every cause, the direction that explains most where some sessions lack it; the best first."""
        best: dict[Key, _Seen] = {}
        for m, (key, sign) in enumerate(zip(self.keys, self.signs, strict=True)):
            one = self._of(m, int(sign)) if key[0] not in ELSEWHERE else None
            if one and one.score > best.get(key, _Seen(key, 0.0, frozenset())).score:
                best[key] = one
        return sorted(best.values(), key=lambda s: -s.score)

    def _of(self, m: int, sign: int) -> _Seen | None:
        """What the direction `m`, of one `sign` or of either (0), explains in the best split of sessions by their amounts; None where a
        session hardly feels it."""
        along = self.along[:, :, m]
        gram, size = np.diag(self.squares[:, m]) - along @ along.T, np.sqrt(self.squares[:, m])
        if size.min() <= UNFELT * size.max():
            return None
        amounts = np.linalg.lstsq(gram / np.outer(size, size), self.products[:, m] / size, rcond=None)[0] / size
        order = np.argsort(-amounts * (sign or 1))
        ways = [order, order[::-1]] if sign == 0 else [order]
        return max((self._split(m, sign, gram, way[:k]) for way in ways for k in range(1, order.size)), key=lambda s: s.score)

    def _split(self, m: int, sign: int, gram: np.ndarray, having: np.ndarray) -> _Seen:
        has = np.isin(np.arange(len(gram)), having)
        energy, product = float(has @ gram @ has), float(has @ self.products[:, m])
        able = energy > UNFELT * float(has @ self.squares[:, m]) and product * (sign or product) > 0.0
        score = product**2 / energy - self.charge - COIN * has.size if able else 0.0
        return _Seen(self.keys[m], score, frozenset(n for n, h in zip(self.names, has, strict=True) if not h))


def _tried(search: Search, seen: _Seen) -> _Tried | None:
    """The cause fitted where sessions have it. None where all or none of them do, where they share it just as well, or where physics rules
    it out."""
    key, lacking = seen.key, seen.lacking
    own = tuple(d for d in search.which if d.key == key)
    trial = None
    for _ in range(TIMES):
        ahead = search.ahead(search.present)
        ahead.train = with_lacking(search.train, key, lacking)
        if trial is None:
            there = survey(search.present.model, ahead.train, own, search.noise)
            trial = ahead.tried(there.ranked[0], there.fits)
        else:
            after = fit(trial.fit.model, ahead.train, search.noise)
            trial = replace(trial, fit=after, score=after.score_over(search.present), plainer=None)
        now = frozenset(s.name for s in search.train if lacks(search, trial.fit, s, key))
        if now == lacking or not 0 < len(now) < len(search.train):
            break
        lacking = now
    alike = fit(trial.fit.model, with_lacking(search.train, key, ()), search.noise)
    score = trial.score - COIN * len(search.train)
    if not (0 < len(now) < len(search.train)) or reach(score) <= alike.score_over(search.present) or not plausible(trial, ahead.train):
        return None
    ahead.held = with_lacking(search.held, key, [s.name for s in search.held if lacks(search, trial.fit, s, key)])
    return _Tried(ahead, trial, score)


def with_lacking(sessions: list[Session], key: Key, lacking: Iterable[str]) -> list[Session]:
    """The sessions, of which those with a name in `lacking` lack a cause and the others have it."""
    return [replace(s, lacks=s.lacks | {key} if s.name in lacking else s.lacks - {key}) for s in sessions]


def lacks(search: Search, after: Fit, s: Session, key: Key) -> bool:
    """Whether a session is clearly nearer to a fit without the cause."""
    having, lacking = (cost_of(after.model, [replace(s, lacks=lacks)], search.noise) for lacks in (s.lacks - {key}, s.lacks | {key}))
    return lacking < having - TELLS


def _is_course(tried: _Tried, runs: list[Run], charge: float) -> bool:
    """Whether a constant course in the same sensor explains as much, charged as one amount that those sessions share."""
    key, coins = tried.trial.key, COIN * len(tried.ahead.train)
    alike = [r for r in runs if r.course.where == key[1] and r.course.shape == CONSTANT]
    return any(r.score + r.charge - charge - coins > reach(tried.score) for r in alike)


def _too_slight_to_tell(tried: _Tried) -> bool:
    """Whether a cause of skin or rig changes so little that it cannot be told from another day's skin."""
    key, model = tried.trial.key, tried.trial.fit.model
    if key[1].startswith(SENSORS):
        return False
    having, without = [s for s in tried.ahead.train if key not in s.lacks], model.lacking(key)
    force = np.sqrt(sum(np.sum(simulated(without, s) ** 2, axis=1) for s in having))
    return bool(np.all(felt(model, key, having) < SLIGHT * force))


def _gain(search: Search, tried: _Tried) -> Gain:
    """Gain of the cause in held-out sessions that have it. Where none does: in the training sessions that have it, each held out in turn,
    or, if only one has it, in each half of that one."""
    ahead, before, after, key = tried.ahead, search.present.model, tried.trial.fit.model, tried.trial.key
    held, train = ([s for s in sessions if key not in s.lacks] for sessions in (ahead.held, ahead.train))
    if held:
        return held_out_gain(before, after, ahead.train, held, search.noise)
    if len(train) == 1:
        return halves_in_turn(before, after, train, search.noise)
    asked = [a for a in in_turn(before, after, ahead.train, search.noise) if key not in a[0].lacks]
    return gain_of_residuals(*left_by(asked, search.noise), [s for s, _, _ in asked], search.noise, "each session that has it in turn")
