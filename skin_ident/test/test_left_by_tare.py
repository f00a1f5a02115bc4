"""What a tare leaves of a zero: by the spectrum of the noise, and in diagnoses of sessions that were each tared for a second."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from gate_records import DEPTH, PLAIN, recorded
from rows import rows
from scipy.ndimage import uniform_filter1d
from scipy.signal import lfilter

from skin_ident.criticism.courses.left_by_tare import Tare
from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.noise.whitening import fit_whitener

NOISE = 0.02  # N


def wandering(rng, pole: float, rows: int, n: int) -> np.ndarray:
    """Noise of unit size that forgets by `pole` from sample to sample, long since begun."""
    return lfilter([np.sqrt(1.0 - pole**2)], [1.0, -pole], rng.standard_normal((rows, n + 5000)))[:, 5000:]


@pytest.mark.parametrize("pole", [0.0, 0.9, 0.98])
def test_an_average_of_noise_is_as_far_off_as_its_spectrum_says(pole):
    y = wandering(np.random.default_rng(1), pole, 2, 60_000) * [[1.0], [0.2]]
    session = SimpleNamespace(weight=np.ones(y.shape), load=np.zeros(y.shape))
    said = fit_whitener([y], [session]).averaged(25)
    assert said == pytest.approx(np.std(uniform_filter1d(y, 25, axis=1), axis=1), rel=0.1)


def test_what_sessions_share_is_smaller_by_as_many_as_they_are():
    steps, noise = Tare(step=0.01, wander=0.0), Tare(step=0.0, wander=0.01)
    assert steps.leaves == 0.01 and steps.leaves_all(4) == 0.005  # each tare is rounded the same way
    assert noise.leaves_all(4) == pytest.approx(0.5 * noise.leaves)
    assert "steps of 0.01 N" in steps.said and "wanders by 0.01 N" in noise.said


def tared(seed: int, pole: float) -> list:
    """Three sessions whose noise wanders, each less the average of a second of it from before."""
    rng, made = np.random.default_rng(seed), []
    for i in range(3):
        r = recorded(PLAIN, DEPTH + 0.1e-3 * i, 1e-4, seed=seed + i)
        second = round(1.0 / r.dt)
        before, noise = np.split(NOISE * wandering(rng, pole, 2, len(r) + second), [second], axis=1)
        force, taxel = noise - before.mean(axis=1, keepdims=True)
        made.append(replace(r, name=f"session_{i}", force=r.force + force, taxels=r.taxels + taxel))
    return made


@pytest.mark.parametrize("pole", rows([0.98, 0.9, 0.995], 0))
def test_sessions_that_were_tared_in_noise_that_wanders_are_sound(pole):
    """Of six sets at most one is told anything: of their three dozen zeros one may be more than three standard errors off."""
    sets = (tared(100 * seed, pole) for seed in range(6))
    told = [diagnose(made[:2], made[2:]).findings for made in sets]
    loud = [[(f["cause"], f["where"]) for f in findings["findings"]] for findings in told if findings["verdict"] != "nothing_wrong"]
    assert len(loud) <= 1, loud


@pytest.mark.parametrize("seed", rows([1, 0], 1))
def test_a_zero_that_no_tare_leaves_is_named(seed):
    """As large as the wandering noise above, in noise that is white."""
    made = [replace(r, force=r.force + 1.5 * NOISE) for r in tared(100 * seed, 0.0)]
    findings = diagnose(made[:2], made[2:]).findings["findings"]
    assert [(f["cause"], f["where"]) for f in findings] == [("force_offset", "load_cell")]
