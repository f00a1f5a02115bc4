"""What may hide between the encoder and the skin."""

from math import exp

import numpy as np
from scipy.signal import lfilter

from .effect import Effect, Sensor

HEAVIEST = 3.0  # kg, of a plunger that a stage still moves


class Play(Effect):
    """Depth lost at reversals: the tip follows once a gap is used up. `soft` rounds it, a wind-up spring as a fraction of the gap; depth is
    right in the middle of it, or `zeroed` at one of its ends."""

    def __init__(self, c, soft=0.0, count=1, zeroed=0):
        self.gap, self.soft, self.count, self.zeroed = 0.01 * c.skin.depth_max, soft, count, zeroed

    def tip(self, x, dt, a, rng):
        gap = a * self.gap
        x = x + self.zeroed * gap / 2
        if self.soft:
            return x - _dahl(x, gap / 2, self.soft * gap)
        weights = np.full(self.count, 1 / self.count)
        return sum(w * _play(x, gap / 2 * (j + 1) / self.count * 2 / (1 + 1 / self.count)) for j, w in enumerate(weights))


def _play(x, half):
    out, at = [], x[0]
    for xi in x.tolist():
        at = min(max(at, xi - half), xi + half)
        out.append(at)
    return np.array(out)


def _dahl(x, limit, stiffness_length):
    """Dry slip with a rounded knee: |z| goes to `limit` within about `stiffness_length`; exact between samples of one direction."""
    z, out = 0.0, []
    for step in np.diff(x, prepend=x[0]).tolist():
        if step:
            end = limit if step > 0 else -limit
            z = end + (z - end) * exp(-abs(step) / (stiffness_length + 1e-12))
        out.append(z)
    return np.array(out)


class SlackEncoder(Effect):
    """An encoder that lags behind the tip: it is driven over a gap, or dragged over a rubbing joint (`soft`, a fraction of the gap)."""

    def __init__(self, c, soft=0.0):
        self.gap, self.soft = 0.01 * c.skin.depth_max, soft

    def encoder(self, x, t, a, rng):
        gap = a * self.gap
        return x - _dahl(x, gap / 2, self.soft * gap) if self.soft else _play(x, gap / 2)


class Mount(Effect):
    """A spring between encoder and tip; a = 1 is ten times the skin's stiffness. `harden` (1/m) makes it stiffer as it stretches."""

    limit, stiff = 3.0, True

    def __init__(self, c, harden=0.0, seat=0.0):
        self.k, self.harden, self.seat = 10 * c.skin.stiffness, harden / c.skin.depth_max, seat * c.skin.depth_max

    def laws(self, laws, a):
        k = self.k / a
        if self.seat:  # a joint that seats: soft at first
            laws.mount_stiffness = lambda s: k * (1 - 0.8 * exp(-s * a / self.seat))
        else:
            laws.mount_stiffness = lambda s: k * (1 + self.harden * s)


class Offset(Effect):
    """The encoder's zero is not the surface: from the start, from a moment on (`jumps`), or more and more (`warms`)."""

    def __init__(self, c, how=""):
        self.size, self.how = 0.01 * c.skin.depth_max * c.rng.choice([-1, 1]), how
        self.at = c.rng.uniform(0.3, 0.7)

    def encoder(self, x, t, a, rng):
        share = {"": 1.0, "jumps": t > self.at * t[-1], "warms": t / (t + self.at * t[-1])}[self.how]
        return x + a * self.size * share


