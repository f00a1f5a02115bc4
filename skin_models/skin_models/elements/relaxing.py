"""Driven by depth: a spring, a dashpot and Maxwell arms in parallel.

    G(t) = k + b delta(t) + sum_i k_i exp(-t / tau_i)

Exact for a depth that is linear between samples: with e = exp(-dt / tau),

    f_i[n] = e f_i[n-1] + k_i tau_i (1 - e) v,        v = (x[n] - x[n-1]) / dt,        f = k x + b v + sum f_i.
"""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter


@dataclass(frozen=True)
class Relaxing:
    """A relaxation function as a sum of exponentials; `stiffness` and `tau` are arrays (arms,), in N/m and s."""

    k: float = 0.0
    b: float = 0.0
    stiffness: np.ndarray = ()
    tau: np.ndarray = ()

    def function(self, t):
        """G(t) for t > 0, N/m."""
        decay = np.exp(-np.divide.outer(np.asarray(t, float), np.asarray(self.tau, float)))
        return self.k + decay @ np.asarray(self.stiffness, float)

    def modulus(self, omega):
        """Complex stiffness k + i omega b + sum k_i i omega tau_i / (1 + i omega tau_i), N/m."""
        s = 1j * np.asarray(omega, float)
        turn = np.multiply.outer(s, np.asarray(self.tau, float))
        return self.k + self.b * s + (turn / (1.0 + turn)) @ np.asarray(self.stiffness, complex)

    def initial(self) -> tuple[float, np.ndarray]:
        """At rest: depth (m) and the force of every arm (N)."""
        return 0.0, np.zeros(len(self.tau))

    def jump(self, state, dx: float):
        """The state right after a sudden change of depth by dx (m). A dashpot's impulse is over."""
        x, arms = state
        return x + dx, arms + np.asarray(self.stiffness, float) * dx

    def step(self, state, x: float, dt: float):
        """One sample of depth, reached at constant speed: `state, force = step(state, x, dt)`. The force is that at its end."""
        last, arms = state
        e, gain = self._factors(dt)
        v = (x - last) / dt
        arms = e * arms + gain * v
        return (x, arms), self.k * x + self.b * v + arms.sum()

    def batch(self, x: np.ndarray, dt: float) -> np.ndarray:
        """A whole history, shape (N,), N: a jump from zero to x[0], then as `step`."""
        x = np.asarray(x, float)
        v = np.diff(x, prepend=x[:1]) / dt
        f = self.k * x + self.b * v
        for k, e, gain in zip(self.stiffness, *self._factors(dt), strict=True):
            f += lfilter([gain], [1.0, -e], v, zi=[k * x[0]])[0]  # v[0] = 0, so the first output is that of the jump
        return f

    def _factors(self, dt: float) -> tuple[np.ndarray, np.ndarray]:
        tau = np.asarray(self.tau, float)
        return np.exp(-dt / tau), -np.asarray(self.stiffness, float) * tau * np.expm1(-dt / tau)
