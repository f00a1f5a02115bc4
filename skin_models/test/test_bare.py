"""The short way through a model without effects is the long way, to the last digit."""

import numpy as np
import pytest

from skin_models.bare import BareSkin, is_bare
from skin_models.dispersion import Dispersion
from skin_models.effects.lag import Lag
from skin_models.materials import material, names
from skin_models.model import Model
from skin_models.signals import Sample


@pytest.mark.parametrize("name", names())
@pytest.mark.parametrize("rate", [100.0, 1000.0])
@pytest.mark.parametrize("start", [-1e-3, 1e-3])
def test_every_material_pressed_and_left_at_random(name, rate, start):
    model, rng, dt = material(name).model, np.random.default_rng(1), 1.0 / rate
    bare, state, x, v = BareSkin(model, dt), model.initial(), start, 0.0
    parted = 0
    for i in range(3000):
        faster = float(np.clip(v + rng.normal() * 0.01, -0.02, 0.02))
        a, v = (faster - v) / dt, faster
        x = float(np.clip(x + v * dt, -1e-3, 4e-3))
        state, long_way = model.step(state, Sample(i * dt, x, v, a), dt)
        applied, sensed = bare.press(x, v, a)
        assert applied == long_way.force == long_way.force_truth
        assert np.array_equal(np.array(model.shares) * sensed, long_way.taxels)
        parted += x > 0.0 and not applied
    assert parted  # the plunger left the skin behind


def test_damping_below_zero_in_all():
    """As fits to a reading that is late by part of a sample have it: at some speeds the branches would pull, and cancel."""
    model = Model(Dispersion(m=0.0, b1=30.0, k1=5000.0, b2=-50.0, k2=4000.0), shares=(1.0,))
    bare, state, t = BareSkin(model, 0.01), model.initial(), np.arange(300) * 0.01
    x = 0.5e-3 + 0.5e-3 * np.sin(9.0 * t + 2.0 * np.sin(t))
    v, cancelled = np.gradient(x, 0.01) * 100.0, 0
    for i in range(t.size):
        state, long_way = model.step(state, Sample(t[i], x[i], v[i], 0.0), 0.01)
        assert bare.press(x[i], v[i], 0.0) == (long_way.force, long_way.taxels[0])
        cancelled += long_way.force == 0.0 and long_way.taxels[0] != 0.0
    assert cancelled


def test_a_model_with_an_effect_is_not_bare():
    model = material(names()[0]).model
    assert is_bare(model) and not is_bare(model.extended(Lag.typical("load_cell")))
