"""The skin under one contact: the model's chain from depth to sensed force, driven by a depth or by a force.

A `Column` is immutable: a step gives a new one. Driven by a force it looks for the depth whose trial step gives that force
(`Model.step` leaves its state as it was, and force grows with depth), so every effect of the skin takes part.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from scipy.optimize import brentq

from skin_models.effect import Place
from skin_models.model import Model, Response, State
from skin_models.signals import Sample

_SKIN = (Place.SKIN, Place.SURFACE)
_DEEPEST = 0.1  # m; a search that has not met the force here gives up


def skin_of(model: Model) -> Model:
    """The part of a model that is skin: one full share, no effects of rig, spread or sensors."""
    return replace(model, shares=(1.0,), effects=tuple(e for e in model.effects if e.place in _SKIN))


@dataclass(frozen=True)
class Column:
    """What a column remembers: the model's state, depth (m) and speed (m/s) of the last sample."""

    state: State
    x: float = 0.0
    v: float = 0.0


def at_rest(skin: Model, dt: float) -> Column:
    """A column that nothing has touched yet, one sample in the air behind it: effects take their first sample as their rest."""
    return Column(skin.step(skin.initial(), Sample(-dt, 0.0, 0.0, 0.0), dt)[0])


def at_depth(skin: Model, column: Column, x: float, t: float, dt: float) -> tuple[Column, Response]:
    """One sample with the contact at depth `x` (m). The speed is the change of depth since the last sample."""
    v = (x - column.x) / dt
    state, response = skin.step(column.state, Sample(t, x, v, (v - column.v) / dt), dt)
    return Column(state, x, v), response


def under_force(skin: Model, column: Column, force: float, t: float, dt: float) -> tuple[Column, Response]:
    """One sample with the contact pressing with `force` (N). No force: the contact has left, and the skin springs back to depth 0.

    Where no depth up to 100 mm gives the force, the closest one is taken; `response.force_truth` tells the force it got.
    """
    if force <= 0.0:
        return at_depth(skin, column, 0.0, t, dt)

    def excess(x: float) -> float:
        return at_depth(skin, column, x, t, dt)[1].force_truth - force

    return at_depth(skin, column, _root(excess, column.x, force), t, dt)


def _root(excess: Callable[[float], float], near: float, scale: float) -> float:
    """Where the growing function `excess`, -`scale` at 0, is zero: bracketed from `near` outwards, then Brent's method."""
    low, high = 0.0, max(near, 1e-6)
    while excess(high) < 0.0:
        if high > _DEEPEST:
            return high
        low, high = high, 2.0 * high
    return brentq(lambda x: excess(x) if x > 0.0 else -scale, low, high, xtol=1e-13, rtol=1e-12)
