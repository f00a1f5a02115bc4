"""Continuous-time transfer functions from force to force: refined instrumental variables, and output error (thesis eq 32, Table 4-7).

`riv` filters input and output by 1 / A of the last iteration, which gives their derivatives. It solves the equation error with the model's
own output as instruments, which is consistent where noise of the output makes least squares biased. `output_error` starts from it and
minimises the error of the simulation, by Gauss-Newton with exact derivatives, Levenberg damping and bounds. With `whiten` the residual is
then whitened by its autoregressive model, which makes the estimate efficient under coloured noise, and its standard errors right.
Source: P. Young, A. Jakeman, Int. J. Control 31 (1980) 741; H. Garnier, L. Wang (eds.), Identification of Continuous-time Models from
Sampled Data, Springer 2008, ch. 4.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skin_ident.estimators.errors import FitError
from skin_ident.estimators.noise import effective_samples, fit_ar
from skin_ident.estimators.transfer_data import Pair, gram, lags, nuisance, through, whitened
from skin_ident.estimators.transfer_function import TransferFunction, derivatives, discrete_powers, discretised

ROUNDS = 50  # iterations at most
TINY = 1e-10  # of a coefficient: a smaller step is rounding
NEGLIGIBLE = 1e-3  # standard errors: a smaller step is negligible
UNBOUNDED = (-np.inf, np.inf)


@dataclass(frozen=True, eq=False)
class TransferFit:
    """A fitted transfer function: `covariance` (P, P) of theta, residuals per session, noise model (ar, std), effective degrees of freedom,
    iterations, whether it converged, and the measured outputs."""

    function: TransferFunction
    covariance: np.ndarray
    residuals: list[np.ndarray]
    ar: np.ndarray
    noise: float
    dof: float
    rounds: int
    converged: bool
    measured: list[np.ndarray]

    @property
    def std(self) -> np.ndarray:
        """Standard errors (P,) of theta."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


def output_error(
    pairs: Sequence[Pair],
    zeros: int = 1,
    poles: int = 2,
    *,
    start: TransferFunction | None = None,
    lower: np.ndarray | None = None,
    upper: np.ndarray | None = None,
    offset: bool = False,
    whiten: bool = True,
) -> TransferFit:
    """The transfer function whose simulation is closest to the output of all sessions (least squares). Raises `FitError`.

    `lower` and `upper` (P,) bound theta = (beta, alpha); `offset` fits a constant per session.
    """
    start = start or riv(pairs, zeros, poles, offset=offset, close=1e-2)
    bounds = _bounds(start, lower, upper)
    f = start.with_theta(np.clip(start.theta, *bounds))
    f, residuals, rounds, converged = _minimised(pairs, f, bounds, offset, np.empty(0))
    ar, _ = fit_ar(residuals, f.theta.size)
    if whiten and ar.size:
        f, residuals, more, converged = _minimised(pairs, f, bounds, offset, ar)
        ar, _ = fit_ar(residuals, f.theta.size)
        rounds += more
    normal, cost, _ = _system(pairs, f, offset, ar)
    n = sum(p.y.size for p in pairs)
    ys = [p.y for p in pairs]
    dof = max(1.0, n - f.theta.size - len(pairs) * (poles + offset))
    inverse = _inverse(normal)
    return TransferFit(f, inverse * cost / dof, residuals, ar, float(np.sqrt(cost / dof)), effective_samples(ar, n), rounds, converged, ys)


def unweighted(pairs: Sequence[Pair], zeros: int, poles: int, offset: bool) -> tuple[TransferFunction, int, bool]:
    """`output_error` without bounds, whitening or covariance: the function, the iterations, whether it converged. Raises `FitError`."""
    start = riv(pairs, zeros, poles, offset=offset, close=1e-2)
    f, _, rounds, converged = _minimised(pairs, start, _bounds(start, None, None), offset, np.empty(0))
    return f, rounds, converged


def _bounds(f: TransferFunction, lower, upper) -> tuple[np.ndarray, np.ndarray]:
    low = np.full(f.theta.size, UNBOUNDED[0]) if lower is None else np.asarray(lower, float)
    high = np.full(f.theta.size, UNBOUNDED[1]) if upper is None else np.asarray(upper, float)
    cut = len(f.numerator)
    low[cut:] = np.maximum(low[cut:], 1e-9)  # stable
    if low.shape != high.shape or low.shape != f.theta.shape or np.any(low > high):
        raise FitError(f"bounds must be {f.theta.size} numbers each, lower below upper")
    return low, high


