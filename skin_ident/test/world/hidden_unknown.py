"""Wrongs that no name of the vocabulary covers: an honest critic says that something is left unexplained."""

import numpy as np
from scipy.signal import bilinear, lfilter

from .effect import Effect, Sensor, Skin


class Breathing:
    """Stiffness that swells and fades with a period of its own, as of a skin on a bladder."""

    def __init__(self, k, period, phase):
        self.k, self.period, self.phase, self.t = k, period, phase, 0.0

    def step(self, u, du, dt):
        self.t += dt
        return self.k * u * float(np.sin(2 * np.pi * self.t / self.period + self.phase)) if u > 0 else 0.0


def _breathing(c):
    period, phase = c.rng.uniform(4, 15), c.rng.uniform(0, 2 * np.pi)
    return Skin(lambda: Breathing(0.1 * c.skin.stiffness, period, phase))


def _echo(c):
    delay, way = c.rng.uniform(0.25, 0.8), c.rng.choice([-1, 1])
    return Sensor(c, lambda y, fine, a, rng: y + 0.03 * way * a * np.interp(fine.t - delay, fine.t, y))


def _ringing(c):
    hertz, zeta = c.rng.uniform(4, 12), c.rng.uniform(0.03, 0.1)
    omega = 2 * np.pi * hertz

    def ring(y, fine, a, rng):
        b, a_ = bilinear([1, 0, 0], [1, 2 * zeta * omega, omega**2], 1 / fine.dt)
        return y + 0.1 * a * lfilter(b, a_, y)

    return Sensor(c, ring)


class TwoSkins(Effect):
    """Stiffness that differs at random from one touch to the next, as if the plunger met another spot each time."""

    def __init__(self, c):
        self.context = c

    def sense(self, fine, a, rng):
        touch = np.cumsum(np.diff((fine.x > 0).astype(int), prepend=0) > 0)
        factor = 1 + 0.03 * a * rng.standard_normal(touch[-1] + 1)[touch]
        fine.force, fine.taxels = fine.force * factor, fine.taxels * factor


FORMS = {"unknown": {"breathing": _breathing, "echo": _echo, "ringing": _ringing, "touch_by_touch": TwoSkins}}
