"""What may hide in the skin: its damping, its damage, and how it meets the plunger and the taxel."""

from math import asinh, copysign, erf, exp, sqrt

import numpy as np

from .effect import Effect, Scaled, Sensor, Skin


class Rate(Effect):
    """A force of speed (and depth) beyond the proportional damping."""

    def __init__(self, function):
        self.function = function

    def laws(self, laws, a):
        before, own = laws.rate, self.function
        laws.rate = (lambda u, w: before(u, w) + a * own(u, w)) if before else (lambda u, w: a * own(u, w))


def _rate_power(c):
    n, w0, f = c.rng.uniform(0.25, 0.6), 2 * c.skin.depth_max, 0.3 * c.load
    return Rate(lambda u, w: copysign(f * (abs(w) / w0) ** n, w))


def _hunt_crossley(c):
    n, w0, f, d = c.rng.uniform(1.0, 2.0), 2 * c.skin.depth_max, 0.3 * c.load, c.skin.depth_max
    return Rate(lambda u, w: f * (u / d) ** n * w / w0 if u > 0 else 0.0)


def _eyring(c):
    w0, f = c.skin.depth_max * np.exp(c.rng.uniform(np.log(0.03), np.log(0.3))), 0.08 * c.load
    return Rate(lambda u, w: f * asinh(w / w0))


def _thickening(c):
    w0, f, n = 2 * c.skin.depth_max, 0.3 * c.load, c.rng.uniform(1.6, 2.4)
    return Rate(lambda u, w: copysign(f * (min(abs(w), 10 * w0) / w0) ** n, w))


class Mullins:
    """Ogden-Roxburgh: below the largest energy so far the force is (1 - erf((Wm - W)/m) / r) of the virgin one."""

    def __init__(self, k, d, r, m, heal):
        self.k, self.m, self.r, self.heal = k, m * k * d * d, r, heal
        self.largest = 0.0

    def step(self, u, du, dt):
        energy = 0.5 * self.k * u * u if u > 0 else 0.0
        self.largest = max(self.largest * exp(-dt / self.heal), energy)
        gap = (self.largest - energy) / self.m
        return -self.k * u * (gap if gap < 0.05 else erf(gap)) / self.r if gap > 0 and u > 0 else 0.0


class Damage:
    """Stiffness lost to the largest depth um so far: the force is less by k u (exp(-u/c) - exp(-um/c)), by nothing on the virgin curve."""

    def __init__(self, k, c, heal=1e9):
        self.k, self.c, self.heal, self.deepest = k, c, heal, 0.0

    def step(self, u, du, dt):
        self.deepest = max(self.deepest * exp(-dt / self.heal), u)
        return -self.k * u * (exp(-u / self.c) - exp(-self.deepest / self.c)) if u > 0 else 0.0


class Fatigue:
    """Stiffness lost to the path travelled in the skin, most in the first cycles."""

    def __init__(self, k, c):
        self.k, self.c, self.path = k, c, 0.0

    def step(self, u, du, dt):
        if u <= 0:
            return 0.0
        self.path += abs(du)
        return -self.k * u * (1 - exp(-self.path / self.c))


def _mullins(c):
    m, heal = c.rng.uniform(0.05, 0.25), 1e9
    return Skin(lambda: Mullins(0.5 * c.skin.stiffness, c.skin.depth_max, 2.0, m, heal))


def _mullins_healing(c):
    m, heal = c.rng.uniform(0.05, 0.25), c.rng.uniform(40, 200)
    return Skin(lambda: Mullins(0.5 * c.skin.stiffness, c.skin.depth_max, 2.0, m, heal))


def _damage(c):
    scale = c.rng.uniform(0.4, 1.0) * c.skin.depth_max
    return Skin(lambda: Damage(0.3 * c.skin.stiffness, scale))


def _fatigue(c):
    scale = c.rng.uniform(3, 10) * c.skin.depth_max
    return Skin(lambda: Fatigue(0.3 * c.skin.stiffness, scale))


class Adhesion(Effect):
    """Holds on to a leaving plunger up to a pull that may grow with speed, with a neck that also pulls in contact."""

    def __init__(self, c, neck=0.0, growth=0.0):
        self.pull, self.w0, self.growth = 0.05 * c.load, 2 * c.skin.depth_max, growth
        self.neck, self.limit = neck * c.skin.depth_max, 0.6 * 0.0003 * c.skin.stiffness

    def laws(self, laws, a):
        pull = min(a * self.pull, self.limit)
        laws.pull = lambda w: pull * (1 + self.growth * sqrt(min(abs(w) / self.w0, 4.0))) / (1 + 2 * self.growth)
        if self.neck:
            laws.elements.append(Scaled(Neck(self.neck), -0.5 * pull))


class Neck:
    """exp(-|u|/delta) once the surfaces have met, gone once they have parted for good."""

    def __init__(self, delta):
        self.delta, self.met = delta, False

    def step(self, u, du, dt):
        self.met = self.met or u > 0.5 * self.delta
        return exp(-abs(u) / self.delta) if self.met else 0.0


def _dead_threshold(c):
    return Sensor(c, lambda y, fine, a, rng: np.maximum(y - a * 0.05 * c.load, 0) + np.minimum(y, 0))


def _dead_smooth(c):
    return Sensor(c, lambda y, fine, a, rng: y - 0.05 * a * c.load * np.tanh(y / (0.05 * a * c.load + 1e-12)))


def _dead_gradual(c):
    return Sensor(c, lambda y, fine, a, rng: y**3 / (y**2 + (0.05 * a * c.load) ** 2 + 1e-24))


def _dead_gap(c):
    d = c.skin.depth_max

    def gap(y, fine, a, rng):
        lost = min(0.05 * a, 0.8) * d
        return y * np.clip((fine.u - lost) / np.maximum(fine.u, 0.02 * d), 0, None)

    return Sensor(c, gap)


FORMS = {
    "rate_dependence": {
        "power": _rate_power, "hunt_crossley": _hunt_crossley, "eyring": _eyring, "thickening": _thickening,
    },
    "cyclic_softening": {
        "mullins": _mullins, "mullins_healing": _mullins_healing, "damage": _damage, "fatigue": _fatigue,
    },
    "adhesion": {
        "pull_off": Adhesion, "jkr": lambda c: Adhesion(c, neck=c.rng.uniform(0.03, 0.1)),
        "tacky": lambda c: Adhesion(c, growth=c.rng.uniform(0.5, 2)),
    },
    "dead_zone": {"threshold": _dead_threshold, "smooth": _dead_smooth, "gradual": _dead_gradual, "gap": _dead_gap},
}  # fmt: skip