def _minimised(pairs, f: TransferFunction, bounds, offset: bool, ar: np.ndarray):
    """The minimum by Levenberg-Marquardt: function, residuals, iterations, whether it converged."""
    damping, theta, count = 0.0, f.theta, sum(p.y.size for p in pairs)
    normal, cost, slope = _system(pairs, f, offset, ar)
    for i in range(ROUNDS):
        free = ~(((theta <= bounds[0]) & (slope < 0)) | ((theta >= bounds[1]) & (slope > 0)))
        step = _step(normal, slope, free, damping)
        step = np.clip(theta + step, *bounds) - theta
        least = NEGLIGIBLE**2 * cost / (count * np.maximum(np.diag(normal), 1e-300))
        if np.all((step**2 <= least) | (np.abs(step) <= TINY * np.abs(theta))) and damping < 1.0:
            return f, _residuals(pairs, f, offset), i, True
        trial = f.with_theta(theta + step)
        tried = _system(pairs, trial, offset, ar)
        if tried[1] <= cost:
            f, theta, (normal, cost, slope), damping = trial, trial.theta, tried, damping / 10 if damping > 1e-12 else 0.0
        elif damping > 1e10:
            return f, _residuals(pairs, f, offset), i, True
        else:
            damping = max(10 * damping, 1e-3)
    return f, _residuals(pairs, f, offset), ROUNDS, False


def _step(normal: np.ndarray, slope: np.ndarray, free: np.ndarray, damping: float) -> np.ndarray:
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    with np.errstate(all="ignore"):
        unit = normal / np.outer(scale, scale) + damping * np.eye(scale.size)
    if not (np.isfinite(unit).all() and np.isfinite(slope / scale).all()):
        raise FitError("these data do not determine a transfer function of this order: take a lower one, or faster and richer motion")
    step = np.zeros(scale.size)
    step[free] = np.linalg.lstsq(unit[np.ix_(free, free)], (slope / scale)[free], rcond=1e-14)[0] / scale[free]
    return step


