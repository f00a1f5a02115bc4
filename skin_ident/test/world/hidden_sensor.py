"""What may hide in a sensor's chain, before its converter."""

import numpy as np
from scipy.signal import lfilter

from . import memory
from .effect import Effect, Sampled, Sensor, channels


def _gain_static(c):
    way = c.rng.choice([-1, 1])
    return Sensor(c, lambda y, fine, a, rng: y * max(1 + 0.05 * way * a, 0.0), static_array=True, limit=10.0)  # half as much again


def _gain_step(c):
    way, at = c.rng.choice([-1, 1]), c.rng.uniform(0.25, 0.75)
    return Sensor(c, lambda y, fine, a, rng: y * np.maximum(1 + 0.05 * way * a * (fine.t > at * fine.t[-1]), 0.0))


def _gain_loose(c):
    """A bad contact that switches between two gains."""
    way, cuts = c.rng.choice([-1, 1]), np.sort(c.rng.uniform(0.1, 0.9, 4))
    return Sensor(c, lambda y, fine, a, rng: y * (1 + 0.05 * way * a * (np.searchsorted(cuts, fine.t / fine.t[-1]) % 2)))


def _offset(c):
    way = c.rng.choice([-1, 1])
    return Sensor(c, lambda y, fine, a, rng: y + 0.02 * way * a * c.load)


def _offset_each(c):
    """A tare that was taken anew, and badly, before each session."""
    return Sensor(c, lambda y, fine, a, rng: y + 0.02 * a * c.load * rng.choice([-1, 1]) * rng.uniform(0.6, 1.4))


def _drift(shape):
    def build(c):
        way, part = c.rng.choice([-1, 1]), c.rng.uniform(0.05, 0.3)
        return Sensor(c, lambda y, fine, a, rng: y + 0.03 * way * a * c.load * shape(fine.t / fine.t[-1], part, rng))

    return build


def _walk(s, part, rng):
    knots = np.cumsum(rng.standard_normal(200)) / np.sqrt(200)
    return np.interp(s, np.linspace(0, 1, 200), knots - knots[0])


def _gain_creep(c):
    way, t0 = c.rng.choice([-1, 1]), c.rng.uniform(0.5, 5)
    return Sensor(c, lambda y, fine, a, rng: y * (1 + 0.02 * way * a * np.log1p(fine.t / t0)))


def _creep(c):
    """A reading that goes on rising under load by the logarithm of time, and comes back without: many slow elements in a row."""
    taus = np.geomspace(1.0, 100.0, 9)
    return Sensor(c, lambda y, fine, a, rng: y + 0.004 * a * sum(_low_pass(y, fine.dt, tau) for tau in taus))


def _peak(y):
    return np.max(np.abs(y)) + 1e-12


def _level(c, a):
    """Ceiling (N), lower as a grows."""
    part = c.skin.fraction if c.where.startswith("taxel") else 1.0
    return 6 * c.load * part / (1 + a)


def _clip_hard(c):
    return Sampled(c, lambda y, t, a, rng: np.minimum(y, _level(c, a)), "analogue")


def _clip_soft(c):
    sharp = c.rng.uniform(4, 12)

    def clip(y, t, a, rng):
        r = np.clip(y / _level(c, a), 0, None)
        return np.where(y > 0, y / (1 + r**sharp) ** (1 / sharp), y)

    return Sampled(c, clip, "analogue")


def _clip_leaky(c):
    slope = c.rng.uniform(0.03, 0.1)
    return Sampled(c, lambda y, t, a, rng: y - (1 - slope) * np.maximum(y - _level(c, a), 0), "analogue")


class Steps(Effect):
    """A converter with steps (1 + a) times the declared ones; `cut` rounds down and centres, as an integer cast does."""

    by_difference = True

    def __init__(self, c, cut=False):
        self.where, self.cut = c.where, cut

    def steps(self, steps, a):
        steps = dict(steps, taxels=np.array(steps["taxels"]))
        touched = ["x"] if self.where == "rig" else channels(self.where, len(steps["taxels"]))
        for c in touched:
            if c in ("x", "force"):
                steps[c] *= 1 + a
            else:
                steps["taxels"][c] *= 1 + a
        steps["cut"] = steps["cut"] + touched if self.cut else steps["cut"]
        return steps


