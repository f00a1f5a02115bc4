"""Spikes that telemetry does not catch: a robust loss holds them back, and its standard errors stay true."""

from dataclasses import replace

import numpy as np
import pytest
from making import SILICONE, noise, recording, write_table

from skin_ident.cli.fit import main
from skin_ident.estimators.dispersion import fit_dispersion
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.force_to_force import fit_force_to_force
from skin_ident.estimators.robust import CAUCHY, HUBER, LINEAR, SOFT_L1, tamed
from skin_ident.estimators.robust_output import robustly
from skin_ident.estimators.transfer_data import Pair
from skin_ident.estimators.transfer_fit import output_error
from skin_ident.estimators.transfer_function import TransferFunction
from skin_ident.quality import inspected

TRUTH = dict(zip(("b1", "k1", "b2", "k2", "share_1"), (*SILICONE[4][1:], 0.4), strict=True))
TABLE = TransferFunction((6.69, 37.1), (8.57, 48.4))
WIDTH = 6  # samples: telemetry bridges up to four


def with_bursts(y, rng, size=1.0, one_sided=False, share=0.01):
    """A hundredth of the samples off, in bursts too wide for telemetry."""
    out = y.copy()
    for at in rng.integers(0, y.size - WIDTH, round(share * y.size / WIDTH)):
        out[at : at + WIDTH] += size * rng.uniform(0.5, 1.0) * (1 if one_sided else rng.choice([-1, 1]))
    return out


def spoilt(seed, one_sided=False, **how):
    r, rng = recording(seed, shares=(1.0, 0.4), **how), np.random.default_rng([seed, 9])
    taxels = np.array([with_bursts(y, rng, 1.0, one_sided) for y in r.taxels])
    return replace(r, force=with_bursts(r.force, rng, 1.0, one_sided), taxels=taxels)


def errors(runs, loss, **how):
    """z = error / standard error, and the errors themselves, (runs, P)."""
    fits = [fit_dispersion([spoilt(seed, **how)], SILICONE[4][0], loss=loss) for seed in runs]
    off = np.array([[f.values[n] - v for n, v in TRUTH.items()] for f in fits])
    held = np.array([[f.interval(n)[0] <= v <= f.interval(n)[1] for n, v in TRUTH.items()] for f in fits])
    return off, np.array([[f.std[n] for n in TRUTH] for f in fits]), held


@pytest.mark.parametrize("loss", [HUBER, SOFT_L1, CAUCHY])
def test_undetected_bursts_do_a_third_of_the_harm(loss):
    assert not any(inspected(spoilt(0))[2].spikes.values())
    plain, (robust, std, _) = errors(range(8), LINEAR)[0], errors(range(8), loss)
    assert np.all(np.sqrt(np.mean(robust**2, axis=0)) < 0.6 * np.sqrt(np.mean(plain**2, axis=0)))
    assert np.all(np.abs(robust) < 4.5 * std)


@pytest.mark.slow
def test_spikes_to_one_side_leave_no_offset_with_cauchy():
    off, std, _ = errors(range(12), CAUCHY, one_sided=True)
    assert np.all(np.abs(off.mean(axis=0)) < std.mean(axis=0))


@pytest.mark.parametrize("loss", [HUBER, SOFT_L1, CAUCHY])
def test_clean_data_lose_little_precision(loss):
    ratios = []
    for seed in range(6):
        r = [recording(seed, shares=(1.0, 0.4))]
        plain, robust = fit_dispersion(r, SILICONE[4][0]), fit_dispersion(r, SILICONE[4][0], loss=loss)
        ratios.append([robust.std[n] / plain.std[n] for n in TRUTH])
        assert all(abs(robust.values[n] - plain.values[n]) < plain.std[n] for n in TRUTH)
        assert robust.notes["loss"]["channels"]["force"]["scale"] == pytest.approx(0.05, rel=0.1) and "loss" not in plain.notes
    assert 0.93 < np.mean(ratios) < 1.1  # 5 % of the variance, in theory


def test_it_is_the_minimum_of_the_loss():
    """For y = beta h + e, by the modified residuals and by scipy with the same f_scale."""
    from scipy.optimize import least_squares

    rng = np.random.default_rng(0)
    h = rng.normal(size=500)
    y = 2.0 * h + rng.standard_t(2, size=500)
    for loss, c in ((HUBER, 1.345), (SOFT_L1, 1.287), (CAUCHY, 2.385)):
        beta = 0.0
        for _ in range(200):
            t = tamed([y], [beta * h], [np.ones(500, bool)], loss)
            beta = float(h @ t.rows[0] / (h @ h))
        assert beta == pytest.approx(least_squares(lambda b: y - b * h, [1.0], loss=loss, f_scale=c * t.scale).x[0], abs=1e-5)


def test_output_error_and_force_to_force():
    t = np.arange(4000) * 0.01
    u = 5 + 3 * np.sin(1.9 * t) + 2 * np.sin(6.9 * t + 1) + 1.5 * np.sin(17 * t + 2)
    far = {LINEAR: [], HUBER: []}
    for seed in range(6):
        rng = np.random.default_rng(seed)
        clean = TABLE.simulate(u, 0.01)
        y = with_bursts(clean + noise(rng, t.size, 0.01 * clean.std()), rng, 0.5 * clean.std())
        for loss, all_of_it in far.items():
            fit, held = robustly([Pair("a", u, y, 0.01)], lambda pairs: output_error(pairs), False, loss)
            all_of_it.append((fit.function.theta - TABLE.theta) / TABLE.theta)
            assert loss == LINEAR or (np.all(np.abs(fit.function.theta - TABLE.theta) < 5 * fit.std) and held.beyond > 20)
    assert np.all(np.std(far[HUBER], axis=0) < 0.5 * np.std(far[LINEAR], axis=0))
    r = replace(spoilt(1), depth=None)
    fit = fit_force_to_force([r], taxel=0, loss=HUBER)
    assert abs(fit.values["share"] - 9619 / 12385) < 5 * fit.std["share"] and fit.notes["loss"]["name"] == HUBER


def test_on_a_command_line(tmp_path, capsys):
    path = write_table(tmp_path / "a.csv", spoilt(0, n=2000))
    assert main([str(path), "--loss", "huber"]) == 0 and "beyond 4 times" in capsys.readouterr().out
    assert main([str(path), "--loss", "huber", "--profile"]) == 2 and "least squares" in capsys.readouterr().err
    with pytest.raises(FitError, match="one of linear, huber, soft_l1, cauchy, not"):
        fit_dispersion([recording(n=800)], loss="hubert")


@pytest.mark.campaign
@pytest.mark.parametrize(("rho", "one_sided"), [(0.0, False), (0.0, True), (0.9, False)])
def test_intervals_under_spikes_cover(rho, one_sided, capsys):
    _, _, held = errors(range(400), CAUCHY if one_sided else HUBER, rho=rho, one_sided=one_sided)
    with capsys.disabled():
        print(f"\nrho {rho}, {'one-sided' if one_sided else 'both sides'}: {dict(zip(TRUTH, held.mean(axis=0), strict=True))}")
    assert np.all((held.mean(axis=0) >= 0.92) & (held.mean(axis=0) <= 0.98))
