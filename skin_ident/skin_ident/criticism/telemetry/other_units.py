"""Pieces of a record in which one channel is written in other units: there it follows what the model says, times a factor that only units
have. No accident does that, so that neither their number nor how long they last speaks against it."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.telemetry.peaks import Piece, pieces_in_words, samples_of
from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_ident.criticism.telemetry.units import FACTORS
from skin_ident.criticism.vocabulary import UNIT_CHANGE
from skin_ident.stretches import runs

NEAR = 0.06  # relative, how close the factor of every piece must come to one of units
EVEN_S = 1.0  # over which most samples tell which unit they are written in
FOLLOWS = 0.3  # of a piece, and of what is left of it, the most that the factor may leave


def in_other_units(own: list[Piece], sessions: list[Session], rest: list[np.ndarray]) -> Symptom | None:
    """The fault of a channel's pieces, by what a model leaves (C, N) N of sessions, where all show one and the same factor of units."""
    c = sessions[0].channels.index(own[0].channel)
    told = {s.name: (s, s.raw[c], s.raw[c] - e[c]) for s, e in zip(sessions, rest, strict=True)}
    outside = [np.array([y, model])[:, ~samples_of(own, s)] for s, y, model in told.values()]
    usual = slope(*np.concatenate(outside, axis=1))  # the model was fitted to the pieces, too
    if usual == 0.0:  # a taxel that feels nothing follows nothing, in whatever units
        return None
    factors = [_times(*told[p.session], p) / usual for p in own]
    factor = next((f for f in FACTORS if all(abs(found / f - 1.0) < NEAR for found in factors)), None)
    if factor is None:
        return None
    own = [whole for s, y, model in told.values() for whole in _whole(own, s, y, usual * model, factor)]
    if not own:  # pieces too short for most samples about them to tell
        return None
    times = f"{own[0].channel} reads {factor:.4g} times what it should, a factor of units"
    why = f"{times}, while every other channel stays with the model: {pieces_in_words(own)}"
    evidence, numbers = {"why": why, "kind": UNIT_CHANGE}, {"factor": quantity(factor, "1")}
    bad = {(s.name, own[0].channel): mask for s in sessions if (mask := samples_of(own, s)).any()}
    return Symptom("data_error", sensor_of(own[0].channel, sessions[0].n_taxels), (own[0].channel,), numbers, evidence, bad)


def _times(s: Session, y: np.ndarray, model: np.ndarray, piece: Piece) -> float:
    """Times what the `model` says (N,) N the channel reads in a piece, `y` (N,) N; not a number where it does not follow that: what reads
    nothing is near any small part of it."""
    inside = (s.motion.t >= piece.start) & (s.motion.t < piece.start + piece.seconds)
    y, model = y[inside], model[inside]
    times, off = slope(y, model), y - model
    left = y - times * model
    return times if float(left @ left) < FOLLOWS**2 * float(min(off @ off, y @ y)) else np.nan


def _whole(own: list[Piece], s: Session, y: np.ndarray, model: np.ndarray, factor: float) -> Iterator[Piece]:
    """The stretches of a session in which `y` (N,) is nearer to the model times the factor than to the model, where pieces of it are."""
    nearer = np.abs(y - factor * model) < np.abs(y - model)
    own = [p for p in own if p.session == s.name]
    mask = uniform_filter1d(nearer.astype(float), max(round(EVEN_S / s.motion.dt), 1)) > 0.5
    for i, j in zip(*runs(mask), strict=True):
        start, seconds = float(s.motion.t[i]), (j - i) * s.motion.dt
        if any(start < p.start + p.seconds and p.start < start + seconds for p in own):
            yield replace(own[0], start=start, seconds=seconds)


def slope(y: np.ndarray, model: np.ndarray) -> float:
    """Times what the `model` says (N,) that `y` (N,) reads, by least squares."""
    return float(model @ y) / max(float(model @ model), 1e-300)