class OffCentre(Effect):
    """Contact lies aside of the declared centre: constant, walking during the session, or leaning with depth."""

    static_array = True

    def __init__(self, c, kind="shift"):
        angle = 0.0 if len(c.skin.positions) > 1 and np.ptp(c.skin.positions[:, 1]) < 1e-9 else c.rng.uniform(0, 2 * np.pi)
        self.direction = 0.001 * np.array([np.cos(angle), np.sin(angle)]) * c.rng.choice([-1, 1])
        self.kind, self.depth = kind, c.skin.depth_max

    def sense(self, fine, a, rng):
        how = {"shift": np.ones_like(fine.t), "walk": fine.t / fine.t[-1], "lean": np.clip(fine.u, 0, None) / self.depth}[self.kind]
        usual = fine.skin.shares()
        for i, place in enumerate(fine.skin.positions):
            away = np.hypot(*(place[:, None] - a * self.direction[:, None] * how))
            fine.taxels[i] *= np.exp(-((away / fine.skin.width) ** 2)) / usual[i]


def _moving_mass(c):
    mass = c.rng.uniform(0.1, 0.3)
    return Sensor(c, lambda y, fine, a, rng: y + a * mass * fine.acceleration, limit=HEAVIEST / mass)


def _sprung_mass(c):
    mass, hertz, zeta = c.rng.uniform(0.1, 0.3), c.rng.uniform(8, 20), c.rng.uniform(0.1, 0.4)
    return Sensor(c, lambda y, fine, a, rng: y + a * mass * _second_order(fine.acceleration, fine.dt, hertz, zeta), limit=HEAVIEST / mass)


def _second_order(y, dt, hertz, zeta):
    from scipy.signal import bilinear

    omega = 2 * np.pi * hertz
    return lfilter(*bilinear([omega**2], [1, 2 * zeta * omega, omega**2], 1 / dt), y)


def _speed(fine):
    return np.gradient(fine.x, fine.dt)


def _coulomb(c):
    size, w0 = 0.02 * c.load, c.skin.depth_max * c.rng.uniform(0.005, 0.02)
    return Sensor(c, lambda y, fine, a, rng: y + a * size * np.tanh(_speed(fine) / w0))


def _stribeck(c):
    size, w0 = 0.02 * c.load, c.skin.depth_max * 0.01
    more, ws = c.rng.uniform(0.4, 1.0), c.skin.depth_max * c.rng.uniform(0.3, 1.0)

    def force(y, fine, a, rng):
        v = _speed(fine)
        return y + a * size * np.tanh(v / w0) * (1 + more * np.exp(-((v / ws) ** 2)))

    return Sensor(c, force)


def _lugre(c):
    size, slip = 0.02 * c.load, c.rng.uniform(0.003, 0.02) * c.skin.depth_max
    return Sensor(c, lambda y, fine, a, rng: y + a * size * _dahl(fine.x, 1.0, slip))


def _loaded(c):
    size, w0 = 0.01 * c.load, c.skin.depth_max * 0.01
    share = c.rng.uniform(0.5, 2.0)
    return Sensor(c, lambda y, fine, a, rng: y + a * size * (1 + share * np.abs(y) / c.load) * np.tanh(_speed(fine) / w0))


FORMS = {
    "backlash": {
        "play": Play, "rounded": lambda c: Play(c, soft=c.rng.uniform(0.15, 0.4)), "several": lambda c: Play(c, count=3),
        "zeroed": lambda c: Play(c, zeroed=c.rng.choice([-1, 1])),
        "slack_encoder": SlackEncoder, "dragged_encoder": lambda c: SlackEncoder(c, c.rng.uniform(0.15, 0.4)),
    },
    "mount_compliance": {
        "spring": Mount, "hardening": lambda c: Mount(c, harden=c.rng.uniform(3, 15)),
        "seating": lambda c: Mount(c, seat=c.rng.uniform(0.02, 0.1)),
    },
    "position_offset": {"constant": Offset, "lost_counts": lambda c: Offset(c, "jumps"), "warming": lambda c: Offset(c, "warms")},
    "off_centre": {"shift": OffCentre, "walk": lambda c: OffCentre(c, "walk"), "lean": lambda c: OffCentre(c, "lean")},
    "inertia": {"mass": _moving_mass, "sprung": _sprung_mass},
    "friction": {"coulomb": _coulomb, "stribeck": _stribeck, "lugre": _lugre, "loaded": _loaded},
}  # fmt: skip
