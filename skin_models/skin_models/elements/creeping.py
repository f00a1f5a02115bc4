"""Driven by force: a spring, a dashpot and Kelvin-Voigt cells in series.

    J(t) = j + t / eta + sum_i j_i (1 - exp(-t / lambda_i)),        fluidity = 1 / eta

Exact for a force that is linear between samples: with e = exp(-dt / lambda) and g = (1 - e) lambda / dt,

    q_i[n] = e q_i[n-1] + j_i ((g - e) f[n-1] + (1 - g) f[n])
    w[n] = w[n-1] + fluidity dt (f[n-1] + f[n]) / 2
    x = j f + w + sum q_i.
"""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter


@dataclass(frozen=True)
class Creeping:
    """A creep function as a sum of exponentials; `compliance` and `delay` (lambda) are arrays (cells,), in m/N and s."""

    j: float = 0.0
    fluidity: float = 0.0
    compliance: np.ndarray = ()
    delay: np.ndarray = ()

    def function(self, t):
        """J(t) for t > 0, m/N."""
        t = np.asarray(t, float)
        grown = -np.expm1(-np.divide.outer(t, np.asarray(self.delay, float)))
        return self.j + t * self.fluidity + grown @ np.asarray(self.compliance, float)

    def initial(self) -> tuple[float, float, np.ndarray]:
        """At rest: force (N), flow (m), depth of every cell (m)."""
        return 0.0, 0.0, np.zeros(len(self.delay))

    def jump(self, state, df: float):
        """The state right after a sudden change of force by df (N): only the spring follows at once."""
        f, flow, cells = state
        return f + df, flow, cells

    def step(self, state, f: float, dt: float):
        """One sample of force, reached linearly: `state, depth = step(state, f, dt)`."""
        last, flow, cells = state
        e, before, now = self._factors(dt)
        cells = e * cells + before * last + now * f
        flow = flow + self.fluidity * dt * 0.5 * (last + f)
        return (f, flow, cells), self.j * f + flow + cells.sum()

    def batch(self, f: np.ndarray, dt: float) -> np.ndarray:
        """A whole history, shape (N,), m: a jump from zero to f[0], then as `step`."""
        f = np.asarray(f, float)
        mean = np.concatenate([[0.0], 0.5 * (f[:-1] + f[1:])])
        x = self.j * f + self.fluidity * dt * np.cumsum(mean)
        for e, before, now in zip(*self._factors(dt), strict=True):
            x += lfilter([now, before], [1.0, -e], f, zi=[-now * f[0]])[0]
        return x

    def _factors(self, dt: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        delay, compliance = np.asarray(self.delay, float), np.asarray(self.compliance, float)
        e = np.exp(-dt / delay)
        g = -np.expm1(-dt / delay) * delay / dt
        return e, compliance * (g - e), compliance * (1.0 - g)
