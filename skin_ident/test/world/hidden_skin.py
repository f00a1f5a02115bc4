"""What may hide in the skin: its shape, its arms, its loops. Every form is a function of a `Context` and gives an `Effect`."""

import numpy as np

from . import memory
from .effect import Skin


class Shape:
    """A force of depth alone, from a table (0 off the skin)."""

    def __init__(self, function, deepest):
        grid = np.linspace(0, 1.3 * deepest, 800)
        self.table, self.per = np.asarray(function(grid), float).tolist(), 799 / (1.3 * deepest)

    def step(self, u, du, dt):
        if u <= 0:
            return 0.0
        at = min(u * self.per, 798.0)
        i = int(at)
        return self.table[i] + (at - i) * (self.table[i + 1] - self.table[i])


def _shape(function):
    def build(c):
        draw = function(c.rng)
        d, scale = c.skin.depth_max, c.load
        return Skin(lambda: Shape(lambda u: scale * draw(u / d), d))

    return build


def _fung(rng):
    c = rng.uniform(1.5, 4.0)
    return lambda y: (np.expm1(c * y) - c * y) / (np.expm1(c) - c)


def _ogden(rng):
    alpha, strain = rng.choice([-3.0, 5.0, 8.0]), rng.uniform(0.25, 0.5)

    def force(y):
        stretch = 1 - strain * np.minimum(y, 1.2)
        return (stretch ** (-alpha / 2 - 1) - stretch ** (alpha - 1)) / alpha / strain - 1.5 * y

    return force


def _foam(rng):
    knee, dense = rng.uniform(0.15, 0.35), rng.uniform(1.2, 1.5)
    return lambda y: knee * np.tanh(y / knee) - y + 0.15 * ((1 - np.minimum(y, 1.15) / dense) ** -2 - 1)


def _bilinear(rng):
    at, width = rng.uniform(0.3, 0.7), rng.uniform(0.01, 0.08)
    return lambda y: width * (np.logaddexp(0, (y - at) / width) - np.logaddexp(0, -at / width))


def _contact_area(rng):
    power = rng.uniform(1.3, 2.0)
    return lambda y: y**power - y


def _relaxation(make):
    def build(c):
        total = 0.4 * c.skin.stiffness
        fixed = make(c.rng, total)
        return Skin(fixed)

    return build


def _prony(count):
    def make(rng, total):
        taus = (
            np.exp(np.sort(rng.uniform(np.log(0.15), np.log(12), count)))
            if count < 3
            else np.array([0.12, 1.1, 11]) * np.exp(rng.uniform(-0.4, 0.4, 3))
        )
        weights = rng.dirichlet(np.full(count, 4.0))
        return lambda: memory.Arms(total * weights, taus)

    return make


def _stretched(rng, total):
    tau, beta = np.exp(rng.uniform(np.log(0.4), np.log(5))), rng.uniform(0.35, 0.65)
    arms = memory.kww(total, tau, beta)
    return lambda: memory.Arms(arms.g, arms.tau)


def _power(rng, total):
    alpha = rng.uniform(0.1, 0.35)
    return lambda: memory.power_law(total, alpha)


def _log_decay(rng, total):
    shortest = rng.uniform(0.03, 0.1)
    return lambda: memory.power_law(total, 0.0, shortest, 100.0)


def _eyring_arm(c):
    q0 = c.rng.uniform(0.03, 0.15) * c.skin.depth_max
    rate = q0 / np.exp(c.rng.uniform(np.log(0.5), np.log(5)))
    return Skin(lambda: memory.EyringArm(0.4 * c.skin.stiffness, q0, rate))


def _relays(c):
    rng, d = c.rng, c.skin.depth_max
    low = rng.uniform(0.01, 0.9, 300) * d
    high = low + rng.exponential(rng.uniform(0.1, 0.3), 300) * d + 0.01 * d
    return Skin(lambda: memory.Relays(c.load, high, low, d / 300))


def _bouc_wen(c):
    z0, n, beta = c.rng.uniform(0.05, 0.2) * c.skin.depth_max, c.rng.uniform(1.0, 2.0), c.rng.uniform(0.5, 0.8)
    return Skin(lambda: memory.BoucWen(0.3 * c.load / z0, z0, n, beta))


def _dahl(c):
    z0 = c.rng.uniform(0.04, 0.15) * c.skin.depth_max
    return Skin(lambda: memory.BoucWen(0.3 * c.load / z0, z0, 1.0, 1.0))


def _sliders(c):
    limits = c.skin.depth_max * np.geomspace(0.02, 0.4, 6) * c.rng.uniform(0.7, 1.3)
    moduli = 0.3 * c.load / limits * c.rng.dirichlet(np.full(6, 3.0))
    return Skin(lambda: memory.Plays(moduli, limits))


def _pressed(c):
    z0, power, d = c.rng.uniform(0.04, 0.15) * c.skin.depth_max, c.rng.uniform(0.8, 1.2), c.skin.depth_max
    return Skin(lambda: memory.Pressed(memory.BoucWen(0.3 * c.load / z0, z0, 1.5, 0.7), d, power))


FORMS = {
    "nonlinear_stiffness": {
        "fung": _shape(_fung), "ogden": _shape(_ogden), "foam": _shape(_foam), "bilinear": _shape(_bilinear),
        "contact_area": _shape(_contact_area),
    },
    "stress_relaxation": {
        "prony2": _relaxation(_prony(2)), "prony3": _relaxation(_prony(3)), "stretched": _relaxation(_stretched),
        "power_law": _relaxation(_power), "log_decay": _relaxation(_log_decay), "eyring_arm": _eyring_arm,
    },
    "hysteresis": {"preisach": _relays, "bouc_wen": _bouc_wen, "dahl": _dahl, "sliders": _sliders, "pressed": _pressed},
}  # fmt: skip
