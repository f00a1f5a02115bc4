"""Online estimation of the dispersion model: least squares with forgetting, block by block, with standard errors.

    Z <- lambda Z + z z',   z = (v, x, force, taxels)  after one causal low-pass common to all of them

Z gives the coefficients (by the normal equations of eq 24), the residual variance and the correlation between channels. The same sum with
lambda^2 instead of lambda, Z2, gives the covariance of coefficients under forgetting, P Z2 P with P = Z^-1. The same sum over neighbouring
rows gives the residual's correlation in time, by which the standard errors are widened (otherwise they would be too small); the factor is
that of first-order noise behind the same low-pass. State is explicit: `state = absorb(m, state, block)`.
Source: L. Ljung, System Identification, 2nd ed., Prentice Hall 1999, section 11.2.
"""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.signal import butter, sosfilt, sosfreqz

from skin_ident.estimators.split import jacobian, metric_of, split, weights_of
from skin_models.signals import GRAVITY

PER_CUTOFF = 4.0  # rows kept per period of the cut-off frequency
FEWEST = 30.0  # effective rows before there is an estimate
BINS = 20_000  # frequencies of numerical integrals


@dataclass(frozen=True)
class Memory:
    """Settings: sampling period (s), cut-off (Hz), memory (s), fixed mass (kg), whether there is a load cell, and the number of taxels."""

    dt: float
    cutoff: float
    window: float
    mass: float
    force: bool
    taxels: int

    @property
    def every(self) -> int:
        """Decimation factor of the filtered rows."""
        return max(1, int(1.0 / (PER_CUTOFF * self.cutoff * self.dt)))

    @property
    def forgetting(self) -> float:
        """The factor by which the sums are multiplied before a kept row is added: exp(-time between two such rows / window)."""
        return float(np.exp(-self.every * self.dt / self.window))


@dataclass(frozen=True, eq=False)
class State:
    """The estimator's state: the last samples, the filter's state, the number of samples filtered, the three sums (`now`, `next` over
    neighbouring rows, `squared` with lambda^2), the last kept row, and the effective number of rows."""

    tail: np.ndarray
    filter: np.ndarray
    count: int
    now: np.ndarray
    next: np.ndarray
    squared: np.ndarray
    last: np.ndarray | None
    rows: float


def initial(m: Memory) -> State:
    """The state before any sample."""
    width = 2 + m.force + m.taxels
    empty = np.zeros((width, width))
    return State(np.empty((width - 1, 0)), np.zeros((1, width, 2)), 0, empty, empty, np.zeros((2, 2)), None, 0.0)


def restarted(m: Memory, state: State) -> State:
    """The state after a pause: the sums are kept, the filter starts anew."""
    fresh = initial(m)
    return replace(state, tail=fresh.tail, filter=fresh.filter, count=0, last=None)


def absorb(m: Memory, state: State, block: np.ndarray) -> State:
    """Take in samples (1 + C, n): depth, then force (if there is one) and taxels, evenly spaced by `dt` and finite."""
    y = np.concatenate([state.tail, block], axis=1)
    if y.shape[1] < 3:
        return replace(state, tail=y)
    rows, filtered = sosfilt(_low_pass(m), _columns(m, y, _parting(state)), zi=state.filter, axis=-1)
    settling = max(0, int(2.0 / (m.cutoff * m.dt)) - state.count)
    first = settling + (-(state.count + settling)) % m.every
    after = replace(state, tail=y[:, -2:], filter=filtered, count=state.count + rows.shape[1])
    return _summed(m, after, rows[:, first :: m.every])


def _parting(state: State) -> float:
    """b / k (s) of the whole skin by the current estimate, 0 before there is one. Where b v + k x <= 0, skin and plunger have parted."""
    if state.rows < FEWEST:
        return 0.0
    b, k = np.linalg.lstsq(state.now[:2, :2], state.now[:2, 2], rcond=None)[0]
    return float(b / k) if k > 0.0 else 0.0


def _low_pass(m: Memory) -> np.ndarray:
    return butter(2, min(m.cutoff * m.dt, 0.4), fs=1.0, output="sos")


def _columns(m: Memory, y: np.ndarray, parting: float) -> np.ndarray:
    """Rows of speed and depth (zero out of contact) and of the channels, at all samples but the first and the last."""
    x, v = y[0, 1:-1], (y[0, 2:] - y[0, :-2]) / (2.0 * m.dt)
    contact = x > 0.0
    measured = y[1:, 1:-1].copy()
    if m.force:
        a = (y[0, 2:] - 2.0 * x + y[0, :-2]) / m.dt**2
        measured[0] -= m.mass * (a - GRAVITY) * contact
    touching = contact & (parting * v + x > 0.0)
    return np.concatenate([[v * touching, x * touching], measured])


