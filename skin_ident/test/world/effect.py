"""What something hidden may touch: the skin's laws, the tip's path, the encoder, the sensors, the noise, the record."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Context:
    """What a hidden effect is built for. `where` is a place of the vocabulary; `rng` draws the details of the form."""

    rng: np.random.Generator
    skin: object
    where: str
    force_step: float
    taxel_steps: np.ndarray
    rate: float = 100.0

    @property
    def load(self) -> float:
        """Half of the elastic force at the depth limit, N: a typical load."""
        return 0.5 * self.skin.stiffness * self.skin.depth_max


@dataclass
class Fine:
    """Signals of one session on the fine grid, noise-free. `x` is where the encoder is, `u` and `w` the skin's surface; taxels (n, N)."""

    t: np.ndarray
    x: np.ndarray
    u: np.ndarray
    w: np.ndarray
    acceleration: np.ndarray
    force: np.ndarray
    taxels: np.ndarray
    dt: float
    skin: object


@dataclass
class Record:
    """One session as sampled: t (s), x (m), force (N), taxels (T, n). `x` is None where there is no encoder."""

    t: np.ndarray
    x: np.ndarray
    force: np.ndarray
    taxels: np.ndarray


class Effect:
    """Nothing hidden. Forms override what they touch; `a` is the amplitude that the world scales, `rng` is the session's own."""

    fixed = False  # the amplitude is not scaled to a size
    by_difference = False  # sized by the errors that it adds to the measured signals, depth counted as force
    limit = float("inf")  # largest amplitude that makes sense
    stiff = False  # needs the fine steps even for sizing
    static_array = False  # shows only against the declared spread over several taxels

    def laws(self, laws, a):
        """Add to the skin's `Laws`."""

    def tip(self, x, dt, a, rng):
        """Path of the plunger's tip (m) from the path at the encoder."""
        return x

    def encoder(self, x, t, a, rng):
        """What the encoder says (m)."""
        return x

    def sense(self, fine, a, rng):
        """Change the noise-free signals in place."""

    def noise(self, channel, noise, a):
        """The noise of `channel` ("force" or a taxel's number)."""
        return noise

    def analogue(self, record, a, rng):
        """Change the samples between noise and converter in place."""

    def steps(self, steps, a):
        """The converter steps {"x": m, "force": N, "taxels": array of N}."""
        return steps

    def digital(self, record, a, rng):
        """Change the samples after the converter in place."""


def channels(where, n_taxels):
    """("force" | taxel number, …) that a place stands for; what the skin does to transmission shows in every taxel."""
    if where in ("skin", "taxel"):
        return list(range(n_taxels))
    return [int(where.split("_")[1])] if where.startswith("taxel_") else ["force"]


class Sensor(Effect):
    """A change y -> function(y, fine, a, rng) of the channels at one place, before the noise."""

    def __init__(self, context, function, **flags):
        self.where, self.function = context.where, function
        self.__dict__.update(flags)

    def sense(self, fine, a, rng):
        seed = int(rng.integers(2**32))
        for c in channels(self.where, len(fine.taxels)):
            own = np.random.default_rng([seed, 99 if c == "force" else c])
            if c == "force":
                fine.force = self.function(fine.force, fine, a, own)
            else:
                fine.taxels[c] = self.function(fine.taxels[c], fine, a, own)


class Sampled(Effect):
    """A change y -> function(y, t, a, rng) of the sampled channels at one place, in the stage "analogue" or "digital"."""

    def __init__(self, context, function, stage="digital", **flags):
        self.where, self.function = context.where, function
        self.__dict__.update(flags)
        self.by_difference = context.where == "rig"
        setattr(self, stage, self._change)

    def _change(self, record, a, rng):
        if self.where == "rig":
            record.x = self.function(record.x, record.t, a, rng)
            return
        for c in channels(self.where, record.taxels.shape[1]):
            if c == "force":
                record.force = self.function(record.force, record.t, a, rng)
            else:
                record.taxels[:, c] = self.function(record.taxels[:, c], record.t, a, rng)


class Skin(Effect):
    """A force added inside the skin by elements built anew for each session."""

    def __init__(self, make):
        self.make = make

    def laws(self, laws, a):
        laws.elements.append(Scaled(self.make(), a))


class Scaled:
    """An element times an amplitude."""

    def __init__(self, element, a):
        self.inner, self.a = element.step, a

    def step(self, u, du, dt):
        return self.a * self.inner(u, du, dt)
