"""The gate: a cause is accepted when it improves the prediction of sessions that were not used to fit it.

The held-out sessions are cut into blocks that are long compared with the memory of the noise. The whitened squared errors of these blocks,
before and after, are resampled block by block (B. Efron, R. Tibshirani, An Introduction to the Bootstrap, 1993, ch. 8). Without sessions to
hold out, each training session is held out in turn, and both models are fitted to the others.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.baseline.settling import settled
from skin_ident.criticism.baseline.unknowns import with_values
from skin_ident.criticism.gates.another_skin import left_beside_own_skin
from skin_ident.criticism.gates.uncertain import beside_uncertainty
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.session import Session, without
from skin_models.model import Model
from skin_models.parameter import AMPLITUDE

EACH_IN_TURN = "each session in turn"  # what was held out, where no session was kept aside; readers of findings.json know it by this
BLOCK_S = 2.0  # s of residual that are resampled as a whole: longer than the memory of the noise
FEWEST_BLOCKS = 3  # least number of blocks in a session; a short session has shorter blocks
RESAMPLES = 1000  # bootstrap draws of all blocks
# Fall of the whitened held-out mean square below which an effect is not worth naming, if at least half of the channels carry it.
MATERIAL_FALL = 0.01
# Falls of the same: above MUCH_FALL the plain error need not fall beyond doubt; above CLEAR_FALL half of its usual fall is enough.
MUCH_FALL, CLEAR_FALL = 0.25, 0.06
MOST, NOTHING = 0.5, -0.02  # above a fall of MOST its lower bound need only exceed NOTHING, since most of the fall may lie in one block
MATERIAL_RMSE = 0.04  # least relative fall of the RMSE in the channel that gains most: that of an effect a quarter as large as the noise
HEARD, LOUD = 0.28, 0.35  # size of a change over the residual of a channel (RMS): such changes lower its error by 4 and 6 % at most
SPOILT = 1.25  # factor by which no cause may raise the error of a channel
CARRIES = 0.02  # relative fall of its RMSE from which a channel is said to carry the effect
FOLD_ITERATIONS = 4  # iterations of a fit that begins at the fit to all sessions

Asked = tuple[Session, Model, Model]  # a session, and the models before and after that are to predict it
Residuals = tuple[list[np.ndarray], list[np.ndarray]]  # (C, n) N of each session, before and after


@dataclass(frozen=True)
class Gain:
    """The gain of a cause on held-out data. `before` and `after` are the plain held-out RMSE, N, in `channel`, the one that gained most;
    `ci95` bounds its fall there.

    `carried` are the channels whose error fell. `quicker` are those in which the quick part of the error fell (differences between
    neighbouring samples). `spoilt` are those whose error rose by much. `relative` is the fall of the whitened mean square over all
    channels, and `lower` its lower 99 % bound: these are the gate itself. `breadth` lowers the gate where few channels carry the effect.
    `held_out` names what was held out.
    """

    channel: str
    carried: tuple[str, ...]
    before: float
    after: float
    ci95: tuple[float, float]
    relative: float
    lower: float
    held_out: str
    spoilt: tuple[str, ...] = ()
    quicker: tuple[str, ...] = ()
    breadth: float = 1.0  # twice the share of channels that carry it, at most 1: the others dilute what few of them gain

    @property
    def passed(self) -> bool:
        """Whether the gain passes the gate: the likelihood is better beyond doubt and by enough to matter, the plain error falls too, and
        no channel gets clearly worse. Where the likelihood gains little, the plain error must fall beyond doubt, and by more."""
        plain = self.relative > MUCH_FALL  # slow noise dominates the plain error, which therefore says little against a quick effect
        falls = self.ci95[0] > 0.0
        least = NOTHING if self.relative > MOST and falls else 0.0
        sure = self.lower > least and (plain or falls)
        material = MATERIAL_RMSE / 2.0 if plain or self.relative > CLEAR_FALL else MATERIAL_RMSE
        return sure and not self.spoilt and self.relative > MATERIAL_FALL * self.breadth and self.after < (1.0 - material) * self.before

    @property
    def is_against(self) -> bool:
        """Whether held-out data speak against the cause: the likelihood is no better, and the plain error does not fall beyond doubt. Where
        the skin is another, its errors are as slow as noise may be, and then the plain error says more than the likelihood."""
        falls = self.ci95[0] > 0.0 and self.after < (1.0 - MATERIAL_RMSE) * self.before
        return self.relative <= 0.0 and not falls

    def shows_at(self, where: str) -> bool:
        """Whether a sensor's fault shows in that sensor's own channels, and not only in what the rest of the model does beside it. Where
        another cause leaves a slow error there, it is enough that the quick part of the error falls."""
        shown = (*self.carried, *self.quicker)
        return any(c in shown for c in own_channels(where, shown))

    @property
    def entry(self) -> dict[str, Any]:
        """The gain as findings.json writes it."""
        errors = {"held_out_rmse_before": self.before, "held_out_rmse_after": self.after, "ci95": list(self.ci95)}
        return {**errors, "channel": self.channel, "unit": "N"}

    @property
    def squares(self) -> float:
        """Fall of the plain mean square error in `channel`, N^2."""
        return self.before**2 - self.after**2


def deaf(before: Model, after: Model, train: list[Session], held: list[Session], where: str) -> bool:
    """Whether `held` cannot test a cause: what `after` changes there is too small to pass the gate even if it is true, while it is large in
    `train`. For a sensor's fault only its own channels count."""
    own = [i for i, c in enumerate(train[0].channels) if c in own_channels(where, train[0].channels)]
    return len(train) > 1 and _loudness_of_change(before, after, held, own) < HEARD < LOUD < _loudness_of_change(before, after, train, own)


