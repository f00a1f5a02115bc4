"""What a session alone may have otherwise, and what a unit of it changes in every channel: the D of `course`, (C, N)."""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.sessions.session import Session
from skin_models.effects.position_offset import PositionOffset
from skin_models.model import Model
from skin_models.signals import Motion

ZERO, SLOPE, DELAY, DEPTH = "zero", "slope", "delay", "zero of depth"
DRIVE, DRIVEN = "zero of the driving force", "slope of the driving force"
LOADED = 0.2  # of what the taxel under the plunger feels
PROBE, PUSH = 1e-6, 1e-3  # m, N


def carried(carrier: str, rows: tuple[int, ...], model: Model, s: Session, plain: np.ndarray, late: np.ndarray | float = 0.0) -> np.ndarray:
    """D in newtons for each unit of the carrier, where the session is simulated as `plain` (C, N); zero, slope (1) and delay (s) are those
    of the channels `rows` alone. What a delay changes is in proportion to small ones only: D is exact for `late` s, (N,)."""
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
    """(y(t - d) - y(t)) / d of each row y, and its limit -dy/dt where d is less than a tenth of a sample."""
    slope = -np.gradient(rows, m.dt, axis=1)
    if not np.any(late):
        return slope
    secant = np.array([np.interp(m.t - late, m.t, y) - y for y in rows]) / np.where(late == 0.0, 1.0, late)
    return np.where(np.abs(late) > 0.1 * m.dt, secant, slope)


def _loads(s: Session, row: int) -> bool:
    """Whether the session loads a channel well enough to know its slope; not so a taxel far from where it presses."""
    taxel = row - (len(s.channels) - s.n_taxels)
    return s.spread is None or taxel < 0 or s.spread[taxel] > LOADED * s.spread.max()


def _deeper(model: Model, s: Session, plain: np.ndarray) -> np.ndarray:
    """d(simulated)/d(zero of depth), (C, N) N/m."""
    return (simulated(model.extended(PositionOffset("rig", offset=PROBE)), s) - plain) / PROBE


def _pushed(model: Model, s: Session, plain: np.ndarray, by: np.ndarray | float = 1.0) -> np.ndarray:
    """What a unit more of `by` (N) in the driving force changes, (C, N): by the smaller of a push and a pull, of which one may make or lose
    a contact, and that is a jump and no derivative."""
    push, pull = ((simulated(model, replace(s, drive=s.drive + of * by)) - plain) / of for of in (PUSH, -PUSH))
    return np.where(np.abs(push) < np.abs(pull), push, pull)


def after_jump(model: Model, s: Session, plain: np.ndarray, moment: float) -> np.ndarray:
    """Newtons (C, N) per metre by which the depth read is too small from `moment` on, as the session's filters have smoothed the jump."""
    step, m = (s.motion.t >= moment).astype(float), s.motion
    speed = s.band.speed(step)
    jumped = Motion(m.t, m.x + PROBE * s.band.smooth(step), m.v + PROBE * speed, m.a + PROBE * np.gradient(speed, m.dt), m.dt)
    return (simulated(model, replace(s, motion=jumped)) - plain) / PROBE