def _low_pass(y, dt, tau):
    k = 1 - np.exp(-dt / max(tau, 1e-9))
    return lfilter([k], [1, k - 1], y, zi=[(1 - k) * y[0]])[0]


def _lag_one(c):
    return Sensor(c, lambda y, fine, a, rng: _low_pass(y, fine.dt, 0.02 * a))


def _lag_two(c):
    ratio = c.rng.uniform(0.3, 1.0)
    return Sensor(c, lambda y, fine, a, rng: _low_pass(_low_pass(y, fine.dt, 0.014 * a), fine.dt, 0.014 * ratio * a))


def _lag_averaged(c):
    """An amplifier that returns the mean of its last readings."""

    def mean(y, fine, a, rng):
        n = max(1, round(0.04 * a / fine.dt))
        sums = np.cumsum(np.concatenate([np.full(n, y[0]), y]))
        return (sums[n:] - sums[:-n]) / n

    return Sensor(c, mean)


def _lag_partial(c):
    """Most of the signal is prompt, a part comes late: a sensor that creeps after its load."""
    part, slow = c.rng.uniform(0.4, 0.7), c.rng.uniform(1.0, 3.0)
    return Sensor(c, lambda y, fine, a, rng: (1 - part) * y + part * _low_pass(y, fine.dt, 0.03 * slow * a))


def _lag_one_sided(c):
    """Quick to rise, slow to fall, like a charge that leaks off."""

    def follow(y, fine, a, rng):
        k_up, k_down = (1 - np.exp(-fine.dt / max(T, 1e-9)) for T in (0.01 * a, 0.03 * a))
        out, at = [], y[0]
        for value in y.tolist():
            at += (k_up if value > at else k_down) * (value - at)
            out.append(at)
        return np.array(out)

    return Sensor(c, follow)


class _Loop:
    """Memory of a sensor: an element driven by load over typical load. `way` -1: the reading lags, as it mostly does."""

    def __init__(self, c, make):
        self.c, self.make, self.way = c, make, c.rng.choice([-1, -1, -1, 1])

    def __call__(self, y, fine, a, rng):
        element, unit = self.make(), self.c.load * (_peak(y) / (2 * self.c.load))
        z = y / unit
        steps = np.diff(z, prepend=z[0]).tolist()
        return y + self.way * a * unit * np.array([element.step(u, du, fine.dt) for u, du in zip(z.tolist(), steps, strict=True)])


def _loop(kind):
    def build(c):
        z0 = c.rng.uniform(0.08, 0.3)
        low = c.rng.uniform(-0.1, 1.8, 300)
        high = low + c.rng.exponential(0.4, 300) + 0.02
        limits = np.geomspace(0.04, 0.8, 6)
        make = {
            "preisach": lambda: memory.Relays(0.2, high, low, 0.007),
            "bouc_wen": lambda: memory.BoucWen(0.1 / z0, z0, 1.5, 0.65),
            "sliders": lambda: memory.Plays(0.1 / limits / 6, limits),
            "pressed": lambda: memory.Pressed(memory.BoucWen(0.1 / z0, z0, 1.5, 0.65), 1.0, float(c.rng.uniform(0.5, 1.0))),
        }[kind]
        return Sensor(c, _Loop(c, make))

    return build


class Late(Effect):
    """Channels late by `a` times 5 ms (constant), growing (a clock that runs slow), or in a step (a lost buffer)."""

    def __init__(self, c, kind="delay"):
        n = len(c.skin.positions)
        self.kind, self.at = kind, c.rng.uniform(0.3, 0.7)
        self.channels = [["force"], ["taxels"], ["force", "taxels"]][c.rng.integers(3)] if n else ["force"]

    def sense(self, fine, a, rng):
        span = fine.t[-1] - fine.t[0]
        how = {"delay": 1.0, "skew": fine.t / span * 2, "buffer": 2.0 * (fine.t > self.at * span)}[self.kind]
        late = fine.t - 0.005 * a * how
        if "force" in self.channels:
            fine.force = np.interp(late, fine.t, fine.force)
        if "taxels" in self.channels:
            fine.taxels = np.array([np.interp(late, fine.t, y) for y in fine.taxels])


