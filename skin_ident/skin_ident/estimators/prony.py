"""Relaxation spectra: Prony series of Maxwell arms beside the dispersion model, from holds or from any other motion.

    channel c   B_c v + K_c x + sum_i k_ci r_i,        r_i' = v - r_i / tau_i

The arms follow the measured depth exactly (`skin_models.effects.stress_relaxation`), so slow ramps and short holds need no correction. All
channels share the times, and each has its own stiffnesses. For given times the model is linear, so only the times are searched (variable
projection). Arms are added until BIC no longer improves.
Source: N. W. Tschoegl, The Phenomenological Theory of Linear Viscoelastic Behavior, Springer 1989, ch. 3; G. Golub, V. Pereyra, Inverse
Problems 19 (2003) R1.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.optimize import minimize

from skin_ident.estimators.errors import FitError
from skin_ident.estimators.left_over import left_over
from skin_ident.estimators.regression import Block, Regression, regress
from skin_ident.estimators.sessions import Session, prepare
from skin_ident.recordings.recording import Recording
from skin_ident.stretches import runs
from skin_models.dispersion import Dispersion
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.model import Model

MOST = 4  # arms
APART = 2.0  # least ratio of two neighbouring times
RESTS = 0.02  # share of the highest speed below which the plunger rests
SHORTEST = 0.5  # s, shortest rest that is called a hold
SURE = 2.0  # standard errors by which times and stiffnesses must differ from zero
ENTANGLED = 1e10  # condition of the normal matrix from which rounding decides about a variance
NO_RELAXATION = (
    "no relaxation can be told from these data: of every arm the time is less sure than half its size, or a stiffness is negative or not "
    "sure; record holds of some ten seconds after quick ramps"
)


@dataclass(frozen=True)
class Arm:
    """One arm: time (s) and stiffness per channel (N/m), each with its standard error."""

    tau: float
    tau_std: float
    stiffness: dict[str, tuple[float, float]]


@dataclass(frozen=True, eq=False)
class PronyFit:
    """`arms` by increasing time; B and K of every channel, with standard errors; the model, for a load cell and one live taxel."""

    arms: tuple[Arm, ...]
    damping: dict[str, tuple[float, float]]
    stiffness: dict[str, tuple[float, float]]
    rmse: dict[str, float]
    model: Model | None
    warnings: tuple[str, ...]


def fit_prony(recordings: Sequence[Recording], arms: int | None = None) -> PronyFit:
    """The spectrum of all sessions together; `arms` fixes their number. Raises `FitError`."""
    sessions, warnings = prepare(recordings)
    names = (["force"] if sessions[0].force is not None else []) + [f"taxel_{i}" for i in sessions[0].live]
    if not names:
        raise FitError(f"{sessions[0].name} holds no force in newtons")
    if arms is not None and not 0 <= arms <= MOST:
        raise FitError(f"the number of arms lies between 0 and {MOST}")
    limits = _limits(sessions)
    taus = _searched(sessions, names, arms, limits) if arms is not None else _as_few_as_possible(sessions, names, limits)
    return _result(sessions, names, taus, limits, warnings)


def _limits(sessions: list[Session]) -> tuple[float, float]:
    """The range of times (s) that the data can show: from two decimated samples to the longest session."""
    return 2.0 * max(s.motion.dt * s.prefilter.every for s in sessions), max(s.motion.t[-1] - s.motion.t[0] for s in sessions)


def _as_few_as_possible(sessions, names, limits) -> np.ndarray:
    taus, left, rows = np.empty(0), _cost(sessions, names, np.empty(0)), _independent(sessions, names)
    for count in range(1, MOST + 1):
        more = _searched(sessions, names, count, limits)
        cost = _cost(sessions, names, more)
        if rows * (left - cost) < (1 + len(names)) * np.log(rows):
            return taus
        taus, left = more, cost
    return taus


def _independent(sessions, names) -> float:
    """The effective number of independent rows, by the noise of the richest model."""
    return max(10.0, regress(_blocks(sessions, names, np.geomspace(*_limits(sessions), 6)[1:-1])).dof)


def _searched(sessions, names, count: int, limits) -> np.ndarray:
    """The `count` times with the smallest residual; the start is spread over the limits and then refined one time after the other."""
    if count == 0:
        return np.empty(0)
    inner = np.log(limits) + np.array([0.1, -0.1])

    def cost(logs: np.ndarray) -> float:
        logs = np.sort(np.clip(logs, *inner))
        crowded = np.sum(np.maximum(0.0, np.log(APART) - np.diff(logs)) ** 2)
        return _cost(sessions, names, np.exp(logs)) + 10.0 * float(crowded)

    start = np.linspace(*inner, count + 2)[1:-1]
    for i in range(count):  # a coarse look along each time in turn
        trials = [np.concatenate([start[:i], [x], start[i + 1 :]]) for x in np.linspace(*inner, 12)]
        start = min(trials, key=cost)
    best = minimize(cost, start, method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-7, "maxiter": 120 * count})
    return np.exp(np.sort(np.clip(best.x, *inner)))


def _cost(sessions, names, taus: np.ndarray) -> float:
    """Sum over channels of ln(residual sum of squares)."""
    total = 0.0
    for blocks in _blocks(sessions, names, taus):
        y, h = (np.concatenate(parts) for parts in zip(*(b.narrow for b in blocks), strict=True))
        scale = np.maximum(np.sqrt(np.sum(h**2, axis=0)), 1e-300)
        e = y - h / scale @ np.linalg.lstsq(h / scale, y, rcond=1e-10)[0]
        total += float(np.log(max(e @ e, 1e-30 * (y @ y), 1e-300)))
    return total


def _blocks(sessions: list[Session], names: list[str], taus: np.ndarray, slopes: np.ndarray | None = None) -> list[list[Block]]:
    """Blocks by channel with the columns speed, depth, and stretch of every arm; where `slopes` (stiffnesses) are given, also the
    derivatives by each time."""
    channels: list[list[Block]] = [[] for _ in names]
    for s in sessions:
        v, x, _, _ = s.columns().T
        arms = [_stretch(s, tau) for tau in taus]
        moved = (
            [(_stretch(s, tau * (1 + 1e-4)) - _stretch(s, tau * (1 - 1e-4))) / (2e-4 * tau) for tau in taus] if slopes is not None else []
        )
        rows = ([s.force] if s.force is not None else []) + list(s.taxels)
        for c, (blocks, y) in enumerate(zip(channels, rows, strict=True)):
            bent = [slopes[c, i] * m for i, m in enumerate(moved)]
            columns = np.column_stack([v, x, *arms, *bent])
            blocks += [Block(y[part], columns[part], s.prefilter.kernel) for part in s.parts]
    return channels


def _stretch(s: Session, tau: float) -> np.ndarray:
    unit = StressRelaxation(where="skin", k_sensed=1.0, k_dispersed=0.0, tau=float(tau))
    return s.prefilter.rows(unit.batch(np.zeros((2, len(s.motion))), s.motion)[0])


def _result(sessions, names, taus: np.ndarray, limits, warnings: tuple[str, ...]) -> PronyFit:
    fit, doubt = regress(_blocks(sessions, names, taus)), _doubt(sessions, names, taus)
    k = np.array([c[2:] for c in fit.coefficients])
    std = _std(fit).reshape(len(names), -1)
    tau_std = _tau_std(sessions, names, taus, k)
    arms = tuple(
        Arm(float(tau), float(tau_std[i]), {n: (float(k[c, i]), float(std[c][2 + i])) for c, n in enumerate(names)})
        for i, tau in enumerate(taus)
    )
    like = "which no skin is" if doubt else "as a sensor's lag is"
    notes = [f"the arm of {a.tau:.3g} s is as long as the recording: its time is not known" for a in arms if a.tau > 0.8 * limits[1]]
    notes += [f"{n}: the arm of {a.tau:.3g} s is negative, {like}" for a in arms for n, (v, s) in a.stiffness.items() if v < -2 * s]
    if arms and not any(map(_relaxes, arms)):
        notes.append(NO_RELAXATION)
    else:
        notes += _from_motion(sessions, taus)
    pairs = list(zip(names, fit.coefficients, std, strict=True))
    return PronyFit(
        arms=arms,
        damping={n: (float(c[0]), float(s[0])) for n, c, s in pairs},
        stiffness={n: (float(c[1]), float(s[1])) for n, c, s in pairs},
        rmse={n: float(np.sqrt(np.mean(np.concatenate(e) ** 2))) for n, e in zip(names, fit.residuals, strict=True)},
        model=_model(sessions[0], fit.coefficients, taus),
        warnings=(*warnings, *notes, *doubt),
    )


def _doubt(sessions: list[Session], names: list[str], taus: np.ndarray) -> list[str]:
    """A warning where arms leave far more than noise: then they stand for what the model lacks, whatever it is."""
    if not taus.size:
        return []
    measured = list(zip(*(s.raw for s in sessions), strict=True))
    without, left = (left_over(names, regress(b), b, measured, 1) for b in (_blocks(sessions, names, t) for t in (np.empty(0), taus)))
    if left is None or not left.lacking:
        return []
    said = f"{left.words}; without arms it is {without.times:.0f} times"
    return [f"{said}: these arms may be no relaxation but stand for what the model lacks; run diagnose to see what"]


def _from_motion(sessions: list[Session], taus: np.ndarray) -> list[str]:
    """A warning where no hold is as long as the longest arm: curvature, hysteresis or a lag can pass for an arm while the plunger moves."""
    longest = max(map(_hold, sessions))
    if not taus.size or longest >= taus[-1]:
        return []
    said = f"the longest hold lasts {longest:.2g} s" if longest >= SHORTEST else "these are no holds"
    return [
        f"{said}: the arm of {taus[-1]:.3g} s is told by the motion alone, where a bent spring, hysteresis or a lag looks like relaxation; "
        "record holds of some ten seconds after quick ramps"
    ]


def _hold(s: Session) -> float:
    """The longest time (s) in contact during which the plunger rests: noise of the encoder, of which each speed is made, averages out."""
    v = np.abs(uniform_filter1d(s.motion.v, max(round(SHORTEST / s.motion.dt), 1)))
    still = (v < RESTS * v.max()) & (s.motion.x > 0.0)
    return s.motion.dt * max((stop - start for start, stop in zip(*runs(still), strict=True)), default=0)


def _relaxes(arm: Arm) -> bool:
    """Whether an arm is a skin's relaxation: its time is significant, no stiffness is significantly negative, and one is significantly
    positive."""
    pulls = [value / max(std, 1e-300) for value, std in arm.stiffness.values()]
    return arm.tau > SURE * arm.tau_std and min(pulls) > -SURE and max(pulls) > SURE


def _std(fit: Regression) -> np.ndarray:
    """Standard errors of all coefficients; infinite where rounding has left no positive variance."""
    variance = np.diag(fit.covariance)
    return np.sqrt(np.where(variance > 0.0, variance, np.inf))


def _tau_std(sessions, names, taus: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Standard errors of the times, from each channel's linearised model, pooled as for independent channels; infinite for a time that no
    channel tells."""
    each = np.array([_told(blocks, taus.size) for blocks in _blocks(sessions, names, taus, k)])
    with np.errstate(divide="ignore"):
        return 1.0 / np.sqrt(np.sum(each**-2, axis=0))


