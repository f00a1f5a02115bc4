"""A path drawn again from coarse readings stays within their cells, and gives back the speed that the staircase hid."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skin_ident.estimators.dispersion import fit_dispersion
from skin_ident.recordings.recording import Recording
from skin_ident.recordings.staircase import drawn_again
from skin_models.dispersion import Dispersion
from skin_models.model import Model
from skin_models.signals import motion

RATE = 100.0
STEP = 20e-6


def read(path: np.ndarray) -> np.ndarray:
    return np.round(path / STEP) * STEP


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(0.0, 1e-3), min_size=2, max_size=12), st.integers(2, 200))
def test_no_further_than_half_a_step_from_what_was_read(corners, each):
    path = np.interp(np.arange(each * (len(corners) - 1)), each * np.arange(len(corners)), corners)
    again, changes = drawn_again(read(path)), np.abs(np.diff(read(path)))
    seen = np.min(changes[changes > 0.0], initial=1.0)  # the encoder's step, or more where the path never went so slowly as to show it
    assert np.all(np.abs(again - read(path)) <= np.maximum(0.5 * seen, np.abs(np.gradient(read(path)))) + 1e-12)


@pytest.mark.parametrize("speed", [30e-6, 100e-6, 400e-6])
def test_a_ramp_has_its_speed_again_and_a_rest_is_level(speed):
    t = np.arange(0.0, 8.0, 1.0 / RATE)
    path = np.clip(speed * (t - 1.0), 0.0, 3.0 * speed)
    again = drawn_again(read(path))
    ramp = (t > 1.0 + 1.5 * STEP / speed) & (t < 4.0 - 1.5 * STEP / speed)
    staircase = np.std(np.diff(read(path)[ramp]))
    assert np.std(np.diff(again[ramp])) < 0.3 * staircase
    np.testing.assert_allclose(np.mean(np.diff(again[ramp])) * RATE, speed, rtol=0.03)
    assert np.ptp(again[t > 5.0]) == 0.0


def test_what_is_not_quantized_stays_as_it_is():
    path = 1e-3 * np.sin(np.arange(0.0, 6.0, 0.01))
    np.testing.assert_array_equal(drawn_again(path), path)
    np.testing.assert_array_equal(drawn_again(np.zeros(50)), np.zeros(50))


@pytest.mark.parametrize("step", [5e-6, 20e-6])
def test_a_coarse_encoder_hides_little_damping_from_a_fit(step):
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 60.0, 1.0 / RATE)
    path = 3e-4 + 1.5e-4 * np.sin(0.8 * t) + 0.8e-4 * np.sin(2.9 * t + 1.0)
    skin = Dispersion(m=0.0, b1=1400.0, k1=28000.0, b2=630.0, k2=1600.0)
    r = Model(skin, shares=(1.0,)).simulate(motion(t, path))
    noisy = [y + 0.05 * rng.standard_normal(y.shape) for y in (r.force, r.taxels)]
    fitted = fit_dispersion([Recording("coarse", t, np.round(path / step) * step, *noisy)], mass=0.0).model.dispersion
    assert fitted.b1 == pytest.approx(skin.b1, rel=0.03) and fitted.k1 == pytest.approx(skin.k1, rel=0.01)


def test_an_encoder_that_flickers_at_rest_does_not_hide_damping():
    """A quarter of a step of noise before the rounding: most of the speed in a record of holds is then the encoder's."""
    rng, step = np.random.default_rng(4), 5e-6
    t = np.arange(0.0, 300.0, 1.0 / RATE)
    path = np.interp(t, np.arange(0.0, 301.0, 1.0), 1e-4 * np.repeat(rng.integers(1, 10, 26), 12)[:301])
    skin = Dispersion(m=0.0, b1=982.5, k1=10156.0, b2=683.7, k2=3127.0)
    r = Model(skin, shares=(1.0,)).simulate(motion(t, path))
    noisy = [y + 0.05 * rng.standard_normal(y.shape) for y in (r.force, r.taxels)]
    read_so = np.round((path + 0.25 * step * rng.standard_normal(t.size)) / step) * step
    fitted = fit_dispersion([Recording("flickering", t, read_so, *noisy)], mass=0.0).model.dispersion
    assert fitted.b1 == pytest.approx(skin.b1, rel=0.03) and fitted.b2 == pytest.approx(skin.b2, rel=0.04)
