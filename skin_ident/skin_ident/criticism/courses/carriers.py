"""Carriers of courses: the change of every simulated channel, (C, N), per unit of a zero, slope, delay or zero of depth. This is the D(t)
of the equation in `course`.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.sessions.session import Session
from skin_models.effects.position_offset import PositionOffset
from skin_models.model import Model
from skin_models.signals import Motion

ZERO, SLOPE, DELAY, DEPTH = "zero", "slope", "delay", "zero of depth"
DRIVE, DRIVEN = "zero of the driving force", "slope of the driving force"
LOADED = 0.2  # share of what the most loaded taxel feels, from which a taxel is loaded enough to show its slope
PROBE, PUSH = 1e-6, 1e-3  # steps of finite differences in depth, m, and in driving force, N


def carried(carrier: str, rows: tuple[int, ...], model: Model, s: Session, plain: np.ndarray, late: np.ndarray | float = 0.0) -> np.ndarray:
    """D (C, N), newtons per unit of the carrier, in a session whose simulation is `plain` (C, N). Zero (N), slope (1) and delay (s) act on
    the channels `rows` alone. The effect of a delay is proportional to the delay only while it is small, so D is the secant at `late` s,
    (N,)."""
    if carrier == DEPTH:
        return _deeper(model, s, plain)
    if carrier in (DRIVE, DRIVEN):
        return _pushed(model, s, plain, 1.0 if carrier == DRIVE else s.drive)
    own, out = plain[list(rows)], np.zeros_like(plain)
    if carrier == SLOPE and not _loads(s, rows[0]):
        return out
    out[list(rows)] = 1.0 if carrier == ZERO else own if carrier == SLOPE else _later(own, s.motion, late)
    return out


def _later(rows: np.ndarray, m: Motion, late: np.ndarray | float) -> np.ndarray:
    """(y(t - d) - y(t)) / d for each row y, or its limit -dy/dt where d is less than a tenth of a sample."""
    slope = -np.gradient(rows, m.dt, axis=1)
    if not np.any(late):
        return slope
    secant = np.array([np.interp(m.t - late, m.t, y) - y for y in rows]) / np.where(late == 0.0, 1.0, late)
    return np.where(np.abs(late) > 0.1 * m.dt, secant, slope)


def _loads(s: Session, row: int) -> bool:
    """Whether the session loads a channel enough to show its slope; a taxel far from the contact is not loaded enough."""
    taxel = row - (len(s.channels) - s.n_taxels)
    return s.spread is None or taxel < 0 or s.spread[taxel] > LOADED * s.spread.max()


def _deeper(model: Model, s: Session, plain: np.ndarray) -> np.ndarray:
    """d(simulated)/d(zero of depth), (C, N) N/m."""
    return (simulated(model.extended(PositionOffset("rig", offset=PROBE)), s) - plain) / PROBE


def _pushed(model: Model, s: Session, plain: np.ndarray, by: np.ndarray | float = 1.0) -> np.ndarray:
    """Change of the channels, (C, N), per unit of `by` (N) added to the driving force. Of the forward and the backward difference the
    smaller is taken at each sample: one of them may make or break a contact, and that is a jump, not a derivative."""
    push, pull = ((simulated(model, replace(s, drive=s.drive + of * by)) - plain) / of for of in (PUSH, -PUSH))
    return np.where(np.abs(push) < np.abs(pull), push, pull)


def after_jump(model: Model, s: Session, plain: np.ndarray, moment: float) -> np.ndarray:
    """Change of the channels, N per metre (C, N), if the recorded depth is too small from `moment` on. The jump is smoothed by the same
    filters as the session's depth."""
    step, m = (s.motion.t >= moment).astype(float), s.motion
    speed = s.band.speed(step)
    jumped = Motion(m.t, m.x + PROBE * s.band.smooth(step), m.v + PROBE * speed, m.a + PROBE * np.gradient(speed, m.dt), m.dt)
    return (simulated(model, replace(s, motion=jumped)) - plain) / PROBE
