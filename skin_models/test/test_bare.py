"""The short way through a model without effects is the long way, to the last digit."""

import numpy as np
import pytest

from skin_models.bare import BareSkin, is_bare
from skin_models.effects.lag import Lag
from skin_models.materials import material, names
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


def test_a_model_with_an_effect_is_not_bare():
    model = material(names()[0]).model
    assert is_bare(model) and not is_bare(model.extended(Lag.typical("load_cell")))