def _summed(m: Memory, state: State, kept: np.ndarray) -> State:
    if not kept.shape[1]:
        return state
    weight = m.forgetting ** np.arange(kept.shape[1] - 1, -1, -1.0)
    before = kept[:, :1] if state.last is None else state.last[:, None]
    shifted = np.concatenate([before, kept[:, :-1]], axis=1)
    old = m.forgetting ** kept.shape[1]
    return replace(
        state,
        now=old * state.now + (weight * kept) @ kept.T,
        next=old * state.next + (weight * kept) @ shifted.T,
        squared=old**2 * state.squared + (weight**2 * kept[:2]) @ kept[:2].T,
        last=kept[:, -1],
        rows=old * state.rows + weight.sum(),
    )


@dataclass(frozen=True, eq=False)
class Live:
    """The current estimate: b1, k1, b2, k2, shares with their standard errors; effective rows; rms of speed (m/s) and depth (m) in contact,
    and of the residuals (N)."""

    values: np.ndarray
    std: np.ndarray
    rows: float
    speed: float
    depth: float
    residual: np.ndarray


def estimate(m: Memory, state: State) -> Live | None:
    """The current estimate, or None where there are too few rows, or the plunger is in the air or stands still."""
    gram = state.now[:2, :2]
    size = np.sqrt(np.diag(gram))
    if state.rows < FEWEST or not np.all(size > 0.0) or np.linalg.cond(gram / np.outer(size, size)) > 1e10:
        return None
    inverse = np.linalg.inv(gram / np.outer(size, size)) / np.outer(size, size)
    beta = inverse @ state.now[:2, 2:]  # (2, C)
    ends = np.concatenate([-beta, np.eye(beta.shape[1])])
    spread = ends.T @ state.now @ ends / max(state.rows - 2.0, 1.0)
    np.fill_diagonal(spread, np.maximum(np.diag(spread), 0.0))
    widened = spread * _widening(m, ends, state)
    covariance = np.kron(widened, inverse @ state.squared @ inverse)
    speed, depth = size / np.sqrt(state.rows)
    return _split(
        m, beta, covariance, metric_of(inverse), Live(np.empty(0), np.empty(0), state.rows, speed, depth, np.sqrt(np.diag(spread)))
    )


def _widening(m: Memory, ends: np.ndarray, state: State) -> np.ndarray:
    """Factors (C, C) by which correlation in time widens the covariance."""
    rho = np.diag(ends.T @ state.next @ ends) / np.maximum(np.diag(ends.T @ state.now @ ends), 1e-300)
    root = np.sqrt(np.interp(rho, *_memories(m)))
    return np.outer(root, root)


@cache
def _memories(m: Memory) -> tuple[np.ndarray, np.ndarray]:
    """For first-order noise, from white to a memory of a thousand samples: the correlation of neighbouring kept rows, and the factor by
    which it widens a variance.

    That factor is the sum of all correlations: the spectral density of the kept rows at zero frequency over their variance.
    """
    omega = np.concatenate([2 * np.pi * np.arange(m.every) / m.every, np.linspace(0.0, np.pi, BINS)])
    gain = np.abs(sosfreqz(_low_pass(m), np.minimum(omega, 2 * np.pi - omega))[1]) ** 2
    rho, sums = [], []
    for left in np.geomspace(1.0, 1e-3, 40):
        power = gain / np.abs(1.0 - (1.0 - left) * np.exp(-1j * omega)) ** 2
        variance, neighbours = (np.mean(power[m.every :] * c) for c in (1.0, np.cos(m.every * omega[m.every :])))
        rho.append(neighbours / variance)
        sums.append(np.mean(power[: m.every]) / variance)
    return np.array(rho), np.array(sums)


def _split(m: Memory, beta: np.ndarray, covariance: np.ndarray, metric: np.ndarray, live: Live) -> Live:
    flat = beta.T.ravel()
    weights = weights_of(live.residual[m.force :])

    def theta(flat: np.ndarray) -> np.ndarray:
        return split(flat[:2] if m.force else None, flat[2 * m.force :].reshape(m.taxels, 2), weights, metric)

    j = jacobian(theta, flat)
    return replace(live, values=theta(flat), std=np.sqrt(np.maximum(np.diag(j @ covariance @ j.T), 0.0)))
