"""Evidence of one hypothesis about the measured shares, by Laplace's approximation.

A hypothesis gives a Gaussian prior around zero, by its standard deviation, for every entry of the family's member that it sets free. Its
evidence at the most probable member is

    log E = -1/2 |whitened misfit|^2 - 1/2 log det C - 1/2 |entries / std|^2 - 1/2 log det H - sum log std,    H = J'J + 1 / std^2

with C the covariance of the shares. It penalises freedom by itself: a cause that could explain anything has little evidence.

Source: D. MacKay, Information Theory, Inference, and Learning Algorithms, 2003, ch. 27 and 28.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.array.family import Family, is_repeat
from skin_ident.criticism.array.gains import Gains

STEPS = 25  # Levenberg-Marquardt steps, at most
DIFFERENCE = 1e-4  # step of finite differences, in prior standard deviations
# Prior standard deviations of logarithms that are always free: the unknown common stiffness, and its differences between sessions.
ALWAYS = {"level": 3.0, "scale": 0.02}


@dataclass(frozen=True, eq=False)
class Fitted:
    """The most probable member, standard errors of its free entries, and the log evidence."""

    member: dict[str, float]
    std: dict[str, float]
    log_evidence: float


def fitted(family: Family, gains: Gains, scatter: float, free: dict[str, float], start: dict[str, float] | None = None) -> Fitted:
    """Fit the entries of `free` (name: prior standard deviation) to the measured shares, starting at the member `start` or at zero.

    The entry `scale` in `free` stands for those of all sessions. `scatter` is the relative standard error of calibrations: one unknown
    factor per taxel, the same in all sessions, is integrated out.
    """
    names = [n for n in family.names if n in free or n.partition("_")[0] in ALWAYS]
    names += filter(is_repeat, free)
    every = ALWAYS | free
    size = np.array([every.get(n, every.get(n.partition("_")[0])) for n in names], float)
    start = start or {"level": first_level(family, gains)}
    root, log_root = covariance_root(gains, scatter)
    problem = _Problem(family, gains, tuple(names), size, root)
    z, e, J = _descend(problem, np.array([start.get(n, 0.0) for n in names]) / size)
    H = J.T @ J
    _, log_det = np.linalg.slogdet(H)  # z is in prior standard deviations, so this contains the sum of their logarithms
    std = np.sqrt(np.diag(np.linalg.inv(H))) * size
    return Fitted(
        problem.member(z),
        dict(zip(names, std.tolist(), strict=True)),
        float(log_root - 0.5 * (e @ e) - 0.5 * log_det),
    )


@dataclass(frozen=True, eq=False)
class _Problem:
    """The least-squares problem: the whitened misfit of the shares (S T,), followed by the entries `names` in units of their prior standard
    deviations, z = entries / size."""

    family: Family
    gains: Gains
    names: tuple[str, ...]
    size: np.ndarray
    root: np.ndarray

    def member(self, z: np.ndarray) -> dict[str, float]:
        """The entries by name, in their own units."""
        return dict(zip(self.names, (z * self.size).tolist(), strict=True))

    def misfit(self, z: np.ndarray) -> np.ndarray:
        """Whitened misfit of the shares, and the scaled entries, (S T + Z,)."""
        left = self.gains.value - self.family.shares(self.member(z))
        return np.concatenate([self.root @ left.ravel(), z])

    def jacobian(self, z: np.ndarray) -> np.ndarray:
        """Derivative of `misfit` with respect to z, (S T + Z, Z)."""
        shares = self.family.shares(self.member(z))
        changes = np.array([self._change(z, k, shares).ravel() for k in range(z.size)])
        return np.concatenate([-self.root @ changes.T, np.eye(z.size)])

    def _change(self, z: np.ndarray, k: int, shares: np.ndarray) -> np.ndarray:
        """Derivative of the shares (S, T) with respect to entry k. Level and scales, which are most of the entries, are logarithms of
        factors."""
        kind, _, which = self.names[k].partition("_")
        if kind in ALWAYS:
            return self.size[k] * shares * (np.arange(len(shares)) == int(which))[:, None] if which else self.size[k] * shares
        step = DIFFERENCE * (np.arange(z.size) == k)
        return (self.family.shares(self.member(z + step)) - shares) / DIFFERENCE


def covariance_root(gains: Gains, scatter: float) -> tuple[np.ndarray, float]:
    """Inverse Cholesky factor of the covariance of all shares of all sessions, (S T, S T), and the logarithm of its determinant."""
    sessions, taxels = gains.value.shape
    covariance = np.zeros((sessions, taxels, sessions, taxels))
    for s in range(sessions):
        covariance[s, :, s] = gains.covariance[s]
    for i in range(taxels):
        covariance[:, i, :, i] += scatter**2 * np.outer(gains.value[:, i], gains.value[:, i])
    factor = np.linalg.cholesky(covariance.reshape(sessions * taxels, -1))
    return np.linalg.inv(factor), -float(np.log(np.diag(factor)).sum())


def first_level(family: Family, gains: Gains) -> float:
    """The log level at which the declared layout fits the measured shares best."""
    plain = family.shares({})
    return float(np.log(max(np.sum(plain * gains.value) / max(np.sum(plain**2), 1e-300), 1e-9)))


def _descend(problem: _Problem, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Levenberg–Marquardt from `z`; returns the minimum, and misfit and Jacobian there."""
    e, damping = problem.misfit(z), 1e-6
    for _ in range(STEPS):
        J = problem.jacobian(z)
        H, g = J.T @ J, J.T @ e
        while damping < 1e8:
            trial = z - np.clip(np.linalg.solve(H + damping * np.diag(np.diag(H)), g), -3.0, 3.0)
            after = problem.misfit(trial)
            if after @ after <= e @ e:
                break
            damping *= 10.0
        else:
            return z, e, J
        gained, z, e, damping = e @ e - after @ after, trial, after, max(damping / 10.0, 1e-9)
        if gained < 1e-6 * max(e @ e, 1e-3):
            break
    return z, e, problem.jacobian(z)
