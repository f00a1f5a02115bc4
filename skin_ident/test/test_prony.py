"""Relaxation times and stiffnesses come back from holds, and no more of them are found than there are."""

from dataclasses import replace

import numpy as np
import pytest
from making import SILICONE, noise, recording, response

from skin_ident.estimators.errors import FitError
from skin_ident.estimators.prony import NO_RELAXATION, fit_prony
from skin_ident.recordings.recording import Recording


def held(arms, sigma=0.02, seed=0, dt=0.01):
    """Ramps of 1 mm/s and holds of 12 s at four depths; every arm by a fine Euler integration written out here."""
    knots_t, knots_x = [0.0], [0.05e-3]
    for depth in (0.4e-3, 0.8e-3, 0.3e-3, 0.6e-3):
        knots_t += [knots_t[-1] + abs(depth - knots_x[-1]) / 1e-3, knots_t[-1] + abs(depth - knots_x[-1]) / 1e-3 + 12.0]
        knots_x += [depth, depth]
    t = np.arange(int(knots_t[-1] / dt)) * dt
    fine = np.arange(t.size * 20) * dt / 20
    xf = np.interp(fine, knots_t, knots_x)
    x = xf[::20]
    force, taxels = response(np.array([x, np.gradient(x, dt), np.zeros_like(x)]), (0.0, *SILICONE[4][1:]))
    for sensed, dispersed, tau in arms:
        r, out = 0.0, np.empty(fine.size)
        for i in range(fine.size):
            out[i] = r
            r += (xf[min(i + 1, fine.size - 1)] - xf[i]) - r * dt / 20 / tau
        force, taxels = force + (sensed + dispersed) * out[::20], taxels + sensed * out[::20]
    rng = np.random.default_rng(seed)
    return Recording("holds", t, x, force + noise(rng, t.size, sigma), taxels + noise(rng, t.size, sigma))


@pytest.mark.parametrize("arms", [[], [(1500.0, 800.0, 1.5)], [(1500.0, 800.0, 0.5), (900.0, 700.0, 6.0)]])
def test_arms_come_back(arms):
    fit = fit_prony([held(arms)])
    assert len(fit.arms) == len(arms), fit.arms
    for found, (sensed, dispersed, tau) in zip(fit.arms, arms, strict=True):
        assert found.tau == pytest.approx(tau, abs=0.05 * tau + 4 * found.tau_std)
        for channel, truth in (("taxel_0", sensed), ("force", sensed + dispersed)):
            value, std = found.stiffness[channel]
            assert value == pytest.approx(truth, abs=0.05 * truth + 4 * std)
    assert fit.model is not None and fit.model.dispersion.k1 == pytest.approx(9619, rel=0.03) and len(fit.model.effects) == len(arms)


def test_it_is_said_where_no_relaxation_can_be_told():
    """Arms that are asked for of a skin without any are noise; those of one that relaxes are not called so."""
    without, relaxing = held([]), held([(1500.0, 800.0, 1.5)])
    assert NO_RELAXATION in fit_prony([without], 2).warnings
    assert NO_RELAXATION not in (*fit_prony([relaxing]).warnings, *fit_prony([without]).warnings)


@pytest.mark.filterwarnings("error")
def test_a_time_that_the_motion_does_not_tell_is_not_called_exact():
    """On a sine, an arm far faster than the motion is damping: only rounding tells its time."""
    fit = fit_prony([recording(seed=1)], 1)
    assert fit.arms[0].tau < 0.1 and fit.arms[0].tau_std > fit.arms[0].tau
    assert NO_RELAXATION in fit.warnings


def test_arms_that_stand_for_something_else_are_doubted():
    """Of a bent spring under a sine, which has no holds, arms are told that are none."""
    r = recording(n=6000, sigma=0.02, amplitude=0.5e-3, offset=0.2e-3)
    bent = replace(r, force=r.force + 2e7 * np.maximum(r.depth, 0.0) ** 2)
    said = fit_prony([bent], 1).warnings
    assert any("times the noise" in w and "run diagnose" in w for w in said)
    assert any("no holds" in w for w in said) or NO_RELAXATION in said


@pytest.mark.parametrize("encoder", [0.0, 1e-6, 2e-6])
def test_holds_are_holds_through_an_encoder_that_is_noisy(encoder):
    r = held([(1500.0, 800.0, 1.5)])
    r = replace(r, depth=r.depth + encoder * np.random.default_rng(1).standard_normal(r.t.size))
    assert not any("hold" in w for w in fit_prony([r]).warnings)


@pytest.mark.parametrize("dead", [0, 1])
def test_taxels_keep_their_numbers_beside_one_that_is_dead(dead):
    r = recording(n=1500, shares=(1.0, 1.0))
    r.taxels[dead] = 0.02
    fit = fit_prony([r], 0)
    assert list(fit.stiffness) == list(fit.damping) == list(fit.rmse) == ["force", f"taxel_{1 - dead}"]
    assert fit.model.shares == (float(dead == 1), float(dead == 0))


def test_number_of_arms_is_bounded():
    with pytest.raises(FitError, match="between 0 and"):
        fit_prony([held([])], arms=9)
