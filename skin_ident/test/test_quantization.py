"""Converters whose steps are wider than the noise: the same motion makes the same error every time, and the intervals know it."""

from dataclasses import replace

import numpy as np
import pytest
from making import SILICONE, recording

from skin_ident.estimators.dispersion import fit_dispersion
from skin_ident.estimators.prefilter import Prefilter
from skin_ident.estimators.quantization import amplitudes, step_of, widest_step

TRUTH = dict(zip(("b1", "k1", "b2", "k2", "share_1"), (*SILICONE[4][1:], 0.4), strict=True))
STEPS = (0.0678, 0.107)


def stepped(r, seed, steps=STEPS):
    """Read by converters whose levels lie anywhere."""
    p = np.random.default_rng([seed, 9]).uniform(0, 1, 2)
    force, taxels = ((np.rint(y / q + a) - a) * q for y, q, a in ((r.force, steps[0], p[0]), (r.taxels, steps[1], p[1])))
    return replace(r, force=force, taxels=taxels)


def test_steps_are_found_in_the_data():
    rng = np.random.default_rng(0)
    y = 8 * np.sin(np.arange(4000) / 60) + 0.01 * rng.normal(size=4000)
    assert step_of((np.rint(y / 0.107 + 0.3) - 0.3) * 0.107) == pytest.approx(0.107)
    assert step_of(y) is None and step_of(np.zeros(100)) is None


@pytest.mark.parametrize("rest", [0, 25_000])
def test_steps_are_seen_after_a_long_rest(rest):
    y = np.rint(8 * np.sin(np.arange(12_000) / 600) / 0.107) * 0.107
    assert step_of(np.concatenate([np.zeros(rest), y])) == pytest.approx(0.107)


def test_steps_are_seen_in_a_later_session_and_beside_another_tare():
    y = 8 * np.sin(np.arange(4000) / 60)
    tared, moved, rest = (np.rint(x / 0.107 + p) * 0.107 - 0.107 * p for x, p in ((y, 0.0), (y, 0.3), (0.02 * y / 8 + 0.05, 0.0)))
    assert widest_step([rest, tared]) == pytest.approx(0.107) == widest_step([moved, tared])
    assert widest_step([rest]) is None and np.ptp(rest) > 0.0


def test_noise_takes_the_mean_error_away():
    clean, noisy = amplitudes(0.1, 0.0), amplitudes(0.1, 0.06)
    assert 0.5 * np.sum(clean**2) == pytest.approx(0.1**2 / 12, rel=0.03) and not noisy.size


def test_spread_is_the_transpose_of_rows():
    rng, p = np.random.default_rng(1), Prefilter(0.01, 1.5)
    y = rng.normal(size=900)
    rows = p.rows(y)
    g = rng.normal(size=(rows.size, 2))
    assert g.T @ rows == pytest.approx(p.spread(g, y.size).T @ y)
    part = slice(7, 40)
    inside = np.zeros(y.size)
    inside[p.samples(part)] = y[p.samples(part)]
    assert p.rows(inside)[part] == pytest.approx(rows[part])


def test_standard_errors_are_those_of_all_places_the_levels_may_have():
    r = recording(sigma=0.0, shares=(1.0, 0.4))
    fits = [fit_dispersion([stepped(r, seed)], SILICONE[4][0]) for seed in range(25)]
    for name, truth in TRUTH.items():
        seen = np.sqrt(np.mean([(f.values[name] - truth) ** 2 for f in fits]))
        assert 0.6 < seen / np.mean([f.std[name] for f in fits]) < 1.5, name


@pytest.mark.campaign
@pytest.mark.parametrize("sigma", [0.0, 0.005, 0.01, 0.02, 0.03, 0.05])
def test_intervals_cover_whatever_the_noise(sigma, capsys):
    hits = dict.fromkeys(TRUTH, 0)
    for seed in range(200):
        g = np.random.default_rng([seed, 77])
        motion = {"amplitude": g.uniform(2e-4, 5e-4), "offset": g.uniform(4.5e-4, 8e-4), "hz": g.choice([0.1, 0.25, 0.5])}
        fit = fit_dispersion([stepped(recording(seed, sigma=sigma, shares=(1.0, 0.4), **motion), seed)], SILICONE[4][0])
        for n, v in TRUTH.items():
            hits[n] += fit.interval(n)[0] <= v <= fit.interval(n)[1]
    with capsys.disabled():
        print(f"\nsigma {sigma}: { {n: h / 200 for n, h in hits.items()} }")
    assert min(hits.values()) >= 0.91 * 200  # 95 %, less 2.6 standard errors of 200 runs
