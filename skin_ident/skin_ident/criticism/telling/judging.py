"""The final gains: faults of the record put into the extended model, and the gain of every channel.

The search leaves out clipped samples and silent taxels, so that they bend nothing. Here they come back. The baseline is fitted to the whole
record, as by someone who had not looked for faults; the extended model is that of the search with the faults added as effects. The
difference between the parameters of the two baselines shows in which parameters the faults had been hiding.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skin_ident.criticism.baseline.comparing import comparable
from skin_ident.criticism.baseline.fitting import ITERATIONS, Fit, fit
from skin_ident.criticism.baseline.residual import residual, rmse
from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.gates.gate import EACH_IN_TURN, FOLD_ITERATIONS, rmse_fall
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.search.named import Criticism
from skin_ident.criticism.sessions.session import Session, silenced, with_reference
from skin_ident.criticism.telemetry.faults import PREDICTS, effect_of, effects_of, with_effects
from skin_ident.criticism.telemetry.symptom import Symptom
from skin_models.model import Model

MOST_FOLDS = 5  # folds of the cross-validation, at most


@dataclass(frozen=True)
class Judged:
    """The criticism with the faults added, the gain of each symptom's effect (entries of findings.json; {} where it predicts nothing), and
    the gain of the extended model by channel."""

    criticism: Criticism
    symptoms: tuple[dict[str, Any], ...]
    channels: dict[str, dict[str, Any]]
    clean: Model  # the baseline fitted without the faulty samples


def judge(c: Criticism, symptoms: tuple[Symptom, ...], whole: tuple[list[Session], list[Session]], given: Model | None) -> Judged:
    """Add the faults to `c` and compute all gains. `whole` are training and held-out sessions with every sample, in the order of `c.train`
    and `c.held`."""
    clean = c.baseline.model
    compared = [s for s in symptoms if set(s.channels) <= set(c.train[0].channels)]  # without faults of a force that drives the test
    compared = [s for s in compared if s.cause != "dead_taxel" or not _reads_nothing(s.channels[0], whole[0])]  # no share says as much
    if effects := [e for e in effects_of(compared) if e.cause in PREDICTS]:
        c = _carrying(c, effects, whole, given)
    tested = list(c.held or c.train)
    gains = tuple(_gain_of(c.extended.model, s, tested) for s in symptoms)
    return Judged(c, gains, _by_channel(c, given is not None), clean)


def _carrying(c: Criticism, effects: list, whole: tuple[list[Session], list[Session]], given: Model | None) -> Criticism:
    """The criticism with `effects` of faults in its models, and a baseline fitted to all samples of the channels that answer: silent ones
    had no noise by which others could be weighed against them."""
    plain, model = c.baseline.model, c.extended.model
    start = given or replace(dispersion_start(whole[0], plain.dispersion.m), effects=plain.effects)
    silent = {channel: 0.0 for channel in c.train[0].stuck if _reads_nothing(channel, whole[0])}
    both = [
        [replace(c.as_before(s, own), stuck=silent) for s, own in zip(*pair, strict=True)]
        for pair in zip(comparable(*whole, start, model), (c.train, c.held), strict=True)
    ]
    baseline = fit(start, [silenced(s, c.train[0].stuck) for s in both[0]], c.last.noise, 0 if given else ITERATIONS)
    train, held = ([s.with_own_of(own) for s, own in zip(*pair, strict=True)] for pair in zip(both, (c.train, c.held), strict=True))
    model = with_effects(model, effects)
    for e in (e for e in effects if e.cause == "quantization"):
        model = _better(model.without(e), model, train)
    last = replace(c.last, model=with_effects(c.last.model, [e for e in effects if e in model.effects]), kept={})
    return replace(c, baseline=baseline, extended=replace(c.extended, model=model), last=last, train=tuple(train), held=tuple(held))


def _reads_nothing(channel: str, sessions: list[Session]) -> bool:
    """Whether a channel holds nothing but zeros in all sessions. Without a share of the force it then leaves no residual, hence no noise
    level by which other channels could be weighed against it."""
    return not any(s.raw[s.channels.index(channel)].any() for s in sessions)


def _better(one: Model, other: Model, sessions: list[Session]) -> Model:
    """The model with the smaller squared residual over the sessions."""
    of_one, of_other = (sum(float(np.sum(residual(m, s) ** 2 * s.weight)) for s in sessions) for m in (one, other))
    return one if of_one <= of_other else other


def _gain_of(model: Model, symptom: Symptom, sessions: list[Session]) -> dict[str, Any]:
    """The gain of one symptom's effect: the extended model without it and with it."""
    mine = next((e for e in model.effects if e == effect_of(symptom)), None)
    if mine is None:
        return {}
    without = model.without(mine)
    before, after = ([residual(m, s) for s in sessions] for m in (without, model))
    return _entries(before, after, sessions)[symptom.channels[0]]