def own_channels(where: str, channels: tuple[str, ...]) -> tuple[str, ...]:
    """Those of `channels` that show a fault at a place: the sensor's own, those on that clock, or all."""
    taxels = tuple(c for c in channels if c.startswith("taxel"))
    own = {"load_cell": ("force",), "taxel": taxels, "clock": ("force",), "clock_taxels": taxels}
    return own.get(where, (where,) if where.startswith("taxel_") else channels)


def _loudness_of_change(before: Model, after: Model, sessions: list[Session], own: list[int]) -> float:
    """Change from `before` to `after` over the residual of `before` (RMS), in that of the channels `own` where this ratio is largest."""
    e = [residual(before, s) for s in sessions]
    left, changed = (
        sum((rows**2 * s.weight).sum(axis=1) for rows, s in zip(each, sessions, strict=True))
        for each in (e, [residual(after, settled(after, s)) - row for s, row in zip(sessions, e, strict=True)])
    )
    return float(np.sqrt(np.max((changed / np.maximum(left, 1e-300))[own], initial=0.0)))


def held_out_gain(
    before: Model, after: Model, train: list[Session], held: list[Session], noise: Whitener, refit_before: Callable = fit
) -> Gain:
    """Gain of `after` over `before` on `held`; where `held` is empty, each training session is held out in turn.

    `refit_before` fits `before` to the remaining sessions, for a model in which not everything may change that `fit` would change.
    """
    if held:
        return gain_of_residuals(*left_in_held(before, after, train, held, noise), held, noise, ", ".join(s.name for s in held))
    pairs = in_turn(before, after, train, noise, refit_before)
    said = EACH_IN_TURN if len(train) > 1 else "nothing: the only session was used to fit"
    return gain_of_residuals(*left_by(pairs, noise), [s for s, _, _ in pairs], noise, said)


def left_in_held(before: Model, after: Model, train: list[Session], held: list[Session], noise: Whitener) -> Residuals:
    """Residuals in the `held` sessions of both models, fitted to `train`, less what training leaves undetermined."""
    return tuple(beside_uncertainty([_left(m, s, noise) for s in held], m, train, held, noise) for m in (before, after))


def in_turn(before: Model, after: Model, train: list[Session], noise: Whitener, refit_before: Callable = fit) -> list[Asked]:
    """Every training session, with both models fitted to the others; the only one with both as they are."""
    if len(train) == 1:
        return [(train[0], before, after)]
    return [(s, *refitted(before, after, rest, noise, refit_before)) for rest, s in (without(train, s) for s in train)]


def refitted(before: Model, after: Model, sessions: list[Session], noise: Whitener, refit_before: Callable = fit) -> tuple[Model, Model]:
    """Both models fitted to `sessions`. Amplitudes of `after` that these do not feel at all, such as that of a step after their end, become
    zero."""
    found = fit(after, sessions, noise, FOLD_ITERATIONS)
    unfelt = tuple(u for u in found.unknowns if isinstance(u.part, int) and u.parameter.role == AMPLITUDE and found.std[u.label] == 0.0)
    return refit_before(before, sessions, noise, FOLD_ITERATIONS).model, with_values(found.model, unfelt, np.zeros(len(unfelt)))


def left_by(asked: list[Asked], noise: Whitener) -> Residuals:
    """Residuals of both models in the session that they are to predict."""
    return tuple([_left(pair[i], pair[0], noise) for pair in asked] for i in (1, 2))


def _left(model: Model, s: Session, noise: Whitener) -> np.ndarray:
    """Residual (C, n) N of a session. Where it has skin parameters of its own, these are estimated anew: those that were found beside one
    model would speak against any other."""
    return left_beside_own_skin(model, s, noise) if s.skin else residual(model, settled(model, s))


