"""The effects of the skin against what their equations say where that can be worked out by hand, and as physics: no free energy."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import trapezoid
from scipy.special import gamma

from skin_models.catalogue import effects
from skin_models.effect import Place
from skin_models.effects.adhesion import Adhesion
from skin_models.effects.backlash import Backlash, SlackEncoder
from skin_models.effects.cyclic_softening import CyclicSoftening, SofterSprings
from skin_models.effects.damage import DamagedSprings
from skin_models.effects.dead_zone import GatedTaxel, GradualTaxel, HardDeadZone, SkinDeadZone, TaxelDeadZone
from skin_models.effects.friction import Friction, StribeckFriction
from skin_models.effects.hysteresis import (
    BoucWenHysteresis,
    LaggingHysteresis,
    LoadedHysteresis,
    SkinHysteresis,
)
from skin_models.effects.preisach import PreisachHysteresis
from skin_models.effects.rate_dependence import OneSidedDamping
from skin_models.effects.springpot_relaxation import SpringpotRelaxation
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.operators.play import play
from skin_models.signals import Motion, motion

MM = 1e-3


def at_times(x, dt=1e-3):
    return motion(np.arange(len(x)) * dt, np.asarray(x, float))


def skin_force(effect, x, dt=1e-3):
    """What the effect adds to both branches together, N."""
    s = at_times(x, dt)
    return effect.batch(np.zeros((2, len(s))), s).sum(axis=0)


def triangle(depths, samples=400):
    corners = np.asarray(depths, float)
    return np.interp(np.linspace(0, corners.size - 1, samples * (corners.size - 1) + 1), np.arange(corners.size), corners)


def test_a_ramp_relaxes_as_the_closed_form():
    v, tau, k, dt = 2 * MM, 0.7, 3000.0, 0.01
    t = np.arange(300) * dt
    force = skin_force(StressRelaxation(where="skin", k_sensed=k, tau=tau), v * t, dt)
    assert force == pytest.approx(k * v * tau * -np.expm1(-t / tau), rel=1e-12)


def test_the_area_of_a_hysteresis_loop_is_that_of_the_stop():
    """Between x and x + a the stop of stiffness k and threshold r < a / 2 loses 2 k r (a - 2 r) per cycle."""
    k, r, a = 3000.0, 0.2 * MM, 1.5 * MM
    x = 0.5 * MM + triangle([0.0, a, 0.0, a, 0.0, a])
    force = skin_force(SkinHysteresis(where="skin", k_sensed=k, k_dispersed=0.0, threshold=r), x)
    cycle = slice(800, 1601)
    assert trapezoid(force[cycle], x[cycle]) == pytest.approx(2 * k * r * (a - 2 * r), rel=2e-3)


def test_a_springpot_relaxes_as_a_power_of_time():
    k, alpha, t = 800.0, 0.3, np.arange(60_000) * 1e-2
    force = skin_force(SpringpotRelaxation(where="skin", k_sensed=k, alpha=alpha), np.where(t > 0.0, MM, 1e-9), 1e-2)
    held = slice(500, None)  # the step takes one sample: 5 s later that is forgotten
    assert force[held] == pytest.approx(k * MM * (t[held] - 5e-3) ** -alpha / gamma(1.0 - alpha), rel=0.01)


def test_preisach_loops_grow_with_depth_and_one_place_holds_one_loop():
    """The congruency that defines a Preisach operator (Mayergoyz): loops between the same two depths are alike whatever came before."""
    e = PreisachHysteresis(where="skin", k_sensed=3000.0, width=0.3 * MM)
    loops = []
    for before in ([0.0, 1.0], [0.0, 2.5, 0.2, 1.0]):
        x = triangle([d * MM for d in (*before, 1.4, 1.0, 1.4, 1.0)])
        f = skin_force(e, x)
        loops.append(f[-801:] - f[-801])
    assert loops[0] == pytest.approx(loops[1], abs=1e-12)
    for grows in (e, LoadedHysteresis(where="skin", k_sensed=3000.0, threshold=0.1 * MM, growth=1.0)):
        turns = ([(middle + d) * MM for d in (-0.3, 0.3, -0.3, 0.3, -0.3)] for middle in (0.7, 1.4))
        areas = [trapezoid(skin_force(grows, x)[800:], x[800:]) for x in map(triangle, turns)]
        assert areas[1] / areas[0] == pytest.approx(2.0, rel=1e-2) and areas[0] > 0.0


def test_plays_with_dead_zones_come_as_close_to_preisach_as_one_likes():
    """What is squared here as a sum of n dead zones (Kuhnen): the gap falls as 1 / n."""
    x, r = triangle([0.0, 1.7 * MM, 0.2 * MM, 1.2 * MM]), 0.2 * MM
    wanted, gaps = play(x, r) ** 2, []
    for n in (10, 40):
        bends = np.arange(n) / n * 2.0 * MM
        kinks = np.maximum(play(x, r)[:, None] - bends, 0.0)  # one-sided dead zones of the play
        gaps.append(np.max(np.abs(kinks @ np.full(n, 4.0 * MM / n) - wanted)))
    assert gaps[1] < 0.3 * gaps[0]


@pytest.mark.parametrize(
    "cls",
    [SkinHysteresis, LoadedHysteresis, BoucWenHysteresis, PreisachHysteresis, CyclicSoftening, Adhesion, Backlash, SlackEncoder],
)
def test_rate_independent_effects_do_not_see_the_speed(cls):
    e = cls.typical(next(iter(cls.places)))
    x = triangle([0.0, 1.4 * MM, 0.3 * MM, 1.2 * MM, -0.5 * MM])
    fast, slow = at_times(x, 1e-3), at_times(x, 1.0)
    y = x if e.place is Place.DEPTH else np.array([8e3, 2e3])[:, None] * np.maximum(x, 0.0)
    assert e.batch(y, fast) == pytest.approx(e.batch(y, slow), rel=1e-12, abs=1e-12)


def test_bouc_wen_tends_to_its_threshold():
    r, k = 0.2 * MM, 4000.0
    force = skin_force(BoucWenHysteresis(where="skin", k_sensed=k, threshold=r), triangle([0.0, 3 * MM]))
    assert force[-1] == pytest.approx(k * r, rel=1e-6) and np.all(np.diff(force) >= 0.0)


def test_softening_spares_the_virgin_curve_and_weakens_the_second_cycle():
    x = triangle([0.0, MM, 0.0, MM, 2 * MM])
    y = np.array([8e3 * x, 2e3 * x])
    out = CyclicSoftening(where="skin", softening=0.3, length=0.3 * MM).batch(y, at_times(x))
    assert out[:, :401] == pytest.approx(y[:, :401])
    second = slice(850, 1100)
    assert np.all(out[:, second] < 0.75 * y[:, second])
    assert out[:, 1200:] == pytest.approx(y[:, 1200:])


@pytest.mark.parametrize("cls", [SofterSprings, DamagedSprings])
def test_springs_that_soften_leave_dashpots_and_the_virgin_curve_alone(cls):
    """Two springs and dashpots of which the springs have lost k x share: what is lost does not depend on the damping force beside it."""
    x = triangle([0.0, MM, 0.0, MM, 2 * MM])
    springs, damped = np.array([8e3 * x, 2e3 * x]), np.array([900.0 * np.gradient(x), 500.0 * np.gradient(x)])
    softer = cls(where="skin", k_sensed=1600.0, k_dispersed=400.0, length=0.3 * MM)
    lost = springs - softer.batch(springs, at_times(x))
    assert springs + damped - softer.batch(springs + damped, at_times(x)) == pytest.approx(lost, abs=1e-12)
    assert lost[:, :401] == pytest.approx(0.0) and lost[:, 1200:] == pytest.approx(0.0)
    assert np.all(lost[:, 500:700] > 0.0) and lost[0] == pytest.approx(4.0 * lost[1])


def test_adhesion_pulls_only_on_the_way_out_and_costs_the_work_it_says():
    pull, reach = 1.2, 0.2 * MM
    x = triangle([-MM, MM, -MM], 4000)
    force = skin_force(Adhesion(where="skin", pull_sensed=pull, pull_dispersed=0.0, reach=reach), x)
    assert not force[:4001].any() and force.min() == pytest.approx(-pull, rel=1e-6)
    assert trapezoid(force, x) == pytest.approx(16.0 / 15.0 * pull * reach, rel=1e-3)
    shallow = skin_force(Adhesion(where="skin", pull_sensed=pull, reach=reach), triangle([-MM, 0.5 * reach, -MM]))
    assert not shallow.any()


def test_dead_zones_above_and_below_their_threshold():
    y = np.array([[0.1, 0.5, 5.0, -5.0]])
    assert TaxelDeadZone(where="taxel", threshold=0.5).apply(y, None)[0, 2:] == pytest.approx([4.5, -4.5], abs=1e-6)
    assert HardDeadZone(where="taxel", threshold=0.5).apply(y, None)[0] == pytest.approx([0.0, 0.0, 4.5, -4.5])
    assert GatedTaxel(where="taxel", threshold=0.5).apply(y, None)[0] == pytest.approx([0.0, 0.0, 5.0, -5.0])
    gradual = GradualTaxel(where="taxel", threshold=0.5, sharpness=2.0).apply(y, None)[0]
    assert gradual == pytest.approx([0.1 * (1.0 - np.exp(-0.04)), 0.5 * (1.0 - np.exp(-1.0)), 5.0, -5.0])
    both = np.array([[0.1, 5.0], [1.0, 2.0]])
    out = SkinDeadZone(where="skin", threshold=0.5).apply(both, None)
    assert out.sum(axis=0) == pytest.approx(both.sum(axis=0)) and out[0, 1] == pytest.approx(4.5, abs=1e-6)


DISSIPATIVE = {"stress_relaxation", "hysteresis", "rate_dependence", "adhesion", "cyclic_softening", "nonlinear_stiffness"}
ACTIVE = {LaggingHysteresis, OneSidedDamping}  # the one by definition, the other where it is not beside a damping as large
SKINS = [c for c in effects() if c.cause in DISSIPATIVE and "skin" in c.places and c not in ACTIVE]


@pytest.mark.parametrize("cls", SKINS, ids=lambda c: c.__name__)
@settings(deadline=None, max_examples=40)
@given(depths=st.lists(st.floats(-0.5 * MM, 2.0 * MM), min_size=2, max_size=8))
def test_no_closed_path_from_the_virgin_skin_returns_energy(cls, depths):
    """A spring skin with the effect, from the air and back to it: the plunger's work is not negative."""
    x = triangle([-0.5 * MM, *depths, -0.5 * MM], 300)
    s = at_times(x)
    spring = np.multiply.outer([8e3, 2e3], np.maximum(x, 0.0))
    force = cls.typical("skin").batch(spring, s).sum(axis=0)
    entry = np.abs(force).max() * np.abs(np.diff(x)).max()  # the trapezium across the surface
    effort = np.sum(np.abs(force[1:] * np.diff(x)))
    assert trapezoid(force, x) >= -2e-3 * effort - 2.0 * entry


