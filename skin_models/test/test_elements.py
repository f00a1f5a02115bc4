"""Viscoelastic elements: the thesis's closed forms, exact steps, passivity and fading memory."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.elements import Dashpot, KelvinVoigt, Maxwell, Prony, Spring, Springpot, StandardSolid
from skin_models.errors import ModelError
from skin_models.signals import motion

K, B, DT = 3000.0, 450.0, 0.01
T = np.arange(1, 400) * DT
ELEMENTS = (
    Spring(k=K),
    Dashpot(b=B),
    KelvinVoigt(k=K, b=B),
    Maxwell(k=K, b=B),
    StandardSolid(k=K, k1=1200.0, b1=B),
    Prony(k=K, b=20.0, arms=((900.0, 0.03), (1500.0, 0.4), (200.0, 0.4), (700.0, 30.0))),
    Prony(arms=((900.0, 0.03), (1500.0, 0.4))),
    Springpot(c=800.0, alpha=0.3),
)
every_element = pytest.mark.parametrize("element", ELEMENTS, ids=lambda e: type(e).__name__)

positive = st.floats(-3.0, 3.0).map(lambda power: 10.0**power)
series = st.builds(
    Prony,
    k=positive | st.just(0.0),
    b=positive | st.just(0.0),
    arms=st.lists(st.tuples(positive, positive), min_size=1, max_size=6).map(tuple),
)
paths = st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=30).map(lambda corners: np.concatenate([[0.0], corners]))


def test_closed_forms_are_those_of_the_thesis():
    tau, t1 = B / K, 1.7
    late = T[t1 < T]
    assert Spring(k=K).relaxation(T) == pytest.approx(K)  # eq 1
    assert Dashpot(b=B).force(0.2 * T, DT)[1:] == pytest.approx(B * 0.2)  # eq 2
    assert KelvinVoigt(k=K, b=B).creep(T) == pytest.approx((1 - np.exp(-T / tau)) / K)  # eq 4
    assert KelvinVoigt(k=K, b=B).recovery(late, t1) == pytest.approx(np.exp(-late / tau) * (np.exp(t1 / tau) - 1) / K)  # eq 5
    assert Maxwell(k=K, b=B).creep(T) == pytest.approx(1 / K + T / B)  # eq 7
    assert Maxwell(k=K, b=B).relaxation(T) == pytest.approx(K * np.exp(-T / tau))  # eq 8


def test_differential_equations_are_those_of_the_thesis():
    f = 1.0 + np.sin(T)
    x = KelvinVoigt(k=K, b=B).depth(f, DT)
    assert (np.gradient(x, DT) + K / B * x - f / B)[5:-5] == pytest.approx(0.0, abs=1e-3 / B)  # eq 3
    x = Maxwell(k=K, b=B).depth(f, DT)
    assert (np.gradient(x, DT) - np.gradient(f, DT) / K - f / B)[5:-5] == pytest.approx(0.0, abs=1e-3 / B)  # eq 6


@every_element
def test_discrete_relaxation_creep_and_recovery_agree_with_the_closed_forms_to_rounding(element):
    held = np.ones(T.size + 1)
    assert element.force(held, DT)[1:] == pytest.approx(element.relaxation(T), rel=1e-12, abs=1e-9)
    assert element.depth(held, DT)[1:] == pytest.approx(element.creep(T), rel=1e-12)
    driven, unloaded = element.creeping, 150
    state, recovered = driven.jump(driven.initial(), 1.0), []
    for _ in range(unloaded):
        state, _ = driven.step(state, 1.0, DT)
    state = driven.jump(state, -1.0)
    for _ in range(100):
        state, x = driven.step(state, 0.0, DT)
        recovered.append(x)
    t1 = unloaded * DT
    assert recovered == pytest.approx(element.recovery(t1 + np.arange(1, 101) * DT, t1), rel=1e-11, abs=1e-16)


@every_element
@pytest.mark.parametrize("way", ["relaxing", "creeping"])
def test_stepping_equals_batch(element, way):
    driven = getattr(element, way)
    history = 0.4 + np.sin(3.0 * T) + 0.1 * np.random.default_rng(0).standard_normal(T.size)
    state, out = driven.jump(driven.initial(), history[0]), []
    for value in history[1:]:
        state, y = driven.step(state, value, DT)
        out.append(y)
    batch = driven.batch(history, DT)
    assert out == pytest.approx(batch[1:], rel=1e-12, abs=1e-12 * np.max(np.abs(batch)))


def test_a_ramp_is_the_integral_of_the_relaxation():
    k, b, arms = 500.0, 20.0, ((900.0, 0.03), (1500.0, 0.4))
    exact = k * T + b + sum(stiffness * tau * -np.expm1(-T / tau) for stiffness, tau in arms)
    assert Prony(k=k, b=b, arms=arms).force(np.concatenate([[0.0], T]), DT)[1:] == pytest.approx(exact, rel=1e-12)


def test_standard_solid_and_maxwell_are_prony_series():
    assert Prony(k=K, arms=((1200.0, B / 1200.0),)).creep(T) == pytest.approx(StandardSolid(k=K, k1=1200.0, b1=B).creep(T), rel=1e-13)
    assert Prony(arms=((K, B / K),)).creep(T) == pytest.approx(Maxwell(k=K, b=B).creep(T), rel=1e-13)


def test_the_stress_relaxation_effect_is_a_maxwell_arm():
    x = 1e-3 * (1.0 - np.cos(T)) + 1e-3
    effect = StressRelaxation(where="skin", k_sensed=K, k_dispersed=0.0, tau=B / K)
    force = effect.batch(np.zeros((2, x.size)), motion(T, x))[0]
    assert force == pytest.approx(Maxwell(k=K, b=B).force(x - x[0], DT), rel=1e-11, abs=1e-12)


@settings(deadline=None)
@given(series)
def test_creep_is_the_inverse_of_relaxation(element):
    omega = np.geomspace(1e-4, 1e4, 60)
    c = element.creeping
    compliance = c.j + c.fluidity / (1j * omega) + (c.compliance / (1 + 1j * np.multiply.outer(omega, c.delay))).sum(axis=1)
    assert np.abs(compliance * element.modulus(omega) - 1.0).max() < 1e-9


@settings(deadline=None)
@given(series, paths)
def test_it_is_passive(element, corners):
    """From rest no path gets energy out of it; the work of every segment is integrated finely."""
    x = np.interp(np.arange(0.0, corners.size - 1, 0.005), np.arange(corners.size), corners)
    f, dx = element.force(x, 0.005), np.diff(x)
    damping = element.relaxing.b * dx / 0.005  # constant over a step, unlike the rest of the force
    rest = f - np.concatenate([[0.0], damping])
    work = np.cumsum(0.5 * (rest[1:] + rest[:-1]) * dx + damping * dx)
    assert work.min() >= -1e-2 * np.abs(work).max() - 1e-9
    assert np.all(element.modulus(np.geomspace(1e-4, 1e4, 50)).imag >= 0.0)


@settings(deadline=None)
@given(series, paths, paths)
def test_its_memory_fades(element, one, other):
    """After the same depths, different pasts are forgotten: the difference falls steadily, at last like the slowest arm."""
    tau = element.relaxing.tau.max()
    t = np.linspace(0.0, 30.0 * tau, 400)
    pasts = [np.concatenate([past, np.zeros(400)]) for past in (one, other)]
    n = min(one.size, other.size)
    forces = [element.force(np.concatenate([past[:n], np.zeros(t.size)]), t[1])[n + 1 :] for past in pasts]
    difference, allowed = np.abs(forces[0] - forces[1]), 4.0 * n * element.relaxing.stiffness.sum()
    assert np.all(difference <= allowed * np.exp(-t[: difference.size] / tau) + 1e-9)


@settings(deadline=None)
@given(series)
def test_relaxation_falls_ever_slower(element):
    g = element.relaxation(np.linspace(1e-3, 10.0, 300))
    slack = 1e-12 * g[0]
    assert np.all(np.diff(g) <= slack) and np.all(np.diff(g, 2) >= -slack) and g[-1] >= element.k - slack


@pytest.mark.parametrize("alpha", [0.05, 0.2, 0.5, 0.8, 0.95])
@pytest.mark.parametrize("allowed", [1e-2, 1e-4, 1e-6])
def test_a_springpot_keeps_the_error_it_states(alpha, allowed):
    element = Springpot(c=100.0, alpha=alpha, shortest=1e-3, longest=1e3, allowed=allowed)
    assert element.error <= allowed
    assert len(element.series.arms) <= 100
    omega = np.geomspace(1e-2, 1e2, 40)
    assert element.modulus(omega) == pytest.approx(100.0 * (1j * omega) ** alpha, rel=2.0 * allowed)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Spring(k=-1.0),
        lambda: Dashpot(b=0.0),
        lambda: Maxwell(k=np.nan, b=1.0),
        lambda: Prony(),
        lambda: Prony(k=1.0, arms=((1.0, -2.0),)),
        lambda: Prony(arms=((np.inf, 1.0),)),
        lambda: Springpot(c=1.0, alpha=1.5),
        lambda: Springpot(c=1.0, alpha=0.5, shortest=2.0, longest=1.0),
        lambda: KelvinVoigt(k=1.0, b=1.0).recovery(0.5, 1.0),
    ],
)
def test_wrong_elements_are_refused_with_a_sentence(wrong):
    with pytest.raises(ModelError):
        wrong()
