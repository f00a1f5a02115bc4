"""A search needs fewer samples than a fast record has, and says the same of them."""

from dataclasses import replace

import numpy as np
import pytest
from hide_and_seek import seek
from making import recording
from rows import rows

from skin_ident.criticism.baseline.residual import residual, rmse
from skin_ident.criticism.sessions.session import prepare
from skin_ident.criticism.sessions.thinner import ENOUGH_HZ, at_every_sample, one_in, thinner
from skin_models.dispersion import Dispersion
from skin_models.model import Model

SKIN = Model(Dispersion(m=0.000432, b1=939.5, k1=9619.0, b2=629.2, k2=2766.0), shares=(1.0,))


def fast(rate, sigma=0.0):
    """Twenty seconds of a sine that never leaves the skin."""
    return recording(sigma=sigma, dt=1.0 / rate, n=20 * rate, hz=1.0)


@pytest.mark.parametrize("rate, few", [(80, 80), (200, 200), (399, 399), (400, 200), (500, 250), (1000, 200), (2000, 200)])
def test_the_rate_is_the_least_that_is_enough(rate, few):
    session = prepare(fast(rate))
    (thin,) = thinner([session])
    assert 1.0 / thin.motion.dt == pytest.approx(few) and thin.period == pytest.approx(1.0 / rate)
    assert (thin is session) == (few == rate) == (one_in(session) == 1) and few >= min(rate, ENOUGH_HZ)


@pytest.mark.parametrize("rate", [500, 1000])
@pytest.mark.parametrize("wrong", [1.0, 1.1])
def test_what_a_model_leaves_is_the_same_of_few_samples(rate, wrong):
    session = prepare(fast(rate, 0.02))
    model = replace(SKIN, dispersion=replace(SKIN.dispersion, b1=wrong * SKIN.dispersion.b1))
    every, few = (rmse([residual(model, s)], [s]) for s in (session, *thinner([session])))
    assert every == pytest.approx(few, rel=0.05)


def test_nothing_from_above_the_band_is_folded_into_it():
    """A whistle of 197 Hz would be a wave of 3 Hz in every fifth sample."""
    calm = fast(1000)
    loud = replace(calm, force=calm.force + np.sin(2.0 * np.pi * 197.0 * calm.t))
    (before,), (after,) = thinner([prepare(calm)]), thinner([prepare(loud)])
    assert np.abs(after.measured - before.measured).max() < 5e-3


def test_what_is_not_believed_is_not_among_few_samples():
    bad = np.zeros((2, 20_000), bool)
    bad[0, 9_000:9_300] = True
    session = prepare(fast(1000), bad)
    (thin,) = thinner([session])
    assert thin.weight[1].all() and not thin.weight.all()
    out = thin.t[thin.weight[0] == 0.0]
    assert out.min() < 9.0 and out.max() > 9.3 and np.ptp(out) < 1.0


def test_rows_come_back_to_every_sample():
    session = prepare(fast(1000))
    (thin,) = thinner([session])
    back = at_every_sample(np.array([thin.motion.x]), thin, session)
    assert back[0, :-5] == pytest.approx(session.motion.x[:-5], abs=1e-3 * np.ptp(session.motion.x))


@pytest.mark.parametrize("seed", rows(range(4), 0))
def test_a_fast_record_with_nothing_wrong_says_so(seed, tmp_path):
    assert seek(tmp_path, None, seed=500 + seed, rate=500.0).findings["verdict"] == "nothing_wrong"


@pytest.mark.parametrize("cause, where", rows([("lag", "taxel"), ("stress_relaxation", "skin"), ("backlash", "rig")], 0))
def test_what_is_wrong_in_a_fast_record_is_found(cause, where, tmp_path):
    found = seek(tmp_path, cause, where=where, size=2.0, seed=510, rate=500.0)
    assert found.right and not found.extra