def _by_channel(c: Criticism, given: bool) -> dict[str, dict[str, Any]]:
    """RMSE of baseline and extended model by channel, on data to which neither was fitted, with the confidence interval of the fall."""
    said, pairs = _tested(c, given)
    entries = _entries([b for _, b, _ in pairs], [a for _, _, a in pairs], [s for s, _, _ in pairs])
    return {channel: {**entry, "tested_on": said} for channel, entry in entries.items()}


def _tested(c: Criticism, given: bool) -> tuple[str, list[tuple[Session, np.ndarray, np.ndarray]]]:
    """The name of the test data, and for each of its sessions the residuals of baseline and extended model."""
    if c.held:
        return ", ".join(s.name for s in c.held), [_pair(c, c.baseline.model, c.extended.model, s) for s in c.held]
    if len(c.train) == 1 or c.baseline.model == c.extended.model:
        return "the sessions it was fitted to", [_pair(c, c.baseline.model, c.extended.model, s) for s in c.train]
    return EACH_IN_TURN, [pair for fold in _folds(len(c.train)) for pair in _fold(c, fold, given)]


def _folds(count: int) -> Iterator[list[int]]:
    every = np.arange(count)
    yield from (list(every[every % min(count, MOST_FOLDS) == k]) for k in range(min(count, MOST_FOLDS)))


def _fold(c: Criticism, fold: list[int], given: bool) -> Iterator[tuple[Session, np.ndarray, np.ndarray]]:
    """Both models fitted to the sessions outside the fold, and their residuals in the fold."""
    rest = [i for i in range(len(c.train)) if i not in fold]
    others = with_reference([c.train[i] for i in rest])
    before = c.baseline.model if given else _refitted(c.baseline, [c.before(s) for s in others], c.last.noise)
    after = _refitted(c.extended, others, c.last.noise)
    yield from (_pair(c, before, after, replace(c.train[i], reference=None)) for i in fold)


def _refitted(known: Fit, sessions: list[Session], noise: Whitener) -> Model:
    """The model fitted to other sessions, in the noise that the search found. In the noise of its own residual a model that lacks something
    would take most of its error for noise that wanders, and fit the rest."""
    return fit(known.model, sessions, noise, FOLD_ITERATIONS, known.unknowns).model


def _pair(c: Criticism, before: Model, after: Model, own: Session) -> tuple[Session, np.ndarray, np.ndarray]:
    return own, residual(before, c.before(own)), residual(after, own)


def _entries(before: list[np.ndarray], after: list[np.ndarray], sessions: list[Session]) -> dict[str, dict[str, Any]]:
    """By channel: RMSE over all samples, `before` and `after`, and a 95 % interval of the fall by block bootstrap."""
    errors = [rmse(es, sessions) for es in (before, after)]
    _, drawn = rmse_fall(before, after, sessions)
    bounds = np.percentile(drawn[0] - drawn[1], [2.5, 97.5], axis=-1).T
    return {
        channel: {
            "held_out_rmse_before": errors[0][channel],
            "held_out_rmse_after": errors[1][channel],
            "ci95": [float(low), float(high)],
            "channel": channel,
            "unit": "N",
        }
        for channel, (low, high) in zip(sessions[0].channels, bounds, strict=True)
    }
