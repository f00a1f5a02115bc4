"""Transfer functions: exact discretisation, exact derivatives, the truth recovered, standard errors that hold."""

from dataclasses import replace

import numpy as np
import pytest
from making import SILICONE, noise, recording
from scipy.signal import cont2discrete, lsim

from skin_ident.estimators.dispersion import fit_dispersion
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.estimate import IDENTIFIABLE, NOT_IDENTIFIABLE
from skin_ident.estimators.force_to_force import fit_force_to_force
from skin_ident.estimators.transfer_data import Pair
from skin_ident.estimators.transfer_fit import _system, output_error, riv
from skin_ident.estimators.transfer_function import TransferFunction, derivatives, discretised
from skin_ident.recordings.recording import Recording

THESIS = {
    1: TransferFunction((1.61, 1.60), (2.035, 2.166)),
    2: TransferFunction((6.69, 37.1), (8.57, 48.4)),
    3: TransferFunction((6.98, 39.1), (8.56, 49.02)),
}
FIRST = TransferFunction((0.6, 3.0), (4.0,))


def pair(f, n=4000, dt=0.01, level=0.01, seed=0, rho=0.0):
    t = np.arange(n) * dt
    u = 5 + 3 * np.sin(1.9 * t) + 2 * np.sin(6.9 * t + 1) + 1.5 * np.sin(17 * t + 2)
    y = f.simulate(u, dt)
    return Pair("made", u, y + noise(np.random.default_rng(seed), n, level * y.std(), rho), dt)


@pytest.mark.parametrize("f", [*THESIS.values(), FIRST])
def test_discretisation_is_that_of_scipy(f):
    num, den = discretised(f, 0.01)
    expected = cont2discrete((list(f.numerator), [1.0, *f.denominator]), 0.01, "foh")
    assert np.allclose(num, expected[0].ravel(), atol=1e-14) and np.allclose(den, expected[1], atol=1e-14)
    p = pair(f, level=0.0)
    rest = f.gain * p.u[0]
    assert np.allclose(p.y, rest + lsim((list(f.numerator), [1.0, *f.denominator]), p.u - p.u[0], np.arange(p.u.size) * p.dt)[1], atol=1e-9)


@pytest.mark.parametrize("f", [THESIS[2], FIRST])
def test_derivatives_agree_with_differences(f):
    _, _, d_num, d_den = derivatives(f, 0.01)
    for i, value in enumerate(f.theta):
        step = np.zeros(f.theta.size)
        step[i] = 1e-6 * value
        up, down = discretised(f.with_theta(f.theta + step), 0.01), discretised(f.with_theta(f.theta - step), 0.01)
        assert np.allclose((up[0] - down[0]) / 2e-6 / value, d_num[i], atol=1e-9) and np.allclose(
            (up[1] - down[1]) / 2e-6 / value, d_den[i], atol=1e-9
        )


@pytest.mark.parametrize("ar", [np.empty(0), np.array([0.8])])
def test_gradient_of_the_cost_agrees_with_differences(ar):
    p, f = [pair(THESIS[2])], THESIS[2].with_theta(THESIS[2].theta * [1.1, 0.9, 1.05, 0.95])
    _, _, slope = _system(p, f, True, ar)
    for i, value in enumerate(f.theta):
        step = np.zeros(4)
        step[i] = 1e-5 * value
        difference = _system(p, f.with_theta(f.theta + step), True, ar)[1] - _system(p, f.with_theta(f.theta - step), True, ar)[1]
        assert -2 * slope[i] == pytest.approx(difference / 2e-5 / value, rel=1e-3, abs=1e-3 * abs(slope[i]))


@pytest.mark.parametrize("experiment", THESIS)
def test_recovers_table_4_7(experiment):
    f = THESIS[experiment]
    fit = output_error([pair(f, 60_000)])
    assert fit.function.theta == pytest.approx(f.theta, rel=1e-3) and fit.converged and fit.function.stable
    assert np.all(np.abs(fit.function.theta - f.theta) < 4 * fit.std)
    assert riv([pair(f, 60_000)]).theta == pytest.approx(f.theta, rel=5e-3)


def test_exact_data_give_exact_coefficients():
    assert output_error([pair(THESIS[2], level=0.0)]).function.theta == pytest.approx(THESIS[2].theta, rel=1e-6)


def test_sessions_of_different_rates_are_fitted_together():
    fit = output_error([pair(THESIS[2], 4000, 0.01, seed=1), pair(THESIS[2], 9000, 0.004, seed=2)])
    assert fit.function.theta == pytest.approx(THESIS[2].theta, rel=0.01)


@pytest.mark.parametrize("n", [600, 100])
@pytest.mark.parametrize("depth", [True, False])
def test_a_session_that_is_short_beside_a_slow_one_is_refused_as_with_a_depth(n, depth):
    """The low-pass that suits both is longer than the fast session, or than what is left of it."""
    made = [recording(1, n=900, dt=0.1, hz=0.05, name="slow"), recording(2, n=n, dt=0.001, hz=2.0, name="fast")]
    with pytest.raises(FitError, match="fast: no stretch of it is long"):
        fit_dispersion(made) if depth else fit_force_to_force([replace(r, depth=None) for r in made])


