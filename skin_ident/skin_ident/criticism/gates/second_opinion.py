"""A second opinion, where the held-out sessions leave in doubt what training finds beyond doubt.

One session may be too short, or move in too few ways, to tell an effect of half the noise's size. All sessions together say more, each
predicted by models that were fitted without it. Where a single session moves so that the effect shows, no model that was fitted to others
can know it; then one half of every session is predicted by models that were fitted to the other half. Sessions are the better judges, for
noise that wanders is less like itself from one to the next: halves are asked last, and for more.

Skin that is another in a session that was held out may leave more there than a cause gains: then every session is asked once more beside
numbers of its own (see `another_skin`). Where gains or contacts differ from session to session, a channel may be farther off with the
better model than with a worse one by its scale alone. That is another cause, and says nothing of the one that is asked.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.own_shares import regression
from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.baseline.settling import settled
from skin_ident.criticism.gates.another_skin import left_beside_own_skin, of_the_skin
from skin_ident.criticism.gates.gate import CLEAR, Asked, Gain, gain_of_residuals, in_turn, left_by, left_in_held, refitted
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

SCALES = (0.5, 2.0)  # between which a factor is another gain or contact


def all_in_turn(before: Model, after: Model, train: list[Session], held: list[Session], noise: Whitener) -> Iterator[Gain]:
    """What `after` gains over `before` in all sessions: training ones predicted by fits to the others, held-out ones by those to all; then
    the same where each has a skin of its own, unless they press at several places, and have shares of their own."""
    asked = in_turn(before, after, train, noise)
    sessions = [*(s for s, _, _ in asked), *held]
    left = [a + b for a, b in zip(left_by(asked), left_in_held(before, after, train, held, noise), strict=True)]
    yield gain_of_residuals(*left, sessions, noise, "every session in turn")
    if train[0].spread is None and of_the_skin(before, train[0]):
        asked += [(s, before, after) for s in held]
        left = [[left_beside_own_skin(models[i], s, noise) for s, *models in asked] for i in (0, 1)]
        yield gain_of_residuals(*left, sessions, noise, "every session in turn, with a skin of its own")


def halves_in_turn(before: Model, after: Model, train: list[Session], noise: Whitener) -> Gain:
    """What `after` gains over `before` in the later half of every session when fitted to the earlier ones, and the other way round."""
    earlier, later = zip(*(_halves(s) for s in train), strict=True)
    asked = [*_predicting(later, earlier, before, after, noise), *_predicting(earlier, later, before, after, noise)]
    gain = gain_of_residuals(*left_by(asked), [s for s, _, _ in asked], noise, "each half of the sessions in turn")
    return gain if gain.relative > CLEAR else replace(gain, lower=min(gain.lower, 0.0))


def at_any_scale(before: Model, after: Model, train: list[Session], held: list[Session], noise: Whitener) -> Gain:
    """What `after` gains over `before` in held-out sessions where each channel of every session may be off by a factor."""
    asked = [(s, before, after) for s in held] or in_turn(before, after, train, noise)
    left = ([_left_at_any_scale(models[i], s) for s, *models in asked] for i in (0, 1))
    return gain_of_residuals(*left, [s for s, _, _ in asked], noise, f"{', '.join(s.name for s, _, _ in asked)}, at any scale")


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