class Crosstalk(Effect):
    """Taxels repeat one another: the neighbour only, a common part, or a neighbour's signal that comes smeared."""

    static_array = True

    def __init__(self, c, kind="neighbour"):
        self.kind, self.n = kind, len(c.skin.positions)
        self.one = int(c.where.split("_")[1]) if c.where.startswith("taxel_") else None

    def sense(self, fine, a, rng):
        before = fine.taxels.copy()
        for i in range(self.n) if self.one is None else [self.one]:
            near = [j for j in (i - 1, i + 1) if 0 <= j < self.n]
            heard = before.mean(0) if self.kind == "common" else before[near].sum(0) if near else 0.0
            if self.kind == "smeared":
                heard = _low_pass(heard, fine.dt, 0.05)
            fine.taxels[i] = before[i] + 0.03 * a * heard


def _hum(kind):
    def build(c):
        mains = c.rng.choice([50.0, 60.0]) + c.rng.uniform(-0.15, 0.15)
        slow = c.rng.uniform(0.7, 9.0)
        phase = c.rng.uniform(0, 2 * np.pi, 3)

        def hum(y, t, a, rng):
            t = t + 2e-4 * rng.standard_normal(t.size)  # the sampling clock jitters
            wave = np.sin(2 * np.pi * mains * t + phase[0])
            if kind == "harmonics":
                wave = wave + 0.6 * np.sin(6 * np.pi * mains * t + phase[1]) + 0.4 * np.sin(4 * np.pi * mains * t + phase[2])
            if kind == "bursts":
                wave = 2 * wave * (np.sin(2 * np.pi * 0.11 * t + phase[1]) > 0.5)
            if kind == "machine":  # a pump or fan whose speed wanders a little
                wander = np.cumsum(rng.standard_normal(t.size)) * 0.005
                wave = np.sin(2 * np.pi * slow * t + phase[1] + wander)
            return y + a * c.force_step * wave

        return Sampled(c, hum, "analogue")

    return build


FORMS = {
    "gain_error": {"static": _gain_static, "step": _gain_step, "loose": _gain_loose},
    "force_offset": {"constant": _offset, "each_session": _offset_each},
    "drift": {
        "linear": _drift(lambda s, part, rng: s), "logarithmic": _drift(lambda s, part, rng: np.log1p(s / (part / 10))),
        "warm_up": _drift(lambda s, part, rng: 1 - np.exp(-s / part)), "random_walk": _drift(_walk), "gain_creep": _gain_creep,
        "creep_under_load": _creep,
    },
    "saturation": {"hard": _clip_hard, "soft": _clip_soft, "leaky": _clip_leaky},
    "quantization": {"round": Steps, "cut": lambda c: Steps(c, cut=True)},
    "lag": {"one_pole": _lag_one, "two_pole": _lag_two, "averaged": _lag_averaged, "partial": _lag_partial, "one_sided": _lag_one_sided},
    "hysteresis": {"preisach": _loop("preisach"), "bouc_wen": _loop("bouc_wen"), "sliders": _loop("sliders"), "pressed": _loop("pressed")},
    "time_shift": {"delay": Late, "skew": lambda c: Late(c, "skew"), "buffer": lambda c: Late(c, "buffer")},
    "crosstalk": {"neighbour": Crosstalk, "common": lambda c: Crosstalk(c, "common"), "smeared": lambda c: Crosstalk(c, "smeared")},
    "interference": {"mains": _hum("mains"), "harmonics": _hum("harmonics"), "bursts": _hum("bursts"), "machine": _hum("machine")},
}  # fmt: skip