@pytest.mark.parametrize("rho", [0.0, 0.9])
def test_standard_errors_match_the_scatter(rho):
    fits = [output_error([pair(THESIS[2], 2000, seed=s, rho=rho)]) for s in range(60)]
    z = np.array([(f.function.theta - THESIS[2].theta) / f.std for f in fits])
    assert np.all((np.std(z, axis=0) > 0.75) & (np.std(z, axis=0) < 1.3)) and np.all(np.abs(z.mean(axis=0)) < 0.45)


def test_offset_and_unknown_past_do_no_harm():
    p = pair(THESIS[2])
    cut = Pair("cut", p.u[137:], p.y[137:] + 0.7, p.dt)
    assert output_error([cut], offset=True).function.theta == pytest.approx(THESIS[2].theta, rel=0.01)


def test_bounds_are_kept():
    fit = output_error([pair(THESIS[2])], lower=np.array([0, 0, 0, 0.0]), upper=np.array([6.0, 100, 100, 100]))
    assert fit.function.numerator[0] == pytest.approx(6.0) and fit.function.stable


@pytest.mark.parametrize(
    ("u", "says"), [(np.ones(100), "never changes"), (np.r_[np.nan, np.arange(99.0)], "finite"), (np.arange(5.0), "20 samples")]
)
def test_useless_input_is_refused(u, says):
    with pytest.raises(FitError, match=says):
        Pair("a", u, np.zeros(u.size), 0.01)


def test_force_to_force_gives_the_static_share():
    r = recording(n=4000, sigma=0.02)
    fit = fit_force_to_force([Recording("f", r.t, None, r.force, r.taxels)])
    assert (
        fit.values["share"] == pytest.approx(9619 / (9619 + 2766), rel=0.01)
        and fit.verdicts["share"].word == IDENTIFIABLE
        and fit.model is None
    )


def test_an_unrelated_taxel_is_called_unexplained():
    r = recording(n=2000)
    fit = fit_force_to_force([Recording("f", r.t, None, r.force, np.random.default_rng(0).normal(size=(1, 2000)))])
    assert "explains" in " ".join(fit.warnings)


SHARE = dict(zip(("share", "lead", "lag"), (9619 / 12385, 939.5 / 9619, 1568.7 / 12385), strict=True))


def forces(seed, rho=0.0, **motion):
    """A session without its depth; both sensors are noisy, and nothing weighs."""
    r = recording(seed, truth=(0.0, *SILICONE[4][1:]), rho=rho, **motion)
    return Recording("f", r.t, None, r.force, r.taxels)


def test_noise_of_the_load_cell_pulls_no_lead_to_zero():
    """On a slow sine output error at full band gives a lead of 2.5 ± 1.6 ms for 98 ms."""
    fits = [fit_force_to_force([forces(seed)]) for seed in range(12)]
    for name, truth in SHARE.items():
        z = np.array([(f.values[name] - truth) / f.std[name] for f in fits])
        assert abs(z.mean()) < 1.0 and np.abs(z).max() < 4.0, (name, z)


def test_a_lead_that_the_noise_hides_is_not_claimed():
    fit = fit_force_to_force([forces(1, rho=0.7)])
    assert fit.verdicts["lead"].word == NOT_IDENTIFIABLE and fit.verdicts["lag"].word == NOT_IDENTIFIABLE


@pytest.mark.filterwarnings("error")
def test_an_order_that_the_data_do_not_determine_is_refused_or_doubted():
    for seed in range(12):
        try:
            fit = fit_force_to_force([forces(seed)], order=2)
        except FitError as error:
            assert "lower" in str(error) or "no stable" in str(error) or "cannot be told apart" in str(error)
        else:
            assert {v.word for v in fit.verdicts.values()} == {NOT_IDENTIFIABLE} and "order 1" in " ".join(fit.warnings)


def test_an_order_that_the_data_do_determine_is_claimed():
    p = pair(THESIS[2], 6000, 0.01)
    fit = fit_force_to_force([Recording("f", np.arange(6000) * 0.01, None, p.u, p.y[None])], order=2)
    assert NOT_IDENTIFIABLE not in {v.word for v in fit.verdicts.values()} and not fit.warnings
    (b1, b0), (a1, a0) = THESIS[2].numerator, THESIS[2].denominator
    for name, truth in (("b1_over_m", b1), ("k1_over_m", b0), ("b2_over_m", a1 - b1), ("k2_over_m", a0 - b0)):
        assert abs(fit.values[name] - truth) < 4 * fit.std[name]


@pytest.mark.campaign
@pytest.mark.parametrize("motion", [{}, {"hz": 0.5, "n": 2000}, {"rho": 0.7}])
def test_force_to_force_intervals_cover(motion, capsys):
    hits = dict.fromkeys(SHARE, 0)
    for seed in range(200):
        fit = fit_force_to_force([forces(seed, **motion)])
        for name, truth in SHARE.items():
            hits[name] += fit.interval(name)[0] <= truth <= fit.interval(name)[1]
    with capsys.disabled():
        print(f"\nforce to force, {motion}: { {n: h / 200 for n, h in hits.items()} }")
    assert min(hits.values()) >= 0.9 * 200
