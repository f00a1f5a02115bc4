"""Continuous-time transfer functions of order 1 or 2, discretised exactly for an input that is linear between samples.

    y(s) = (beta_m s^m + … + beta_0) / (s^n + alpha_{n-1} s^{n-1} + … + alpha_0) u(s),   m <= n

Thesis eq 32 is n = 2, m = 1: beta = (b1, k1) / m, alpha = (b1 + b2, k1 + k2) / m; without the mass it is n = m = 1. The step is that of a
first-order hold: with the companion form x' = A x + B u and u linear over dt,

    x+ = Phi x + (G1 - G2) u + G2 u+,    [Phi G1 G2] = the upper rows of exp([[A, B, 0], [0, 0, 1/dt], [0, 0, 0]] dt)

Derivatives with respect to the coefficients are exact: the same formula at a complex step.
Source: G. F. Franklin, J. D. Powell, M. Workman, Digital Control of Dynamic Systems, 3rd ed., section 6.3.2; W. Squire, G. Trapp,
SIAM Review 40 (1998) 110, for the complex step.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter, lfiltic

STEP = 1e-30


@dataclass(frozen=True)
class TransferFunction:
    """Coefficients with the highest power first: `numerator` beta (m + 1,), `denominator` alpha (n,) without the leading 1."""

    numerator: tuple[float, ...]
    denominator: tuple[float, ...]

    @property
    def theta(self) -> np.ndarray:
        """All coefficients, beta then alpha."""
        return np.array([*self.numerator, *self.denominator])

    def with_theta(self, theta: np.ndarray) -> "TransferFunction":
        """The same structure with other coefficients."""
        cut = len(self.numerator)
        return TransferFunction(tuple(map(float, theta[:cut])), tuple(map(float, theta[cut:])))

    @property
    def stable(self) -> bool:
        """Whether all poles lie in the left half plane; for these orders, whether every alpha is positive."""
        return all(alpha > 0.0 for alpha in self.denominator)

    @property
    def gain(self) -> float:
        """Static gain: output over input at rest."""
        return self.numerator[-1] / self.denominator[-1]

    def at(self, omega: np.ndarray) -> np.ndarray:
        """Complex gain at omega (rad/s)."""
        s = 1j * np.asarray(omega)
        return np.polyval(self.numerator, s) / np.polyval([1.0, *self.denominator], s)

    def simulate(self, u: np.ndarray, dt: float) -> np.ndarray:
        """Output for an input (N,) sampled every dt, from the steady state of its first value."""
        num, den = discretised(self, dt)
        before = np.full(len(self.denominator), u[0])
        state = lfiltic(num, den, self.gain * before, before)
        return lfilter(num, den, u, zi=state)[0]


def discretised(f: TransferFunction, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Numerator (n + 1,) and denominator (n + 1,) in the delay operator."""
    powers, den = discrete_powers(np.array([f.denominator]), dt)
    return np.array(f.numerator) @ powers[0, -len(f.numerator) :], den[0]


def derivatives(f: TransferFunction, dt: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Numerator and denominator, and their derivatives (P, n + 1) with respect to theta."""
    beta, alpha = np.array(f.numerator), np.array(f.denominator)
    n = alpha.size
    moved = alpha + 1j * STEP * np.eye(n + 1, n, -1)  # the first row is alpha itself
    powers, den = discrete_powers(moved, dt)
    used = powers[:, -beta.size :]
    d_num = np.concatenate([used[0].real, (beta @ used[1:]).imag / STEP])
    d_den = np.concatenate([np.zeros((beta.size, n + 1)), den[1:].imag / STEP])
    return beta @ used[0].real, den[0].real, d_num, d_den


def discrete_powers(alpha: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """For every row of alpha (K, n): numerators (K, n + 1, n + 1) of s^n / A, …, s / A, 1 / A, and their denominator (K, n + 1)."""
    count, n = alpha.shape
    big = np.zeros((count, n + 2, n + 2), alpha.dtype)
    big[:, 0, :n], big[:, 0, n], big[:, n, n + 1] = -alpha * dt, dt, 1.0
    big[:, np.arange(1, n), np.arange(n - 1)] = dt
    e = _exponential(big)
    phi, g2 = e[:, :n, :n], e[:, :n, n + 1]
    drive = (phi @ g2[..., None])[..., 0] + e[:, :n, n] - g2
    den = np.empty((count, n + 1), alpha.dtype)
    low = np.empty((count, n, n + 1), alpha.dtype)
    trace = np.trace(phi, axis1=1, axis2=2)
    den[:, 0], den[:, 1] = 1.0, -trace
    low[:, :, 0], low[:, :, 1] = g2, drive - g2 * trace[:, None]
    if n == 2:
        den[:, 2] = phi[:, 0, 0] * phi[:, 1, 1] - phi[:, 0, 1] * phi[:, 1, 0]
        low[:, :, 2] = (phi @ drive[..., None])[..., 0] - trace[:, None] * drive + g2 * den[:, 2:]
    high = den - (alpha[:, None] @ low)[:, 0]
    return np.concatenate([high[:, None], low], axis=1), den


def _exponential(a: np.ndarray) -> np.ndarray:
    """Matrix exponential of a stack (K, m, m) by scaling, Taylor series and squaring; faster than the general routine for small
    matrices."""
    norm = float(np.abs(a.real).sum(axis=-1).max())
    halvings = max(0, math.ceil(math.log2(max(norm, 1e-30) / 0.25)))
    a = a / 2.0**halvings
    term = out = np.eye(a.shape[-1]) + np.zeros_like(a)
    for k in range(1, 13):
        term = term @ a / k
        out = out + term
    for _ in range(halvings):
        out = out @ out
    return out
