"""The thesis's sinusoid comes back from noisy depths, its start is found, and other motions are refused."""

import numpy as np
import pytest
from making import SILICONE, recording

from skin_ident.estimators.dispersion import fit_dispersion
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.sinusoid import as_sinusoids, fit_sinusoid


def depth(seed=0, n=4000, dt=0.01, late=0):
    t = np.arange(n) * dt
    x = 0.3e-3 * np.sin(1.3 * (t - 0.7)) + 0.45e-3
    x[:late] = x[late]  # the stage has not started yet
    return t, x + 2e-6 * np.random.default_rng(seed).normal(size=n)


@pytest.mark.parametrize("late", [0, 80])
def test_finds_amplitude_frequency_offset_and_start(late):
    s = fit_sinusoid(*depth(late=late))
    assert (s.amplitude, s.omega, s.offset, s.start) == pytest.approx((0.3e-3, 1.3, 0.45e-3, 0.7), rel=1e-3)
    assert s.rms == pytest.approx(2e-6, rel=0.1) and abs(s.first - late) < 20


def test_speed_and_acceleration_are_its_derivatives():
    m = fit_sinusoid(*depth()).motion(np.linspace(0, 10, 10001))
    assert np.allclose(np.gradient(m.x, m.dt)[1:-1], m.v[1:-1], atol=1e-9) and np.allclose(
        np.gradient(m.v, m.dt)[1:-1], m.a[1:-1], atol=1e-8
    )


@pytest.mark.parametrize(
    "x", [np.linspace(0, 1e-3, 1000), np.random.default_rng(0).normal(size=1000), np.sign(np.sin(np.arange(1000) / 50.0))]
)
def test_other_motions_are_refused(x):
    with pytest.raises(FitError, match=r"no sinusoid.*leave out --motion sinusoid"):
        fit_sinusoid(np.arange(1000) * 0.01, x)


def test_presses_with_rests_in_the_air_are_no_sinusoid_however_slow_the_best_one_is():
    t = np.arange(8000) * 0.01
    presses = np.where(t % 10.0 < 5.0, 0.5e-3 * (1.0 - np.cos(2 * np.pi * t / 5.0)), -1e-3)
    with pytest.raises(FitError, match="no sinusoid: the best one misses it by"):
        fit_sinusoid(t, presses)


def test_half_a_sinusoid_is_said_to_be_less_than_one_period():
    with pytest.raises(FitError, match="less than one period"):
        fit_sinusoid(*depth(n=200))


def test_fit_on_the_sinusoid_is_as_good_as_with_an_exact_encoder():
    parts, motions, found = as_sinusoids([recording(encoder=20e-6, sigma=0.02)])
    fit = fit_dispersion(parts, SILICONE[4][0], motions)
    assert [fit.values[n] for n in ("b1", "k1", "b2", "k2")] == pytest.approx(SILICONE[4][1:], rel=0.01)
    assert found[0].omega == pytest.approx(2 * np.pi * 0.25, rel=1e-3)