def test_a_lagging_loop_is_a_dissipating_one_run_the_other_way_round():
    x = triangle([0.0, MM, 0.2 * MM, 0.8 * MM, 0.0], 200)
    s, y = at_times(x), np.zeros((2, x.size))
    one, other = (cls(where="skin", k_sensed=3e3, k_dispersed=1e3, threshold=0.1 * MM) for cls in (SkinHysteresis, LaggingHysteresis))
    assert np.array_equal(other.batch(y, s), -one.batch(y, s))
    assert trapezoid(other.batch(y, s).sum(axis=0), x) < 0.0 < trapezoid(one.batch(y, s).sum(axis=0), x)


def test_lubricated_friction_falls_with_speed_to_what_coulombs_law_says():
    speeds = np.array([1e-3, 1e-2, 1.0])
    s = Motion(np.arange(3.0), np.zeros(3), speeds, np.zeros(3), 1.0)
    shape = {"force": 0.3, "coefficient": 0.0, "speed": 1e-5}
    rubbed = StribeckFriction(where="rig", **shape, peak=0.8, peak_speed=1e-3).batch(np.zeros(3), s)
    assert rubbed == pytest.approx([0.3 * 1.4, 0.3 * (1.0 + 0.8 / 101.0), 0.3], rel=1e-5)
    plain = StribeckFriction(where="rig", **shape, peak=0.0).batch(np.zeros(3), s)
    assert np.array_equal(plain, Friction(where="rig", **shape).batch(np.zeros(3), s))
