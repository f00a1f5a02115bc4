"""Pieces of a record in which one channel does not correspond to the others: bursts, replays, a cable that was touched.

Spikes are seen in the raw signal. A piece that lasts is not, if it looks like any other force. It shows where one channel leaves the fitted
model by far while the others agree with it. A few such pieces would also pass for strong noise, under which every cause would hide.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from skin_ident.criticism.baseline.residual import placed, stiffness
from skin_ident.criticism.sessions.parting import beside_partings, meeting
from skin_ident.criticism.sessions.session import Session, motion_under
from skin_ident.criticism.telemetry.other_units import in_other_units
from skin_ident.criticism.telemetry.peaks import LASTING_S, Piece, clipped_peaks, pieces_in_words, samples_of
from skin_ident.criticism.telemetry.swallowed import is_swallowed
from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_ident.criticism.telemetry.tails import smallest_step
from skin_ident.estimators.scale import normal_scale
from skin_models.model import Model
from skin_models.signals import Motion

FAR, NEAR = 10.0, 5.0  # widths of the residual: beyond the first the channel is far off, beyond the second another one is off, too
MOST, FEW = 0.6, 0.3  # shares of a window's samples: least that are far off in the channel; most that may be off in any other
SHARED = 0.5  # share of a channel's residual that the others have in proportion, above which the skin did it and not the channel
FEWEST, LONG_S = 3, 1.0  # pieces, or a piece of so many s: a single short one may be a touch of another kind
SELDOM = 0.05  # share of the time: what occurs more often is no accident
APART_S = 0.5  # s, pieces nearer than that are one
LONG = 20.0  # samples, memory of noise in which a kick takes long to fade
APART = 10  # lag, samples, at which covariances give it
FADES = 0.02  # greatest share of a kick's energy that an exponential leaves
BRIEF_S, SHARPEST = 0.1, 99.0  # s, a piece so short may be the jolt of a mass, beside accelerations above this percentile
MEETING = 0.5  # share of pieces (or of a piece) that may lie where contact is made or lost, or at a jolt, and the force may really jump


def find_pieces(model: Model, sessions: list[Session], rest: list[np.ndarray]) -> list[Symptom]:
    """Outliers that last, by channel, in the residuals (C, N), N, of `model` at full rate, for sessions with two channels or more. Includes
    pieces in other units and clipped peaks."""
    channels = sessions[0].channels
    if len(channels) < 2:
        return []
    width = _width(sessions, np.concatenate(rest, axis=1))[:, None]
    found = [p for s, e in zip(sessions, rest, strict=True) for p in _pieces(model, s, e, width)]
    whole = sum(float(np.ptp(s.motion.t)) for s in sessions)
    by_channel = [own for c in channels if (own := [p for p in found if p.channel == c])]
    units = {own[0].channel: in_other_units(own, sessions, rest) for own in by_channel}
    rest_of_them = [own for own in by_channel if not units[own[0].channel]]
    lasting = [own for own in rest_of_them if _accident(own, whole)]
    accidents = [own for own in lasting if not (_one_kick(own, sessions, rest) or _swallowed(own, sessions, rest))]
    return [*filter(None, units.values()), *(_told(own, clipped_peaks(own, sessions, rest, width), sessions) for own in accidents)]


def _width(sessions: list[Session], rest: np.ndarray) -> np.ndarray:
    """Noise width (C,), N, of each channel's residual: from its 90 % quantile, contact included, and at least a converter step, or the
    least difference of two readings where too few occur to show the step."""
    steps = [max(s.steps[c] or smallest_step(s.raw[c]) for s in sessions) for c in range(len(rest))]
    return np.maximum(np.percentile(np.abs(rest), 90.0, axis=1) / 1.645, np.maximum(steps, 1e-12))


def _pieces(model: Model, s: Session, rest: np.ndarray, width: np.ndarray) -> Iterator[Piece]:
    """Every piece in which the residual of one channel is large, and that of all others no more than usual (`width` (C, 1), N)."""
    moved = motion_under(s, model.dispersion)
    n = max(round(LASTING_S / moved.dt), 8)
    far, near = (uniform_filter1d((np.abs(rest) > limit * width).astype(float), n, axis=1) for limit in (FAR, NEAR))
    met, jolted = meeting(moved, model.dispersion) | beside_partings(s, model.dispersion), _jolted(moved)
    here = placed(model, s)
    k = np.array([stiffness(here, channel) for channel in s.channels])
    for c, channel in enumerate(s.channels):
        alone = (far[c] >= MOST) & (np.delete(near, c, axis=0).max(axis=0) <= FEW) & (channel not in s.stuck)
        for i, j in _runs(alone, round(APART_S / moved.dt)):
            if _shared(rest[:, i:j], c, width[:, 0], k) > SHARED:
                continue
            size = float(np.sqrt(np.mean(rest[c, i:j] ** 2)))
            hit = channel == "force" and (j - i) * moved.dt < BRIEF_S and jolted[i:j].any()
            yield Piece(s.name, channel, float(moved.t[i]), (j - i) * moved.dt, size, bool(hit or met[i:j].mean() > MEETING))


def _shared(rest: np.ndarray, c: int, width: np.ndarray, k: np.ndarray) -> float:
    """How much of channel `c`'s residual the others share in proportion to their stiffness `k` (C,): 1 where the skin causes it, though
    noise may hide it in each of them; 0 where the channel does. `rest` is (C, n)."""
    others = np.arange(len(k)) != c
    weight = (k / width)[others] ** 2
    alike = (rest[others] @ rest[c]) / np.where(k[others] != 0.0, k[others], np.inf) * k[c]
    return float(weight @ alike) / max(float(weight.sum()) * float(rest[c] @ rest[c]), 1e-300)


def _jolted(moved: Motion) -> np.ndarray:
    """Mask (N,) of samples beside the sharpest accelerations, which only a mass in front of the load cell feels."""
    a = np.abs(np.gradient(moved.v))
    return maximum_filter1d(a > np.percentile(a, SHARPEST), 2 * round(BRIEF_S / moved.dt) + 1)


def _runs(mask: np.ndarray, gap: int) -> Iterator[tuple[int, int]]:
    """First and last (excluded) index of every run; runs less than `gap` apart are joined."""
    at = np.flatnonzero(mask)
    for run in np.split(at, np.flatnonzero(np.diff(at) > gap) + 1):
        if run.size:
            yield int(run[0]), int(run[-1]) + 1


def _accident(own: list[Piece], whole: float) -> bool:
    enough = len(own) >= FEWEST or max(p.seconds for p in own) >= LONG_S
    return enough and sum(p.seconds for p in own) < SELDOM * whole and np.mean([p.met for p in own]) <= MEETING


def _swallowed(own: list[Piece], sessions: list[Session], rest: list[np.ndarray]) -> bool:
    """Whether the channel reads nothing in the pieces because it has a threshold."""
    c = sessions[0].channels.index(own[0].channel)
    return is_swallowed([s.raw[c] for s in sessions], [e[c] for e in rest], [samples_of(own, s) for s in sessions])


def _one_kick(own: list[Piece], sessions: list[Session], rest: list[np.ndarray]) -> bool:
    """Whether a single piece is one kick that fades as the channel's noise does: noise of long memory and heavy tails."""
    if len(own) > 1:
        return False
    piece, c = own[0], sessions[0].channels.index(own[0].channel)
    memory = _memory([e[c] for s, e in zip(sessions, rest, strict=True) if s.name != piece.session])
    session, e = next((s, e[c]) for s, e in zip(sessions, rest, strict=True) if s.name == piece.session)
    inside = e[samples_of(own, session)]
    fading = inside[int(np.argmax(np.abs(inside))) :]
    k = np.arange(fading.size)
    shapes = [np.exp(-k / (times * memory)) for times in (0.3, 0.5, 1.0, 2.0, 3.0)] if memory > LONG else []
    left = [np.sum((fading - (shape @ fading) / (shape @ shape) * shape) ** 2) for shape in shapes]
    return 2 * fading.size > inside.size and min(left, default=np.inf) < FADES * float(fading @ fading)


