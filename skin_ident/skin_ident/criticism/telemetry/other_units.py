"""Pieces of a record in which one channel is written in other units: there it follows the model times a factor that only units have. No
accident does that, so neither the number of pieces nor their length is evidence against it."""

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

NEAR = 0.06  # relative deviation of every piece's factor from one of units
EVEN_S = 1.0  # s, window in which the majority of samples shows the unit
FOLLOWS = 0.3  # greatest ratio of the rms that the factor leaves to the rms of the piece, and to that of its residual


def in_other_units(own: list[Piece], sessions: list[Session], rest: list[np.ndarray]) -> Symptom | None:
    """A symptom for one channel's pieces, from the residuals (C, N), N, of sessions, if all pieces show the same factor of units; else
    None."""
    c = sessions[0].channels.index(own[0].channel)
    told = {s.name: (s, s.raw[c], s.raw[c] - e[c]) for s, e in zip(sessions, rest, strict=True)}
    outside = [np.array([y, model])[:, ~samples_of(own, s)] for s, y, model in told.values()]
    usual = slope(*np.concatenate(outside, axis=1))  # the model's own scale may be off: it was fitted to the pieces, too
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
    why = f"{times}, while every other channel agrees with the model: {pieces_in_words(own)}"
    evidence, numbers = {"why": why, "kind": UNIT_CHANGE}, {"factor": quantity(factor, "1")}
    bad = {(s.name, own[0].channel): mask for s in sessions if (mask := samples_of(own, s)).any()}
    return Symptom("data_error", sensor_of(own[0].channel, sessions[0].n_taxels), (own[0].channel,), numbers, evidence, bad)


def _times(s: Session, y: np.ndarray, model: np.ndarray, piece: Piece) -> float:
    """The factor by which the channel's readings `y` (N,), N, exceed the `model` (N,), N, in a piece. NaN where they do not follow it: a
    reading of zero would be near any small multiple of it."""
    inside = (s.motion.t >= piece.start) & (s.motion.t < piece.start + piece.seconds)
    y, model = y[inside], model[inside]
    times, off = slope(y, model), y - model
    left = y - times * model
    return times if float(left @ left) < FOLLOWS**2 * float(min(off @ off, y @ y)) else np.nan


def _whole(own: list[Piece], s: Session, y: np.ndarray, model: np.ndarray, factor: float) -> Iterator[Piece]:
    """The stretches of a session in which `y` (N,) is nearer to the model times the factor than to the model, and which overlap one of its
    pieces."""
    nearer = np.abs(y - factor * model) < np.abs(y - model)
    own = [p for p in own if p.session == s.name]
    mask = uniform_filter1d(nearer.astype(float), max(round(EVEN_S / s.motion.dt), 1)) > 0.5
    for i, j in zip(*runs(mask), strict=True):
        start, seconds = float(s.motion.t[i]), (j - i) * s.motion.dt
        if any(start < p.start + p.seconds and p.start < start + seconds for p in own):
            yield replace(own[0], start=start, seconds=seconds)


def slope(y: np.ndarray, model: np.ndarray) -> float:
    """Least-squares factor of `y` (N,) on the `model` (N,)."""
    return float(model @ y) / max(float(model @ model), 1e-300)
