"""A second opinion, where held-out sessions leave in doubt what training sessions show beyond doubt.

One session may be too short, or move in too few ways, to show an effect of half the noise's size. All sessions together say more, each
predicted by models that were fitted without it. Where only a single session moves so that the effect shows, no model fitted to the others
can know it. Then one half of every session is predicted by models that were fitted to the other half. Sessions are the better test, because
wandering noise is less alike between sessions than between halves: so halves are tried last, and must gain more.

Where the skin is another in a held-out session, this may leave more there than a cause gains. So every session is tested once more with
skin parameters of its own (see `another_skin`). Where gains or contacts differ from session to session, a better model may predict a
channel worse than a poor one, only because of the scale. That is another cause, and says nothing of the one under test.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.own_shares import regression
from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.baseline.settling import settled
from skin_ident.criticism.gates.another_skin import left_beside_own_skin, of_the_skin
from skin_ident.criticism.gates.gate import CLEAR_FALL, Asked, Gain, gain_of_residuals, in_turn, left_by, left_in_held, refitted
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

SCALES = (0.5, 2.0)  # range of the factor that another gain or contact may give a channel


def all_in_turn(before: Model, after: Model, train: list[Session], held: list[Session], noise: Whitener) -> Iterator[Gain]:
    """Gain of `after` over `before` in all sessions: training sessions are predicted by fits to the others, held-out ones by the fit to all
    training sessions. Then the same with skin parameters of each session's own, unless sessions have these already, or press at several
    places and have shares of their own."""
    asked = in_turn(before, after, train, noise)
    sessions = [*(s for s, _, _ in asked), *held]
    left = [a + b for a, b in zip(left_by(asked, noise), left_in_held(before, after, train, held, noise), strict=True)]
    yield gain_of_residuals(*left, sessions, noise, "every session in turn")
    if may_be_another_skin(before, sessions):
        asked += [(s, before, after) for s in held]
        yield _beside_own_skin(asked, noise, "every session in turn, with a skin of its own")


def halves_in_turn(before: Model, after: Model, train: list[Session], noise: Whitener) -> Gain:
    """Gain of `after` over `before` where each half of every session is predicted by models that were fitted to the other halves."""
    earlier, later = zip(*(_halves(s) for s in train), strict=True)
    asked = [*_predicting(later, earlier, before, after, noise), *_predicting(earlier, later, before, after, noise)]
    gain = gain_of_residuals(*left_by(asked, noise), [s for s, _, _ in asked], noise, "each half of the sessions in turn")
    return gain if gain.relative > CLEAR_FALL else replace(gain, lower=min(gain.lower, 0.0))


def may_be_another_skin(model: Model, sessions: list[Session]) -> bool:
    """Whether the skin may differ in sessions that do not have skin parameters of their own yet."""
    return sessions[0].spread is None and bool(of_the_skin(model, sessions[0])) and not all(s.skin for s in sessions)


def beside_own_skin(before: Model, after: Model, train: list[Session], held: list[Session], noise: Whitener) -> Gain:
    """Gain of `after` over `before` in held-out sessions with skin parameters of each session's own."""
    asked = _asked(before, after, train, held, noise)
    return _beside_own_skin(asked, noise, f"{_names(asked)}, with a skin of its own")


def _beside_own_skin(asked: list[Asked], noise: Whitener, said: str) -> Gain:
    left = [[left_beside_own_skin(models[i], s, noise) for s, *models in asked] for i in (0, 1)]
    return gain_of_residuals(*left, [s for s, _, _ in asked], noise, said)


def at_any_scale(before: Model, after: Model, train: list[Session], held: list[Session], noise: Whitener) -> Gain:
    """Gain of `after` over `before` in held-out sessions where a free factor scales each channel of every session."""
    asked = _asked(before, after, train, held, noise)
    left = ([_left_at_any_scale(models[i], s) for s, *models in asked] for i in (0, 1))
    return gain_of_residuals(*left, [s for s, _, _ in asked], noise, f"{_names(asked)}, at any scale")


def _asked(before: Model, after: Model, train: list[Session], held: list[Session], noise: Whitener) -> list[Asked]:
    """The held-out sessions with both models; without any, training sessions in turn."""
    return [(s, before, after) for s in held] or in_turn(before, after, train, noise)


def _names(asked: list[Asked]) -> str:
    return ", ".join(s.name for s, _, _ in asked)


def _left_at_any_scale(model: Model, session: Session) -> np.ndarray:
    s = settled(model, session)
    y = s.band.thin(simulated(model, s))
    factor = np.clip(regression(s.measured[None], y, s.weight)[0], *SCALES)
    return s.measured - factor[:, None] * y


def _predicting(these: tuple[Session, ...], fitted: tuple[Session, ...], before: Model, after: Model, noise: Whitener) -> list[Asked]:
    models = refitted(before, after, list(fitted), noise)
    return [(s, *models) for s in these]


def _halves(s: Session) -> tuple[Session, Session]:
    early = np.arange(s.t.size) < s.t.size // 2
    return replace(s, weight=s.weight * early), replace(s, weight=s.weight * ~early)
