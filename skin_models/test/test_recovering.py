"""Skin that its plunger has left recovers by itself, and a taxel below still feels it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from skin_models.dispersion import Dispersion
from skin_models.effects.hysteresis import SkinHysteresis
from skin_models.materials import material, names
from skin_models.model import Model
from skin_models.signals import Sample, motion

DT, LEFT_S = 1e-3, 0.5
SKINS = [material(name).model.dispersion for name in names()]


def pulled_away(dispersion: Dispersion):
    """Held at 1 mm, then pulled out far faster than the skin follows: motion and response."""
    t = np.arange(1500) * DT
    x = np.where(t < LEFT_S, 1e-3, 1e-3 - 0.1 * (t - LEFT_S))
    return t, Model(dispersion, shares=(1.0, 0.3)).simulate(motion(t, x))


@pytest.mark.parametrize("dispersion", SKINS, ids=names())
def test_a_taxel_feels_what_the_two_branches_do_to_each_other(dispersion):
    """(b1 + b2) u' + (k1 + k2) u = 0, and the taxel feels b1 u' + k1 u: by another integrator."""
    t, out = pulled_away(dispersion)
    left = np.flatnonzero(out.force > 0.0)[-1]
    free = t[left + 1 :]

    def rate(_, u):
        return -(dispersion.k1 + dispersion.k2) * u / (dispersion.b1 + dispersion.b2)

    u = solve_ivp(rate, (t[left], free[-1]), [1e-3], t_eval=free, rtol=1e-9, atol=1e-15).y[0]
    felt = dispersion.k1 * u + dispersion.b1 * rate(0.0, u)
    assert np.allclose(out.taxels[0][left + 1 :], felt, atol=2e-3 * dispersion.k1 * 1e-3)
    assert np.allclose(out.taxels[1], 0.3 * out.taxels[0]) and not out.force[left + 1 :].any()


@pytest.mark.parametrize("dispersion", SKINS, ids=names())
def test_sample_by_sample_as_in_one_piece(dispersion):
    rng = np.random.default_rng(3)
    t = np.arange(2000) * DT
    x = 0.6e-3 * np.interp(t, np.linspace(0.0, 2.0, 40), rng.uniform(-0.6, 1.0, 40))
    s, model = motion(t, x), Model(dispersion, shares=(1.0,))
    whole, state, taxels = model.simulate(s), model.initial(), []
    for i in range(t.size):
        state, one = model.step(state, Sample(t[i], s.x[i], s.v[i], s.a[i]), DT)
        taxels.append(one.taxels[0])
    assert np.any((whole.taxels[0] != 0.0) & (whole.force == 0.0))
    assert np.allclose(taxels, whole.taxels[0], atol=1e-9)


def test_branches_that_recover_alike_press_on_no_taxel():
    even = replace(SKINS[0], b1=100.0, k1=1000.0, b2=200.0, k2=2000.0)
    t, out = pulled_away(even)
    assert not out.taxels[:, t > LEFT_S + 2.0 * DT].any(where=out.force[t > LEFT_S + 2.0 * DT] == 0.0)


@pytest.mark.parametrize("dispersion", SKINS, ids=names())
def test_effects_that_would_pull_let_the_branches_hold_each_other(dispersion):
    """An arm that relaxes makes a plunger which is still pressing, as the skin alone would say, let go: the taxel below feels no jump."""
    t, (k, r) = np.arange(4000) * DT, (0.6 * (dispersion.k1 + dispersion.k2), 0.25e-3)
    x = 1e-3 * np.clip(1.2 * np.sin(2.0 * np.pi * 0.5 * t), 0.0, None)
    model = Model(replace(dispersion, m=0.0), effects=(SkinHysteresis("skin", k_sensed=0.5 * k, k_dispersed=0.5 * k, threshold=r),))
    out = model.simulate(motion(t, x))
    let_go = (x > 0.0) & (out.force == 0.0)
    assert out.force.min() == 0.0 and out.taxels[0][let_go].any()
    down = np.diff(out.taxels[0])[(x[1:] > 0.05e-3) & (np.diff(x) < 0.0)]
    assert np.abs(down).max() < 0.1 * out.taxels[0].max()
