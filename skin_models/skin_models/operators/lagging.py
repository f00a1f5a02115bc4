"""The exact steps of lags, for an input that is linear between samples."""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any

import numpy as np
from scipy.linalg import expm
from scipy.signal import lfilter

from skin_models.operators.by_rows import FLOATS, by_rows, compiled

NONE = 1e-6  # of a sample: a shorter delay is stepped as this one


def lag_factors(tau: float, dt: float) -> tuple[float, float]:
    """e and g of z[n] = e z[n-1] + (g - e) y[n-1] + (1 - g) y[n]: e = exp(-dt / tau), g = (1 - e) tau / dt; 0 and 0 where tau is 0."""
    if tau == 0.0:
        return 0.0, 0.0
    return math.exp(-dt / tau), -math.expm1(-dt / tau) * tau / dt


def lagged(y: np.ndarray, tau: float, dt: float) -> np.ndarray:
    """z (..., N) of y, at rest at y[..., 0]."""
    e, g = lag_factors(tau, dt)
    z, _ = lfilter([1.0 - g, g - e], [1.0, -e], y, zi=g * y[..., :1])  # the filter's memory of an input that has always been y[0]
    return z


def lagged_step(state: tuple | None, y: Any, tau: float, dt: float) -> tuple[tuple, Any]:
    """One sample of the same: the state (z and y of the sample before, None before the first) after it, and z."""
    z, last = (y, y) if state is None else state
    z = _next(z, last, y, *lag_factors(tau, dt))
    return (z, y), z


def _next(z: Any, last: Any, y: Any, e: Any, g: Any) -> Any:
    return e * z + (g - e) * last + (1.0 - g) * y


def lagged_in_contact(x: np.ndarray, tau: float, dt: float) -> np.ndarray:
    """z (N,) of a depth x that lags where it is positive; in the air z is 0, and begins from there again at the next contact."""
    e, _ = lag_factors(tau, dt)
    z = lagged(np.maximum(x, 0.0), tau, dt)
    n = np.arange(x.size)
    air = np.maximum.accumulate(np.where(x <= 0.0, n, -1))  # the last sample in the air, where z is to be 0 instead of z[air]
    return z - np.where(air >= 0, e ** (n - air) * z[air], 0.0)


def lagged_in_contact_step(state: tuple | None, x: Any, tau: float, dt: float) -> tuple[tuple, Any]:
    """One sample of the same: state and z as in `lagged_step`."""
    (z, last), _ = lagged_step(state, np.maximum(x, 0.0), tau, dt)
    z = np.where(np.asarray(x) > 0.0, z, 0.0)[()]
    return (z, last), z


def lagged_either_way(y: np.ndarray, up: float, down: float, dt: float) -> np.ndarray:
    """z (..., N) of y, at rest at y[..., 0], with one time constant while y is above z and another one elsewhere."""
    rising, falling = (np.array(lag_factors(tau, dt)) for tau in (up, down))
    return by_rows(y, _compiled_either_way(), _either_way, rising, falling)


@cache
def _compiled_either_way() -> Callable | None:
    """`_either_way` of many rows, seventeen times as fast; None without a compiler."""
    return compiled("lag", "lag_either_way", FLOATS, FLOATS)


def _either_way(record: np.ndarray, rising: np.ndarray, falling: np.ndarray) -> list[float]:
    """Sample by sample: the time constant depends on the last z, so a linear filter cannot do it."""
    y, rising, falling = record.tolist(), rising.tolist(), falling.tolist()
    z, out = y[0], [y[0]]
    for last, now in itertools.pairwise(y):
        e, g = rising if now > z else falling
        z = e * z + (g - e) * last + (1.0 - g) * now  # `_next`, without the call
        out.append(z)
    return out


def lagged_step_either_way(state: tuple | None, y: Any, up: float, down: float, dt: float) -> tuple[tuple, Any]:
    """One sample of the same: the state (z and y of the sample before, None before the first) after it, and z."""
    z, last = (y, y) if state is None else state
    (e1, g1), (e2, g2) = lag_factors(up, dt), lag_factors(down, dt)
    z = _next(z, last, y, np.where(y > z, e1, e2), np.where(y > z, g1, g2))
    return (z, y), z


def in_part(y: Any, z: Any, late: float, settling: float) -> Any:
    """y with the share late / settling of it (at most 1) replaced by z, the lagged signal of time constant `settling`: late by `late` for
    slow inputs."""
    return y + min(late / settling, 1.0) * (z - y)


@dataclass(frozen=True)
class SecondOrder:
    """x[n] = transition x[n-1] + before y[n-1] + now y[n], (2, 2), (2,) and (2,); the output is x's first row."""

    transition: np.ndarray
    before: np.ndarray
    now: np.ndarray

    @property
    def filter(self) -> tuple[np.ndarray, np.ndarray]:
        """The same as numerator and denominator in powers of 1/z: C (I - Phi/z)^-1 (now + before/z), by the adjugate of a 2x2 matrix."""
        trace = np.trace(self.transition)
        adjugate = (self.transition - trace * np.eye(2))[0]
        b = np.array([self.now[0], self.before[0] + adjugate @ self.now, adjugate @ self.before])
        return b, np.array([1.0, -trace, np.linalg.det(self.transition)])


@lru_cache(maxsize=256)
def second_order_factors(tau: float, damping: float, dt: float) -> SecondOrder:
    """The step of (tau / 2 zeta)^2 z'' + tau z' + z = y with the state (z, z' tau / 2 zeta), from the exponential of the system and its
    input as a ramp."""
    w = 2.0 * damping * dt / max(tau, NONE * dt)  # natural frequency times dt
    system = np.zeros((4, 4))
    system[:2, :3] = w * np.array([[0.0, 1.0, 0.0], [-1.0, -2.0 * damping, 1.0]])
    system[2, 3] = 1.0
    moved = expm(system)
    return SecondOrder(moved[:2, :2], moved[:2, 2] - moved[:2, 3], moved[:2, 3])
