"""A model that is given is criticised as it stands: its skin's numbers, and those of the effects that it has."""

from dataclasses import replace

import numpy as np
import pytest
from making import SILICONE, response
from rows import rows

from skin_ident.criticism.diagnose import diagnose
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.effects.lag import Lag
from skin_models.effects.nonlinear_stiffness import PolynomialStiffness
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.model import Model

DT, SHARES = 0.01, (1.0, 0.4)
SKIN = Dispersion(**dict(zip(("m", "b1", "k1", "b2", "k2"), SILICONE[4], strict=True)))
PLAIN = Model(SKIN, SHARES, name="somebody's simulation")
SQUARE = 3e6  # N/m^2 under the taxels
BENT = PLAIN.extended(PolynomialStiffness("skin", square_sensed=SQUARE))


def session(seed: int, square: float, arms: tuple[StressRelaxation, ...] = (), sigma: float = 0.01) -> Recording:
    """Three sines at once, out of the air and back; a skin that stiffens by `square`, N/m^2, under the taxels, and relaxes by `arms`."""
    rng, t = np.random.default_rng(seed), np.arange(4000) * DT
    w, phase = 2.0 * np.pi * np.array([0.11, 0.43, 1.3]), rng.uniform(0.0, 2.0 * np.pi, (3, 1))
    size = np.array([[0.35e-3], [0.2e-3], [0.05e-3]])
    angle = np.outer(w, t) + phase
    x, v, a = (
        0.45e-3 + np.sum(size * np.sin(angle), axis=0),
        np.sum(size * w[:, None] * np.cos(angle), axis=0),
        -np.sum(size * w[:, None] ** 2 * np.sin(angle), axis=0),
    )
    force, taxels = response((x, v, a), shares=SHARES, dt=DT)
    more = square * np.maximum(x, 0.0) ** 2 * (taxels[0] > 0.0)
    for arm in arms:
        z = stretched(np.maximum(x, 0.0), arm.tau)
        more = more + arm.k_sensed * z * (taxels[0] > 0.0)
        force = force + arm.k_dispersed * z * (taxels[0] > 0.0)
    force, taxels = np.maximum(force + more, 0.0), np.maximum(taxels + np.outer(SHARES, more), 0.0)  # skin does not pull
    noise = sigma * rng.standard_normal((3, t.size))
    return Recording(f"session_{seed}", t, x, force + noise[0], taxels + noise[1:])


def stretched(x: np.ndarray, tau: float) -> np.ndarray:
    """The stretch of a Maxwell arm's spring, m, by trapezes: z' = x' - z / tau."""
    z, c = np.zeros(x.size), 0.5 * DT / tau
    for n in range(1, x.size):
        z[n] = ((1.0 - c) * z[n - 1] + x[n] - x[n - 1]) / (1.0 + c)
    return z


def found(model: Model, square: float) -> dict:
    sessions = [session(seed, square) for seed in range(3)]
    return diagnose(sessions[:2], sessions[2:], model).findings


@pytest.mark.parametrize(("model", "square"), [(PLAIN, 0.0), (BENT, SQUARE)], ids=["a plain one", "one with an effect"])
def test_a_model_that_is_right_is_left_as_it_is(model, square):
    findings = found(model, square)
    assert findings["verdict"] == "nothing_wrong"
    kept = findings["extended"]["parameters"]
    assert kept["k1"]["value"] == SKIN.k1 and (square == 0.0 or kept["nonlinear_stiffness.skin.square_sensed"]["value"] == SQUARE)


@pytest.mark.parametrize("square", [0.0, 0.5 * SQUARE], ids=["of which the record has nothing", "of half the size"])
def test_an_effect_that_only_the_model_has_is_a_wrong_number(square):
    """Its fit to nothing was silent once, and the verdict that nothing was wrong."""
    findings = found(BENT, square)
    (one,) = findings["findings"]
    size = one["parameters"]["nonlinear_stiffness.skin.square_sensed"]
    assert one["cause"] == "parameters" and "k1" not in one["parameters"]
    assert size["value"] == pytest.approx(square, abs=4.0 * size["std"])
    assert ("hardly shows" in one["evidence"].get("why", "")) == (square == 0.0)
    assert one["gain"]["held_out_rmse_after"] < 0.5 * one["gain"]["held_out_rmse_before"]


def test_numbers_of_the_skin_are_told_beside_an_effect_that_is_right():
    soft = replace(BENT, dispersion=replace(SKIN, k1=0.8 * SKIN.k1))
    (one,) = found(soft, SQUARE)["findings"]
    assert one["cause"] == "parameters" and one["parameters"]["k1"]["value"] == pytest.approx(SKIN.k1, rel=0.02)


@pytest.mark.slow
def test_what_a_model_with_an_effect_lacks_is_named_and_the_effect_stays():
    findings = found(PLAIN.extended(Lag("load_cell", tau=1e-6)), SQUARE)
    assert [(f["cause"], f["where"]) for f in findings["findings"]] == [("nonlinear_stiffness", "skin")]
    assert findings["extended"]["parameters"]["lag.load_cell.tau"]["value"] == 1e-6


@pytest.mark.slow
def test_of_two_arms_the_one_that_a_model_has_is_not_found():
    """What it lacks is told by its own numbers alone."""
    slow, quick = (StressRelaxation("skin", k_sensed=1500.0, k_dispersed=500.0, tau=tau) for tau in (3.0, 0.3))
    sessions = [session(seed, 0.0, (slow, quick)) for seed in range(3)]
    (one,) = diagnose(sessions[:2], sessions[2:], PLAIN.extended(slow)).findings["findings"]
    assert one["cause"] == "stress_relaxation" and len(one["evidence"]["forms"]) == 1
    (tau,) = [p["value"] for name, p in one["parameters"].items() if name.startswith("tau")]
    assert tau == pytest.approx(0.3, rel=0.1)


def test_a_wrong_share_of_a_taxel_that_feels_little_is_a_wrong_number():
    (one,) = found(replace(PLAIN, shares=(1.0, 0.3)), 0.0)["findings"]
    assert one["cause"] == "parameters" and one["parameters"]["share_1"]["value"] == pytest.approx(SHARES[1], rel=0.02)


@pytest.mark.parametrize("k2", rows([0.94, 1.0], 1), ids=["k2 wrong as well", "other numbers right"])
@pytest.mark.parametrize("seed", rows([1, 0, 2], 1))
def test_the_weight_of_skin_that_a_tare_took_away_is_no_fault_of_a_sensor(seed, k2):
    """The load cell reads 4 mN more in contact than a model whose skin weighs on the plunger."""
    sessions = [session(10 * seed + i, 0.0, sigma=0.003) for i in range(3)]
    weight = 9.80665 * SKIN.m
    sessions = [replace(s, force=s.force + weight * (s.force > 0.1)) for s in sessions]
    model = replace(PLAIN, dispersion=replace(SKIN, k2=k2 * SKIN.k2))
    told = diagnose(sessions[:2], sessions[2:], model).findings
    assert [f["cause"] for f in told["findings"]] == ["parameters"] * (k2 != 1.0)
