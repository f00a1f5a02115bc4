"""Adhesion: the skin pulls at the plunger as it leaves.

Moments at which the plunger leaves the skin say little about the rest of a model and are not compared. One thing they do show: without
adhesion no contact pulls, however the skin recovers. A pull is a reading that falls, at one leaving after the other, below the reading in
air by more than the moving skin weighs, and below the model. There is one exception for the model itself. Its equations are often simulated
for x > 0 as they stand, so that skin follows any plunger and its dashpots pull. Where that explains the leavings better than adhesion, only
the simulation's contact differs, and nothing is wrong with the skin.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import minimum_filter1d

from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.sessions.session import Session, motion_under
from skin_ident.criticism.telemetry.faults import UNLIKE, effect_of
from skin_ident.criticism.telemetry.symptom import Symptom, quantity
from skin_ident.estimators.scale import normal_scale
from skin_models.model import Model
from skin_models.signals import Motion

BEFORE_S, AFTER_S = 0.25, 0.4  # s before and after the moment when the model says that the plunger leaves
OUT, SLOWLY_S = 0.15e-3, 2.0  # m, or s, to which the plunger is followed if it leaves more slowly
NEAR_S = 8.0  # s of air around it that give the sensor's zero
CLEAR = 2.5  # noise widths of a pull at most leavings: of the residual, or hardly more than of the reading in air
AIR, LEAST_AIR = 1.5, 50  # times the width in air, if so many samples are in air: an encoder's noise does not show there
CHANCE = 0.25  # chance that a reading in air falls as far at one leaving
AGREE = 0.6  # share of the leavings that must show it, over all sessions
FEWEST = 4  # leavings that a verdict needs
SHOWN = 0.3  # share of a model's pull, or of the pull found, that readings must fall by at least
REACHES = (0.05e-3, 0.1e-3, 0.2e-3, 0.4e-3, 0.8e-3)  # m, candidates for the reach of adhesion
SMOOTH, SMOOTH_S = 3, 0.01  # samples, and s, that a pull must last: of many samples some are low by chance
IN = 0.3  # share of the greatest speed in air from which the plunger is on its way in


@dataclass(frozen=True)
class Leaving:
    """One leaving. `together` (C, C) N (negative): how far each channel (second index) falls below air and model where the channel of the
    first index is lowest. `depth`, m: where the first channel is lowest. `in_air` (C,) N: the level above which the lowest of as many
    samples in the air around stays three times in four."""

    together: np.ndarray
    depth: float
    in_air: np.ndarray

    @property
    def dips(self) -> np.ndarray:
        """How far each channel falls at its lowest, (C,), N."""
        return np.diag(self.together)


def find_pull(model: Model, sessions: list[Session]) -> list[Symptom]:
    """A pull on release, from the measurement (`raw`) at every leaving, against `model` and the air around."""
    if any(s.drive is not None for s in sessions) or any(e.cause == "adhesion" for e in model.effects):
        return []
    rest = [s.raw - simulated(model, s) for s in sessions]
    leavings = _all_leavings(model, sessions, rest)
    if len(leavings) < FEWEST:
        return []
    width = _width(model, sessions, rest)
    dips = np.array([one.dips for one in leavings])
    pulled = (dips < -CLEAR * width) & (dips < np.array([one.in_air for one in leavings]))
    carried = _agreed(pulled)
    if carried.size == 0:
        return []
    shown = pulled[:, carried].any(axis=1)
    if sessions[0].channels[0] == "force" and carried[0] != 0:  # the load cell feels it, too, but noise may hide it
        beside = np.array([one.together[carried[0], 0] for one in leavings])
        if np.mean(beside[shown]) > -CLEAR * width[0] / np.sqrt(np.count_nonzero(shown)):
            return []
        carried, dips[:, 0] = np.append(0, carried), beside
    depths = [one.depth for one, yes in zip(leavings, shown, strict=True) if yes]
    found = _symptom(model, sessions[0], dips[shown], carried, depths, len(leavings))
    found, least = _as_simulated(found, model, sessions, rest)
    clear = np.minimum(-CLEAR * width, SHOWN * np.median(dips[shown], axis=0))
    return [] if _follows(model, sessions, clear, least) else [found]


def _width(model: Model, sessions: list[Session], rest: list[np.ndarray]) -> np.ndarray:
    """Noise width (C,), N, of the readings at a leaving: that of the residual `rest`, or little more than that in air, spikes included, if
    that is less; at least a converter step."""
    widths = normal_scale(np.concatenate(rest, axis=1), axis=1)
    air = [s.raw[:, _parted(model, s)[2]] for s in sessions]
    air = np.concatenate([rows - np.mean(rows, axis=1, keepdims=True) for rows in air if rows.size] or air, axis=1)
    if air.shape[1] >= LEAST_AIR:
        widths = np.minimum(widths, AIR * np.std(air, axis=1))
    return np.maximum(widths, np.max([s.steps for s in sessions], axis=0))


def _parted(model: Model, s: Session) -> tuple[Motion, np.ndarray, np.ndarray]:
    """The motion of a session, and masks (N,) of where the model has contact, and of where the plunger is in air."""
    moved = motion_under(s, model.dispersion)
    touched = model.dispersion.contact(moved)
    return moved, touched, ~touched & (moved.x < 0.0)


def is_pulled(pulling: Model, without: Model, sessions: list[Session]) -> bool:
    """Whether the first channel falls at leavings at least `SHOWN` times as far as the model `pulling` says, both compared with the same
    model `without` the pull. True where too few leavings show it."""
    if any(s.drive is not None for s in sessions):
        return True

    def lowest(s: Session) -> list[float]:
        return [float(one.dips[0]) for one in _leavings(without, s, s.raw - simulated(without, s))]

    read = [dip for s in sessions for dip in lowest(s)]
    said = [dip for s in sessions for dip in lowest(replace(s, raw=simulated(pulling, s)))]
    return len(read) < FEWEST or bool(np.median(read) <= SHOWN * np.median(said))


def _follows(model: Model, sessions: list[Session], clear: np.ndarray, least: float) -> bool:
    """Whether skin that follows the plunger wherever it is at positive depth, and pulls as it does, explains the data: its sum of squares
    is no larger than `least`, the smallest of any pull, and no channel still falls below `clear` (C,) at a share `AGREE` of the
    leavings."""
    rest = [s.raw - simulated(model, replace(s, motion=replace(s.motion, pressed=True))) for s in sessions]
    dips = np.array([one.dips for one in _all_leavings(model, sessions, rest)])
    return _squares(rest) <= least and _agreed(dips < clear).size == 0


def _agreed(pulled: np.ndarray) -> np.ndarray:
    """Indices of the channels that are pulled at most of the leavings, from a mask (leavings, channels)."""
    return np.flatnonzero(pulled.mean(axis=0) >= AGREE)


def _squares(rows: list[np.ndarray]) -> float:
    return float(sum(np.sum(e**2) for e in rows))


def _as_simulated(found: Symptom, model: Model, sessions: list[Session], rest: list[np.ndarray]) -> tuple[Symptom, float]:
    """The pull with the reach that brings the simulation nearest to all samples, including those that are not compared, and the sum of
    squares that it leaves. If no pull is nearer than none, the evidence says so (`UNLIKE`): this skin holds on in another way than the
    simulated one."""
    tried = {}
    for reach in (found.parameters["reach"]["value"], *REACHES):
        one = replace(found, parameters={**found.parameters, "reach": quantity(reach, "m")})
        pulling = model.extended(effect_of(one))
        tried[reach] = _squares([s.raw - simulated(pulling, s) for s in sessions]), one
    least, best = min(tried.values(), key=lambda q: q[0])
    without = _squares(rest)
    return (best, least) if least < without else (replace(found, evidence={**found.evidence, UNLIKE: True}), without)


def _all_leavings(model: Model, sessions: list[Session], rest: list[np.ndarray]) -> list[Leaving]:
    return [one for s, e in zip(sessions, rest, strict=True) for one in _leavings(model, s, e)]


def _leavings(model: Model, s: Session, rest: np.ndarray) -> Iterator[Leaving]:
    """Every leaving of the session: how far each channel, smoothed, falls below its zero, and at which depth."""
    moved, touched, air = _parted(model, s)
    before, after, slowly, near, lasts = (round(seconds / moved.dt) for seconds in (BEFORE_S, AFTER_S, SLOWLY_S, NEAR_S, SMOOTH_S))
    lasts = max(lasts, SMOOTH)
    hangs = np.zeros_like(s.raw)
    if s.channels[0] == "force":  # the least force of the skin's mass nearby, as its surface is not known exactly
        hangs[0] = minimum_filter1d(np.minimum(model.dispersion.inertial(moved), 0.0), 2 * lasts + 1)
    windows = []
    for i in np.flatnonzero(touched[:-1] & ~touched[1:]):
        follows = int(np.argmax(np.append(moved.x[i : i + slowly] < -OUT, True)))
        window = np.arange(max(i - before, 0), min(i + max(after, follows), moved.x.size))
        windows.append((i, window[moved.v[window] < 0.0]))
    for _, window in windows:
        air[window] = False
    for i, window in windows:
        around = np.arange(max(i - near, 0), min(i + near, moved.x.size))
        around = around[air[around]]
        if window.size < lasts or around.size < 2 * SMOOTH or moved.x[window].min() > 0.0:
            continue
        zero = _zero(s.raw[:, around], moved.v[around])
        below = np.maximum(s.raw[:, window] - zero - hangs[:, window], rest[:, window])
        even, beside = (_even(rows, lasts) for rows in (below, s.raw[:, around] - np.median(s.raw[:, around], axis=1, keepdims=True)))
        lowest = np.argmin(even, axis=1)
        in_air = np.quantile(beside, min(CHANCE / even.shape[1], 1.0), axis=1)
        yield Leaving(even[:, lowest].T, float(moved.x[window[lowest[0] + lasts // 2]]), in_air)


def _even(rows: np.ndarray, lasts: int) -> np.ndarray:
    """Rows (C, n), moving average over `lasts` samples."""
    return np.apply_along_axis(np.convolve, 1, rows, np.ones(lasts) / lasts, "valid")


def _zero(air: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """Zero (C, 1), N, of each channel's reading in air (C, n) while the plunger moves out. The reading on the way in shows the friction of
    a rig, which drags both ways and is no pull of the skin; it is subtracted."""
    still, inwards = np.median(air, axis=1, keepdims=True), air[:, speed > IN * np.abs(speed).max()]
    drag = np.median(inwards, axis=1, keepdims=True) - still if inwards.shape[1] >= 2 * SMOOTH else 0.0
    return still - np.maximum(drag, 0.0)


def _symptom(model: Model, session: Session, dips: np.ndarray, carried: np.ndarray, depths: list[float], of: int) -> Symptom:
    names = [session.channels[c] for c in carried]
    pull = -np.median(dips, axis=0)
    taxels = [c for c in carried if session.channels[c] != "force"]
    share = max(model.shares, default=0.0)  # 0: no taxel feels anything, so none of the pull is sensed
    sensed = float(max((pull[c] for c in taxels), default=0.0) / share) if share > 0.0 else 0.0
    whole = float(pull[session.channels.index("force")]) if "force" in session.channels else sensed
    parameters = {
        "pull_sensed": quantity(sensed, "N"),
        "pull_dispersed": quantity(max(whole - sensed, 0.0), "N"),
        "reach": quantity(max(float(np.percentile(np.abs(depths), 90)), 1e-5), "m"),
    }
    sizes = ", ".join(f"{pull[c]:.3g} N in {name}" for c, name in zip(carried, names, strict=True))
    why = f"at {len(dips)} of {of} withdrawals the reading falls below its value in the air, by {sizes}: no contact pulls without adhesion"
    return Symptom("adhesion", "skin", tuple(names), parameters, {"why": why, "leavings": of, "pulled": len(dips)})
