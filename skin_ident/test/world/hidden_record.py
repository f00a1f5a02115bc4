"""What may hide in the record: outliers, silent taxels, noise that was declared otherwise, and errors of data."""

from dataclasses import replace

import numpy as np

from .effect import Effect, Sampled


def _spikes(c):
    share = c.rng.uniform(0.002, 0.008)

    def spike(y, t, a, rng):
        hit = rng.random(y.size) < share
        return y + a * hit * rng.choice([-1, 1], y.size) * _unit(c) * rng.uniform(5, 25, y.size)

    return Sampled(c, spike)


def _discharges(c):
    """Static electricity: away at once, and back within a few samples."""
    tail = np.array([1.0, *np.cumprod(c.rng.uniform(0.2, 0.42, 7))])

    def spark(y, t, a, rng):
        hit = (rng.random(y.size) < 0.002) * rng.choice([-1, 1], y.size) * rng.uniform(10, 25, y.size)
        return y + a * _unit(c) * np.convolve(hit, tail)[: y.size]

    return Sampled(c, spark)


def _unit(c):
    return 2e-6 if c.where == "rig" else c.force_step


def _dropouts(c):
    gap = c.rng.integers(1, 8)

    def drop(y, t, a, rng):
        return np.where(_stretches(rng, y.size, 0.004 * a, gap), 0.0, y)

    return Sampled(c, drop)


def _frozen(c):
    gap = c.rng.integers(5, 30)

    def freeze(y, t, a, rng):
        held = _stretches(rng, y.size, 0.004 * a, gap)
        source = np.maximum.accumulate(np.where(held, 0, np.arange(y.size)))
        return y[source]

    return Sampled(c, freeze)


def _stretches(rng, n, share, length):
    """Mask of stretches of `length` samples that cover about `share` of the record; a larger share contains the smaller one."""
    order = rng.permutation(n)[: max(1, round(min(share, 0.5) * n / length))]
    mask = np.zeros(n + int(length), bool)
    for start in order:
        mask[start : start + length] = True
    return mask[:n]


def _bursts(c):
    def burst(y, t, a, rng):
        on = _stretches(rng, y.size, 0.02, 25)
        return y + a * on * _unit(c) * 6 * rng.standard_normal(y.size)

    return Sampled(c, burst)


def _silent(kind):
    def build(c):
        start = 0.0 if kind != "dies" else c.rng.uniform(0.2, 0.6)
        level = c.rng.uniform(0.5, 4.0) if kind == "stuck" else 0.0

        def silence(y, t, a, rng):
            dead = t >= start * t[-1]
            weak = 0.0 if kind == "stuck" else 0.3 * c.force_step * rng.standard_normal(y.size)
            return np.where(dead, level + weak, y)

        return Sampled(c, silence, fixed=True)

    return build


class OtherNoise(Effect):
    """Noise that is not as declared: level, colour or growth with load."""

    fixed = True

    def __init__(self, c, kind):
        self.where, self.kind = c.where, kind

    def noise(self, channel, noise, a):
        mine = self.where.startswith("taxel") if channel != "force" else self.where == "load_cell"
        if not mine:
            return noise
        if self.kind == "level":
            return replace(noise, level=noise.level * (1 + 2 * a))
        return replace(noise, kind="ar", rho=0.97) if self.kind == "colour" else replace(noise, kind="hetero", growth=6.0)


class DataError(Effect):
    """The record itself is wrong."""

    fixed = True

    def __init__(self, c, kind):
        self.kind, self.where, self.part = kind, c.where, c.rng.uniform(0.3, 0.6)
        self.factor = c.rng.choice([4.44822, 1 / 4.44822, 9.80665, 0.0980665])

    def digital(self, record, a, rng):
        n, length = record.t.size, int(0.12 * record.t.size)
        start = int(self.part * n)
        if self.kind == "repeated_block":
            for y in (record.force, record.taxels):
                y[start : start + length] = y[start - length : start]
        elif self.kind == "swapped_columns":
            record.force, record.taxels[:, 0] = record.taxels[:, 0].copy(), record.force.copy()
        elif self.kind == "unit_factor":
            record.force = record.force * self.factor
        elif self.kind == "unit_change":
            record.force[start:] *= self.factor
        elif self.kind == "broken_time":
            record.t[start : start + 5] = record.t[start]
        elif self.kind == "copied_column" and record.taxels.shape[1] > 1:
            record.taxels[:, 1] = record.taxels[:, 0]


class Nothing(Effect):
    """Nothing hidden; the name says what is wrong elsewhere, such as the numbers of a given model."""

    fixed = True

    def __init__(self, c):
        self.factors = np.exp(c.rng.choice([-1, 1], 4) * c.rng.uniform(0.1, 0.5, 4))


FORMS = {
    "outliers": {"spikes": _spikes, "discharges": _discharges, "dropouts": _dropouts, "frozen": _frozen, "bursts": _bursts},
    "dead_taxel": {"stuck": _silent("stuck"), "open": _silent("open"), "dies": _silent("dies")},
    "noise": {k: (lambda c, k=k: OtherNoise(c, k)) for k in ("level", "colour", "growth")},
    "data_error": {
        k: (lambda c, k=k: DataError(c, k))
        for k in ("repeated_block", "swapped_columns", "unit_factor", "unit_change", "broken_time", "copied_column", "copied_session")
    },
    "parameters": {"wrong_numbers": Nothing},
}