def _system(pairs, f: TransferFunction, offset: bool, ar: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """J'J (P, P), e'e and J'e (P,) over all sessions, with whitened signals and the nuisance columns projected out."""
    with np.errstate(all="ignore"):  # a step may lead to a pole at zero: the result is NaN, and the step is rejected
        parts = [_session(p, f, offset, ar) for p in pairs]
    return sum(a for a, _, _ in parts), sum(b for _, b, _ in parts), sum(c for _, _, c in parts)


def _session(p: Pair, f: TransferFunction, offset: bool, ar: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    num, den, d_num, d_den = derivatives(f, p.dt)
    k, n = den.size, p.y.size
    w_u = through(p.u, den, k - 1)
    model = num @ lags(w_u, k, n)
    w_y = through(model, den, k - 1)
    error = p.y - model
    w_u, w_y, error = (whitened(w, ar) for w in (w_u, w_y, error)) if ar.size else (w_u, w_y, error)
    rows = np.empty((2 * k, error.size))
    rows[:k], rows[k:-1], rows[-1] = lags(w_u, k, error.size), lags(w_y, k, error.size)[1:], error
    products = gram(rows, nuisance(den, n, offset, ar))
    mix = np.concatenate([d_num, -d_den[:, 1:]], axis=1)
    inner = products[:-1, :-1]
    return mix @ inner @ mix.T, float(max(products[-1, -1], 0.0)), mix @ products[:-1, -1]


def _residuals(pairs, f: TransferFunction, offset: bool) -> list[np.ndarray]:
    out = []
    for p in pairs:
        num, den = discretised(f, p.dt)
        e = p.y - num @ lags(through(p.u, den, den.size - 1), den.size, p.y.size)
        free = nuisance(den, p.u.size, offset, np.empty(0))
        start = e[: free.shape[1]]
        start -= np.linalg.lstsq(free @ free.T, free @ start, rcond=1e-13)[0] @ free
        out.append(e)
    return out


def _inverse(normal: np.ndarray) -> np.ndarray:
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    return np.linalg.pinv(normal / np.outer(scale, scale), rcond=1e-14) / np.outer(scale, scale)


def riv(pairs: Sequence[Pair], zeros: int = 1, poles: int = 2, *, offset: bool = False, close: float = 1e-5) -> TransferFunction:
    """The transfer function by refined instrumental variables for white output noise, iterated until no coefficient changes by more than
    `close` (relative).

    Raises `FitError` where no stable function fits.
    """
    if not 1 <= poles <= 2 or not 0 <= zeros <= poles:
        raise FitError("a transfer function here has 1 or 2 poles and at most as many zeros")
    best = None
    for corner in _corners(pairs):
        f = TransferFunction((0.0,) * (zeros + 1), tuple(np.poly([-corner] * poles)[1:]))
        f = _iterated(pairs, f, offset, close)
        if f is None:
            continue
        left = sum(float(e @ e) for e in _residuals(pairs, f, offset))
        if best is None or left < best[1]:
            best = (f, left)
        if left < 0.5 * sum(float(np.var(p.y)) * p.y.size for p in pairs):
            break
    if best is None:
        raise FitError("no stable transfer function of this order leads from the input to the output")
    return best[0]


def _corners(pairs: Sequence[Pair]) -> list[float]:
    """Initial corner frequencies (rad/s): about where the input's power is, above and below."""
    p = max(pairs, key=lambda p: p.u.size)
    power = np.abs(np.fft.rfft((p.u - p.u.mean())[: 1 << 15])) ** 2
    where = int(np.searchsorted(np.cumsum(power), 0.9 * power.sum())) + 1
    middle = 2 * np.pi * where / (min(p.u.size, 1 << 15) * p.dt)
    limit = 1.0 / p.dt
    return [min(limit, 3 * middle), min(limit, 30 * middle), middle, min(limit, 300 * middle), 0.1 * middle]


def _iterated(pairs, f: TransferFunction, offset: bool, close: float) -> TransferFunction | None:
    instruments = False
    for _ in range(ROUNDS):
        theta = _instrumental(pairs, f, offset, instruments)
        if theta is None:
            return None
        new = f.with_theta(_stabilised(theta, len(f.numerator)))
        done = instruments and np.all(np.abs(new.theta - f.theta) <= close * np.abs(new.theta))
        f, instruments = new, True
        if done:
            break
    return f


def _stabilised(theta: np.ndarray, cut: int) -> np.ndarray:
    """theta with its poles mirrored into the left half plane."""
    roots = np.roots([1.0, *theta[cut:]])
    roots = -np.abs(roots.real) - 1e-6 * np.abs(roots) + 1j * roots.imag
    return np.concatenate([theta[:cut], np.poly(roots).real[1:]])


def _instrumental(pairs, f: TransferFunction, offset: bool, instruments: bool) -> np.ndarray | None:
    """theta from one solution of the equation error: with the model's output as instruments, or, without `instruments`, by least squares.
    None where the result is not finite."""
    n, m = len(f.denominator), len(f.numerator)
    left = right = 0.0
    for p in pairs:
        powers, den = (a[0] for a in discrete_powers(np.array([f.denominator]), p.dt))
        w_u, w_y = (lags(through(x, den, n), n + 1, x.size) for x in (p.u, p.y))
        rows = np.empty((3 * (n + 1) if instruments else 2 * (n + 1), p.u.size))
        rows[: n + 1], rows[n + 1 : 2 * n + 2] = w_u, w_y
        if instruments:
            model = np.array(f.numerator) @ powers[-m:] @ w_u
            rows[2 * n + 2 :] = lags(through(model, den, n), n + 1, model.size)
        products = gram(rows, nuisance(den, p.u.size, offset, np.empty(0)))
        of_u, of_y, of_x = (_selecting(powers, i, len(rows)) for i in (0, 1, 2 if instruments else 1))
        regressors, z = np.concatenate([of_u[-m:], -of_y[1:]]), np.concatenate([of_u[-m:], -of_x[1:]])
        left, right = left + z @ products @ regressors.T, right + z @ products @ of_y[0]
    with np.errstate(all="ignore"):
        scale = np.sqrt(np.abs(np.diag(left))) + 1e-300
        unit, wanted = left / np.outer(scale, scale), right / scale
    if not (np.isfinite(unit).all() and np.isfinite(wanted).all()):
        return None
    theta = np.linalg.lstsq(unit, wanted, rcond=1e-14)[0] / scale
    return theta if np.isfinite(theta).all() else None


def _selecting(powers: np.ndarray, block: int, width: int) -> np.ndarray:
    """A matrix that applies the combinations `powers` to the block-th group of rows."""
    out = np.zeros((len(powers), width))
    out[:, block * len(powers) : (block + 1) * len(powers)] = powers
    return out
