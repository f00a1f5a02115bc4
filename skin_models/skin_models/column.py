"""The skin under many contacts: the model's chain from depth to sensed force, each contact driven by a depth or by a force.

`Columns` are immutable: a step gives new ones. All contacts are stepped at once, as arrays. For a contact driven by a force, a root search
finds the depth whose trial step gives that force (`Model.step` does not change its state, and force grows with depth), so every effect of
the skin takes part. The search starts from the depth extrapolated at the last speed, along the slope that was found at the last sample:
two trials where the skin is linear between two samples, a few more where it is not.
"""

from dataclasses import dataclass, replace

import numpy as np

from skin_models.effect import Place
from skin_models.model import Model, State
from skin_models.operators.growing_root import growing_root
from skin_models.operators.tree import chosen, joined
from skin_models.signals import DEEPEST, Sample

_SKIN = (Place.SKIN, Place.SURFACE)


def skin_of(model: Model) -> Model:
    """The part of a model that is skin: one full share, no effects of rig, spread or sensors."""
    return replace(model, shares=(1.0,), positions=(), effects=tuple(e for e in model.effects if e.place in _SKIN))


@dataclass(frozen=True, eq=False)
class Columns:
    """What C columns remember: their keys, the model's state (arrays (C,)), depth (m), speed (m/s), stiffness of the last search (N/m)."""

    keys: tuple[str, ...]
    state: State
    x: np.ndarray
    v: np.ndarray
    slope: np.ndarray

    def __len__(self) -> int:
        return len(self.keys)

    def of(self, skin: Model, keys: tuple[str, ...], dt: float) -> "Columns":
        """The columns of `keys`, in that order; those that are not known yet are at rest."""
        if keys == self.keys:
            return self
        index = {key: i for i, key in enumerate(self.keys)}
        new = tuple(key for key in keys if key not in index)
        whole = self
        if new:
            rest = at_rest(skin, new, dt)
            whole = rest if not self.keys else _joined(self, rest)
            index = {key: i for i, key in enumerate(whole.keys)}
        at = np.array([index[key] for key in keys], int)
        return Columns(keys, chosen(whole.state, at), whole.x[at], whole.v[at], whole.slope[at])


NOTHING = Columns((), State(()), np.empty(0), np.empty(0), np.empty(0))


def _joined(a: Columns, b: Columns) -> Columns:
    x, v, slope = (np.concatenate(pair) for pair in ((a.x, b.x), (a.v, b.v), (a.slope, b.slope)))
    return Columns(a.keys + b.keys, joined(a.state, b.state), x, v, slope)


def at_rest(skin: Model, keys: tuple[str, ...], dt: float) -> Columns:
    """Columns that nothing has touched yet, after one sample in the air, because effects take their first sample as their rest."""
    nothing, d = np.zeros(len(keys)), skin.dispersion
    state = skin.step(skin.initial(), Sample(-dt, nothing, nothing, nothing), dt)[0]
    return Columns(keys, state, nothing, nothing, nothing + max(d.k1 + d.k2, 1.0) + max(d.b1 + d.b2, 0.0) / dt + d.m / dt**2)


def press(
    skin: Model, columns: Columns, force: np.ndarray, depth: np.ndarray, t: float, dt: float
) -> tuple[Columns, np.ndarray, np.ndarray]:
    """One sample: the columns after it, applied and sensed force (C,) N, from forces (C,) N, or depths (C,) m where the force is NaN.

    A force that is not positive means that the contact has left: the skin springs back to depth 0. Where no depth up to 100 mm gives the
    force, the first depth tried beyond is taken; where the force would jump past it, the depth just below the jump. The applied force
    that is returned is the one that was reached.
    """
    trial, slope = _Trial(skin, columns, t, dt), columns.slope
    driven = force > 0.0
    if driven.any():
        where = np.flatnonzero(driven)
        part = trial if where.size == driven.size else _Trial(skin, _chosen(columns, where), t, dt)
        x, found = growing_root(lambda x: part.at(x) - force[where], *part.start(), slope[where], force[where], DEEPEST)
        slope = slope.copy()
        slope[where] = found
        if part is not trial:
            depth = np.where(driven, 0.0, depth)
            depth[where] = x
    if not driven.all():
        trial.at(np.where(np.isfinite(force) & ~driven, 0.0, depth))
    return Columns(columns.keys, trial.state, trial.x, trial.v, slope), trial.response.force_truth, trial.response.taxels_truth[0]


def _chosen(c: Columns, at: np.ndarray) -> Columns:
    return Columns((), chosen(c.state, at), c.x[at], c.v[at], c.slope[at])


class _Trial:
    """A step of some columns that can be tried again; the last trial stays in its attributes."""

    def __init__(self, skin: Model, columns: Columns, t: float, dt: float) -> None:
        self.skin, self.columns, self.t, self.dt = skin, columns, t, dt

    def at(self, x: np.ndarray) -> np.ndarray:
        """The applied force (C,) N with the contacts at depths x (C,) m. The speed is the change of depth since the last sample."""
        c = self.columns
        v = (x - c.x) / self.dt
        self.state, self.response = self.skin.step(c.state, Sample(self.t, x, v, (v - c.v) / self.dt), self.dt)
        self.x, self.v = x, v
        return self.response.force_truth

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """The depth beyond which there is contact, and a first guess of the depth that gives the force, (C,) m."""
        c, recovery = self.columns, self.skin.dispersion.recovery
        fading = 1.0 + self.dt / recovery if recovery else np.inf
        surface = c.state.surface
        apart = np.where(surface.touched, 0.0, surface.depth * (np.exp(-self.dt / recovery) if recovery else 0.0))
        # The plunger presses for x + recovery * (x - last) / dt > 0: from just above `low`, whatever the rounding.
        low = np.maximum(np.maximum(apart, c.x / fading), 0.0) * (1.0 - 1e-9)
        return low, np.maximum(c.x + c.v * self.dt, low) + 1e-9
