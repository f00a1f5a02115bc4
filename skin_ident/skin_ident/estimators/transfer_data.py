"""The data that a transfer function's fit needs of one session: input and output filtered by 1 / A, with their delays, as one matrix.

With the discrete denominator den, w_u = u / den and w_y = y / den, every signal of the fit is a short combination of delayed w's:

    model output      num . (w_u[n], w_u[n-1], …)
    its derivatives   d_num . (w_u …) - d_den . (w_y[n-1], …)      with y the model's own output
    s^i / A of u, y   powers[i] . (w …)

so an iteration costs only two recursive filters and one small Gram matrix.
"""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from skin_ident.estimators.errors import FitError


@dataclass(frozen=True)
class Pair:
    """One session: input u and output y (N,), in N, sampled every dt (s)."""

    name: str
    u: np.ndarray
    y: np.ndarray
    dt: float

    def __post_init__(self) -> None:
        if self.u.shape != self.y.shape or self.u.ndim != 1 or self.u.size < 20:
            raise FitError(f"{self.name}: input and output must be rows of at least 20 samples each")
        if not (np.isfinite(self.u).all() and np.isfinite(self.y).all()):
            raise FitError(f"{self.name}: input and output must be finite")
        if np.ptp(self.u) == 0.0:
            raise FitError(f"{self.name}: the input never changes, so that nothing can be identified")


def through(x: np.ndarray, den: np.ndarray, before: int) -> np.ndarray:
    """x filtered by 1 / den (before + N,), with `before` samples in front, where x is taken as constant at its first value."""
    rest = x[0] / den.sum()
    state = -np.cumsum(den[:0:-1])[::-1] * rest  # transposed direct form II, settled at a constant input
    out = np.empty(x.size + before)
    out[:before] = rest
    out[before:] = lfilter(_ONE, den, x, zi=state)[0]
    return out


def lags(padded: np.ndarray, count: int, size: int) -> np.ndarray:
    """The last `size` samples and their delays by 1 … count - 1: a view (count, size)."""
    n = padded.strides[0]
    return np.lib.stride_tricks.as_strided(padded[padded.size - size :], (count, size), (-n, n))


_ONE = np.ones(1)


def nuisance(den: np.ndarray, size: int, offset: bool, ar: np.ndarray) -> np.ndarray:
    """Nuisance columns (K, reach or size): the transients from an unknown initial state and, with `offset`, a constant.

    Without the constant they have died out after `reach` samples. They are whitened by `ar`, like the rows they are compared with.
    """
    slowest = min(max(float(np.abs(np.roots(den)).max()), 1e-3), 1 - 1e-9)
    reach = size if offset else int(min(size, np.ceil(np.log(1e-6) / np.log(slowest)) + den.size))
    free = np.zeros((den.size - 1 + offset, reach))
    free[0] = lfilter(_ONE, den, np.eye(1, reach)[0])
    for i in range(1, den.size - 1):
        free[i, i:] = free[0, :-i]
    if offset:
        free[-1] = 1.0
    return whitened(free, ar)


def whitened(rows: np.ndarray, ar: np.ndarray) -> np.ndarray:
    """Rows filtered by A(q) = 1 - ar[0] q^-1 - …, without the first samples, whose past is missing."""
    return lfilter(np.concatenate([_ONE, -ar]), _ONE, rows, axis=-1)[..., ar.size :] if ar.size else rows


def gram(rows: np.ndarray, free: np.ndarray) -> np.ndarray:
    """The Gram matrix rows rows' with the columns `free` projected out; `free` may be shorter than the rows, and counts as zero after
    that."""
    own = rows @ rows.T
    cross = rows[:, : free.shape[1]] @ free.T
    return own - cross @ np.linalg.lstsq(free @ free.T, cross.T, rcond=1e-13)[0]
