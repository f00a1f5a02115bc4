"""Elements with a memory: relaxing arms, and loops that do not depend on rate."""

from math import atanh, copysign, exp, tanh

import numpy as np


class Arms:
    """Springs g_j (N/m), each in series with a dashpot: q_j' = u' - q_j / tau_j, force sum g_j q_j."""

    def __init__(self, moduli, taus):
        self.g, self.tau, self.q = list(moduli), list(taus), [0.0] * len(taus)
        self.dt, self.rows = 0.0, []

    def step(self, u, du, dt):
        if dt != self.dt:
            self.dt = dt
            self.rows = [(g, exp(-dt / T), T * (1 - exp(-dt / T)) / dt) for g, T in zip(self.g, self.tau, strict=True)]
        self.q = [q * e + c * du for q, (_, e, c) in zip(self.q, self.rows, strict=True)]
        return sum([q * g for q, (g, _, _) in zip(self.q, self.rows, strict=True)])


class EyringArm:
    """A spring g in series with a dashpot that flows as sinh: q' = u' - r sinh(q / q0). Decays like a logarithm from large loads."""

    def __init__(self, g, q0, rate):
        self.g, self.q0, self.rate, self.q = g, q0, rate, 0.0

    def step(self, u, du, dt):
        half = tanh((self.q + du) / (2 * self.q0)) * exp(-self.rate * dt / self.q0)
        self.q = 2 * self.q0 * atanh(half)
        return self.g * self.q


class BoucWen:
    """z' = u' (1 - |z/z0|^n (beta sgn(z u') + gamma)), force g z."""

    def __init__(self, g, z0, n, beta):
        self.g, self.z0, self.n, self.beta, self.z = g, z0, n, beta, 0.0

    def step(self, u, du, dt):
        z = self.z
        for _ in range(1 + int(8 * abs(du) / self.z0)):
            part = du / (1 + int(8 * abs(du) / self.z0))
            z += part * (1 - abs(z / self.z0) ** self.n * (copysign(self.beta, z * part) + 1 - self.beta))
        self.z = z
        return self.g * z


class Pressed:
    """A loop that grows with the pressure on what slides: that of `loop` at the depth d, and in proportion to (u / d)^power elsewhere."""

    def __init__(self, loop, depth, power):
        self.loop, self.depth, self.power = loop, depth, power

    def step(self, u, du, dt):
        return self.loop.step(u, du, dt) * (max(u, 0.0) / self.depth) ** self.power


class Plays:
    """Prandtl-Ishlinskii: springs g_j in series with dry sliders that slip at r_j (m)."""

    def __init__(self, moduli, limits):
        self.g, self.r, self.z = list(moduli), list(limits), [0.0] * len(limits)

    def step(self, u, du, dt):
        self.z = [min(r, max(-r, z + du)) for z, r in zip(self.z, self.r, strict=True)]
        return sum([g * z for g, z in zip(self.g, self.z, strict=True)])


class Relays:
    """Preisach: a cloud of relays, up above alpha, down below beta (m); force is height times minus the mean of their states.

    A force on the skin must take up work, so a relay that is late adds force on the way in. The middle between the rising and
    the falling curve is taken out: that is a shape, which another cause has the name for.
    """

    def __init__(self, height, alpha, beta, grain):
        self.height, self.alpha, self.beta, self.grain = height, alpha, beta, grain
        self.state, self.last, self.value = np.zeros(alpha.size), -1e9, 0.0
        self.rise, self.fall = np.sort(alpha), np.sort(beta)

    def step(self, u, du, dt):
        if abs(u - self.last) > self.grain:
            self.last = u
            self.state[u >= self.alpha] = 1.0
            self.state[u <= self.beta] = 0.0
            middle = 0.5 * (np.searchsorted(self.rise, u, "right") + np.searchsorted(self.fall, u))
            self.value = self.height * float(middle / self.state.size - self.state.mean())
        return self.value


def kww(total, tau, beta):
    """Arms that together decay as exp(-(t/tau)^beta), by non-negative least squares."""
    from scipy.optimize import nnls

    taus = np.geomspace(tau / 300, tau * 100, 14)
    t = np.geomspace(tau / 500, tau * 30, 200)
    weights = nnls(np.exp(-t[:, None] / taus), np.exp(-((t / tau) ** beta)))[0]
    keep = weights > 1e-4
    return Arms(total * weights[keep] / weights.sum(), taus[keep])


def power_law(total, alpha, shortest=0.02, longest=60.0):
    """A spring-pot by many arms with moduli falling as tau^-alpha."""
    taus = np.geomspace(shortest, longest, 10)
    weights = taus**-alpha
    return Arms(total * weights / weights.sum(), taus)