def _memory(rows: list[np.ndarray]) -> float:
    """Samples in which noise without jumps fades to 1 / e, from covariances at lags at which the converter's own noise is gone."""
    y = np.concatenate(rows or [np.zeros(1)])
    y = np.clip(y, *(np.array([-3.0, 3.0]) * normal_scale(y)))
    near, far = (float(y[:-lag] @ y[lag:]) if y.size > lag else 0.0 for lag in (APART, 2 * APART))
    return APART / max(-np.log(far / near), 1e-3) if near > 0.0 and far > 0.0 else 0.0


def _told(own: list[Piece], clipped: Symptom | None, sessions: list[Session]) -> Symptom:
    """The pieces as outliers, or as clipped peaks if they look like it. If they are only one or two, both are reported as alternatives."""
    if clipped is None or len(own) >= FEWEST:
        return clipped or _symptom(own, sessions)
    return replace(_symptom(own, sessions), alternatives=((clipped.cause, clipped.where),), apart=clipped.apart)


def _symptom(own: list[Piece], sessions: list[Session]) -> Symptom:
    first = own[0]
    why = f"{first.channel} differs from the model by {first.size:.3g} N while every other channel agrees with it: {pieces_in_words(own)}"
    parameters = {"pieces": quantity(len(own), "1"), "size": quantity(max(p.size for p in own), "N")}
    evidence = {"why": why, "pieces": [{"session": p.session, "start": p.start, "seconds": float(p.seconds)} for p in own]}
    bad = {(s.name, first.channel): samples_of(own, s) for s in sessions if any(p.session == s.name for p in own)}
    return Symptom("outliers", sensor_of(first.channel, sessions[0].n_taxels), (first.channel,), parameters, evidence, bad)