def _told(blocks: list[Block], count: int) -> np.ndarray:
    """Standard errors of the `count` times by one channel, infinite where it cannot tell them from the stiffnesses."""
    try:
        fit = regress([blocks])
    except FitError:
        return np.full(count, np.inf)
    return _std(fit)[2 + count :] if fit.condition < ENTANGLED else np.full(count, np.inf)


def _model(session: Session, coefficients: list[np.ndarray], taus: np.ndarray) -> Model | None:
    """Dispersion model and arms, for a load cell and one live taxel, where none of them comes out negative."""
    if session.force is None or len(session.live) != 1:
        return None
    whole, sensed = coefficients
    rest = whole - sensed
    arms = [(k1, k2, tau) for k1, k2, tau in zip(sensed[2:], rest[2:], taus, strict=True)]
    if sensed[1] < 0.0 or any(k1 < 0.0 or k2 < 0.0 for k1, k2, _ in arms):
        return None
    effects = tuple(StressRelaxation(where="skin", k_sensed=float(a), k_dispersed=float(b), tau=float(tau)) for a, b, tau in arms)
    shares = tuple(float(i in session.live) for i in range(session.total))
    return Model(Dispersion(b1=float(sensed[0]), k1=float(sensed[1]), b2=float(rest[0]), k2=float(rest[1])), shares, effects)