def bootstrap_fall(before: list[np.ndarray], after: list[np.ndarray], sessions: list[Session]) -> tuple[float, float]:
    """Relative fall of the mean square of whitened residuals [(C, n), …], and its lower 99 % bound by resampling blocks."""
    sums = [np.concatenate([by_block((e**2).sum(axis=0), s) for e, s in zip(es, sessions, strict=True)]) for es in (before, after)]
    draws = _draws(sums[0].size)
    falls = 1.0 - sums[1][draws].sum(axis=1) / np.maximum(sums[0][draws].sum(axis=1), 1e-300)
    return float(1.0 - sums[1].sum() / max(sums[0].sum(), 1e-300)), float(np.percentile(falls, 1.0))


def rmse_fall(before: list[np.ndarray], after: list[np.ndarray], sessions: list[Session]) -> tuple[np.ndarray, np.ndarray]:
    """RMSE (2, C) before and after, N, and its bootstrap draws (2, C, RESAMPLES), from plain residuals [(C, n), …]."""

    def sums(es: list[np.ndarray]) -> np.ndarray:
        return np.concatenate([by_block(e**2 * s.weight, s) for e, s in zip(es, sessions, strict=True)], axis=-1)

    squares = np.array([sums(before), sums(after)])
    counts = np.concatenate([by_block(s.weight, s) for s in sessions], axis=-1)
    draws = _draws(counts.shape[-1])
    drawn = squares[:, :, draws].sum(axis=-1) / np.maximum(counts[:, draws].sum(axis=-1), 1e-300)
    return np.sqrt(squares.sum(axis=-1) / np.maximum(counts.sum(axis=-1), 1e-300)), np.sqrt(drawn)


def gain_of_residuals(before: list[np.ndarray], after: list[np.ndarray], sessions: list[Session], noise: Whitener, said: str) -> Gain:
    """The gain from residuals [(C, n), …] N of `sessions`, before and after; `said` names what was held out."""
    white = [[noise.apply(e, s) for e, s in zip(es, sessions, strict=True)] for es in (before, after)]
    total, lower = bootstrap_fall(*white, sessions)
    rms, drawn = rmse_fall(before, after, sessions)
    c = int(np.argmax((rms[0] - rms[1]) / np.maximum(rms[0], 1e-300)))
    low, high = np.percentile(drawn[0, c] - drawn[1, c], [2.5, 97.5])
    channels, channel = sessions[0].channels, sessions[0].channels[c]
    carried, quicker = (_fallen(channels, *fall) for fall in (rms, [_quick(es, sessions) for es in (before, after)]))
    spoilt = tuple(name for name, b, a in zip(channels, *rms, strict=True) if a > SPOILT * b)
    carried = carried or (channel,)
    errors = float(rms[0, c]), float(rms[1, c]), (float(low), float(high))
    return Gain(channel, carried, *errors, total, lower, said, spoilt, quicker, breadth_of(len(carried), len(channels)))


def _fallen(channels: tuple[str, ...], before: np.ndarray, after: np.ndarray) -> tuple[str, ...]:
    """The channels whose RMS error (C,) fell by more than `CARRIES` from before to after."""
    return tuple(name for name, b, a in zip(channels, before, after, strict=True) if b - a > CARRIES * b)


def _quick(es: list[np.ndarray], sessions: list[Session]) -> np.ndarray:
    """RMS (C,) of the differences between neighbouring samples of residuals [(C, n), …]."""
    both = [s.weight[:, 1:] * s.weight[:, :-1] for s in sessions]
    squares = sum((np.diff(e, axis=1) ** 2 * w).sum(axis=1) for e, w in zip(es, both, strict=True))
    return np.sqrt(squares / np.maximum(sum(w.sum(axis=1) for w in both), 1.0))


def breadth_of(carried: int, channels: int) -> float:
    """`Gain.breadth` of an effect that so many of the channels carry."""
    return min(2.0 * carried / channels, 1.0)


def _draws(blocks: int) -> np.ndarray:
    return np.random.default_rng(0).integers(0, blocks, (RESAMPLES, blocks))


def by_block(rows: np.ndarray, s: Session) -> np.ndarray:
    """Sums over consecutive blocks of a session along the last axis; the blocks hold equally many samples, but for one."""
    count = rows.shape[-1]
    size = max(min(int(BLOCK_S / s.band.spacing), count // FEWEST_BLOCKS), 1)
    begins = np.linspace(0, count, max(count // size, 1), endpoint=False).astype(int)
    return np.add.reduceat(rows, begins, axis=-1) if count else rows
