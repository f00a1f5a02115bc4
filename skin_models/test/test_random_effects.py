"""The random effects: as large as they say, whatever the rate, and repeatable from a seed."""

import numpy as np
import pytest
from scipy.stats import kurtosis

from skin_models.dispersion import Dispersion
from skin_models.effects.noise import Noise
from skin_models.effects.outliers import Outliers
from skin_models.effects.random_walk import RandomWalk
from skin_models.model import Model
from skin_models.signals import motion

RATES = pytest.mark.parametrize("dt", [1e-2, 1e-3])


def air(dt, end=200.0):
    t = np.arange(round(end / dt)) * dt
    return motion(t, -0.01 * np.ones(t.size))


def disturbance(effect, dt, rows=4, load=0.0, end=200.0, seed=5):
    s = air(dt, end)
    return effect.batch(np.full((rows, len(s)), load), s, np.random.default_rng(seed)) - load


@RATES
def test_white_noise_is_white_and_as_large_as_said(dt):
    noise = disturbance(Noise(where="taxel", white=0.05), dt)
    assert noise.std() == pytest.approx(0.05, rel=0.02)
    assert abs(np.corrcoef(noise[0, 1:], noise[0, :-1])[0, 1]) < 4.0 / np.sqrt(noise.shape[1])
    assert abs(np.corrcoef(noise)[0, 1]) < 4.0 / np.sqrt(noise.shape[1])


@RATES
def test_coloured_noise_has_its_size_and_correlation_time_at_any_rate_and_from_the_first_sample(dt):
    noise = disturbance(Noise(where="taxel", coloured=0.05, tau=0.1), dt)
    assert noise.std() == pytest.approx(0.05, rel=0.05)
    late = round(0.1 / dt)
    assert np.mean(noise[:, late:] * noise[:, :-late]) / np.mean(noise**2) == pytest.approx(np.exp(-1.0), abs=0.05)
    first = disturbance(Noise(where="taxel", coloured=0.05, tau=0.1), dt, rows=400, end=0.1)[:, 0]
    assert first.std() == pytest.approx(0.05, rel=0.15)


def test_proportional_noise_grows_with_the_load():
    effect = Noise(where="taxel", proportional=0.01)
    assert disturbance(effect, 1e-2, load=5.0).std() == pytest.approx(0.05, rel=0.03)
    assert disturbance(effect, 1e-2, load=0.0).std() == 0.0


@RATES
def test_a_random_walk_spreads_with_the_root_of_time(dt):
    walk = disturbance(RandomWalk(where="taxel", walk=0.05), dt, rows=300, end=10.0)
    assert not walk[:, 0].any()
    for seconds in (1.0, 9.0):
        assert walk[:, round(seconds / dt)].std() == pytest.approx(0.05 * np.sqrt(seconds), rel=0.15)


@RATES
def test_outliers_come_at_their_rate_and_size(dt):
    spikes = disturbance(Outliers(where="taxel", rate=2.0, size=3.0), dt)
    hits = spikes[spikes != 0.0]
    assert hits.size / (4 * 200.0) == pytest.approx(2.0, rel=0.1)
    assert hits.std() == pytest.approx(3.0, rel=0.1) and abs(kurtosis(hits)) < 0.6


def test_a_model_repeats_itself_from_its_seed_and_one_effect_does_not_disturb_another():
    base = Model(Dispersion(b1=900.0, k1=9600.0, b2=600.0, k2=2700.0), shares=(1.0, 0.3))
    noise, spikes = Noise(where="taxel", white=0.05), Outliers(where="load_cell", rate=2.0, size=3.0)
    s = air(1e-2, 20.0)
    first = base.extended(noise).simulate(s, seed=3)
    assert np.array_equal(base.extended(noise).extended(spikes).simulate(s, seed=3).taxels, first.taxels)
    assert not np.array_equal(base.extended(noise).simulate(s, seed=4).taxels, first.taxels)
    assert np.array_equal(base.extended(noise).simulate(s).taxels, first.taxels_truth)
