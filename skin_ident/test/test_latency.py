"""Stamps that are kept as they come, and channels that come late."""

import re
from dataclasses import replace

import numpy as np
import pytest
from making import SILICONE, recording, response, write_table

from skin_ident.cli import fit
from skin_ident.cli.fit import main
from skin_ident.estimators.dispersion import fit_dispersion
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.force_to_force import fit_force_to_force
from skin_ident.estimators.latency import latencies
from skin_ident.recordings.load import load
from skin_ident.recordings.recording import Recording

HZ, SIZES = np.array([0.13, 0.31, 0.57, 0.9, 1.3, 2.1]), 8e-5 * np.array([1, 0.8, 0.6, 0.4, 0.3, 0.15])


def moved(t, phases):
    """Depth, speed and acceleration of six sines."""
    w, a = 2 * np.pi * HZ[:, None], SIZES[:, None]
    p = w * t + phases[:, None]
    return np.array([6e-4 + (a * np.sin(p)).sum(0), (a * w * np.cos(p)).sum(0), (-a * w**2 * np.sin(p)).sum(0)])


def late(seed, force=0.0, taxel=0.0, t=None):
    rng = np.random.default_rng(seed)
    t, phases = np.arange(4000) * 0.01 if t is None else t, rng.uniform(0, 6.28, 6)
    forces, taxels = response(moved(t - force, phases))[0], response(moved(t - taxel, phases))[1]
    noise = 0.03 * rng.normal(size=(2, t.size))
    return Recording("late", t, moved(t, phases)[0], forces + noise[0], taxels + noise[1:], uneven=True)


@pytest.mark.parametrize("delays", [(0.0, 0.0), (0.004, 0.012), (0.05, 0.03), (-0.01, 0.0)])
def test_latencies_are_found_with_their_errors(delays):
    found = latencies([replace(late(1, *delays), uneven=False)], SILICONE[4][0])
    for latency, delay in zip(found.values(), delays, strict=True):
        assert abs(latency.seconds - delay) < 4 * latency.std < 2e-3
        assert bool(latency.warning("force", 0.01)) == (abs(delay) > 0.0025)


def test_kept_stamps_fit_better_than_resampled_ones(tmp_path):
    """Jitter of a third of the period: interpolating the forces costs accuracy that keeping their own instants does not."""
    rng = np.random.default_rng(0)
    t = np.arange(4000) * 0.01 + rng.uniform(-0.0033, 0.0033, 4000)
    path = write_table(tmp_path / "a.csv", late(2, t=t))
    kept, resampled = load(path, keep=True)[0], load(path)[0]
    assert kept.uneven and np.allclose(kept.t, t, atol=1e-8) and not resampled.uneven and "stamps kept" in kept.warnings[0]
    fit = fit_dispersion([kept], SILICONE[4][0])
    for name, truth in zip(("b1", "k1", "b2", "k2"), SILICONE[4][1:], strict=True):
        assert abs(fit.values[name] - truth) < 4 * fit.std[name] < 0.05 * truth
    assert fit.residuals["force"].rmse < 1.05 * fit_dispersion([resampled], SILICONE[4][0]).residuals["force"].rmse


def test_those_that_feel_most_are_looked_at():
    found = latencies([recording(n=1000, shares=(*[0.01] * 9, 0.5, 1.0))], SILICONE[4][0])
    assert len(found) == 8 and {"force", "taxel_9", "taxel_10"} <= set(found)


def test_taxels_that_are_dead_in_one_of_the_sessions_are_none_of_those():
    """Seven taxels feel most in the first session and nothing in the second: the fit leaves them out, and so must this."""
    a, b = (recording(seed, shares=(*[1.0] * 7, 0.5, 0.2), name=name) for seed, name in ((1, "a"), (2, "b")))
    b.taxels[:7] = 0.0
    assert list(latencies([a, b], SILICONE[4][0])) == ["force", "taxel_7", "taxel_8"] == list(fit_dispersion([a, b]).residuals)


def test_a_fit_needs_no_latency(tmp_path, capsys, monkeypatch):
    def refused(recordings, mass):
        raise FitError("no motion is fast enough")

    monkeypatch.setattr(fit, "latencies", refused)
    assert main([str(write_table(tmp_path / "a.csv", recording(n=1000)))]) == 0
    assert "no latency behind the depth can be told: no motion is fast enough" in capsys.readouterr().out


@pytest.mark.parametrize(("truth", "tells"), [((0.0, 0.1, 9619.0, 0.1, 2766.0), False), (SILICONE[4], True)], ids=["elastic", "damped"])
def test_whole_periods_are_no_latency(truth, tells):
    """On one sine an elastic skin tells no latency but whole periods of it; one that damps tells that there is none."""
    r = recording(n=12_000, truth=truth)
    steps = replace(r, force=np.rint(r.force / 0.0678) * 0.0678, taxels=np.rint(r.taxels / 0.107) * 0.107)
    for latency in latencies([steps]).values():
        assert not np.isfinite(latency.std) or abs(latency.seconds) < 4 * latency.std
        assert latency.std < 0.003 or not tells


def test_even_stamps_are_even_whether_kept_or_not(tmp_path):
    path = write_table(tmp_path / "a.csv", recording(n=300))
    assert not load(path, keep=True)[0].uneven and load(path, keep=True)[0].warnings == ()


def test_what_needs_even_samples_says_so():
    with pytest.raises(FitError, match="keep-stamps"):
        fit_force_to_force([late(0)])


def test_fit_prints_latencies(tmp_path, capsys):
    path = write_table(tmp_path / "a.csv", replace(late(1, 0.02, 0.0), uneven=False))
    assert main([str(path), "--keep-stamps"]) == 0
    said = capsys.readouterr().out
    told = re.search(r"latency behind the depth, ms: force (\S+) ± (\S+),", said)
    assert float(told[1]) == pytest.approx(20.0, abs=2 * float(told[2])) and f"force comes {told[1]} ± {told[2]} ms later" in said
