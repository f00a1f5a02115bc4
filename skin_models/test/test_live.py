from dataclasses import replace

import numpy as np
import pytest

from skin_models.dispersion import Dispersion
from skin_models.effects.lag import Lag
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.errors import ModelError
from skin_models.layout import A201_AREA, grid, row
from skin_models.live import LiveModel, under_plunger
from skin_models.materials import material
from skin_models.signals import motion
from skin_models.spread.kernels import Gaussian

MODEL = material("silicone_4mm").model.extended(StressRelaxation.typical("skin"))
T = np.arange(200) * 0.01
X = 0.4e-3 * (1 - np.cos(4 * T))


def test_live_is_the_simulation_of_the_recording():
    live = LiveModel(MODEL)
    got = [live.step(1e9 + t, x) for t, x in zip(T, X, strict=True)]
    v = np.diff(X, prepend=X[0]) / 0.01
    expected = MODEL.simulate(motion(T, X, v, np.diff(v, prepend=0.0) / 0.01))
    assert [r.force for r in got] == pytest.approx(expected.force, abs=1e-3)  # stamps of 1e9 s resolve 0.1 us


def test_stamps_that_do_not_advance_and_lost_depths_are_refused():
    live = LiveModel(MODEL)
    assert live.step(1.0, 1e-4) is not None
    assert live.step(1.0, 1e-4) is None and live.step(0.5, 1e-4) is None and live.step(1.1, float("nan")) is None
    assert live.step(1.1, 0.4) is None and live.step(1.15, -0.4) is not None  # 0.4 mm in m; far in the air is a place to be
    assert live.refused == 4 and live.step(1.2, 1e-4) is not None


def test_a_long_silence_starts_from_rest():
    live, fresh = LiveModel(MODEL), LiveModel(MODEL)
    for t, x in zip(T, X, strict=True):
        live.step(t, x)
    assert live.step(100.0, 3e-4).force == fresh.step(100.0, 3e-4).force and live.restarts == 1


def test_a_clock_that_was_set_back_starts_from_rest_and_stragglers_do_not():
    live, fresh = LiveModel(MODEL), LiveModel(MODEL)
    for t, x in zip(T, X, strict=True):
        live.step(1000.0 + t, x)
        if t > 0.5:
            assert live.step(1000.0 + t - 0.2, x) is None  # one late sample between two that are not
    assert live.restarts == 0
    got = [live.step(5.0 + t, x) for t, x in zip(T, X, strict=True)]
    first = next(i for i, r in enumerate(got) if r is not None)
    assert 0 < first < 30 and None not in got[first:] and live.restarts == 1
    expected = [fresh.step(5.0 + t, x) for t, x in zip(T[first:], X[first:], strict=True)]
    assert [r.force for r in got[first:]] == [r.force for r in expected]


def test_shares_of_a_layout_come_from_the_spread_unless_they_were_measured():
    spread = under_plunger(MODEL, grid(3, 1, 10e-3, A201_AREA), Gaussian(width=5.25e-3))
    beside = np.exp(-((10 / 5.25) ** 2))
    assert spread.shares == pytest.approx([beside, 1.0, beside])
    assert under_plunger(MODEL, row(1, 1.0), Gaussian(width=5.25e-3)) is MODEL


def test_an_effect_that_stands_twice_has_two_states():
    lag = Lag(where="load_cell", tau=0.05)
    twice, apart = (replace(MODEL, effects=effects) for effects in ((lag, lag), (lag, Lag(where="load_cell", tau=0.05))))
    a, b = LiveModel(twice), LiveModel(apart)
    assert [a.step(t, x).force for t, x in zip(T, X, strict=True)] == [b.step(t, x).force for t, x in zip(T, X, strict=True)]


def test_skin_without_stiffness_is_refused_in_a_sentence():
    with pytest.raises(ModelError, match="does not resist"):
        _ = Dispersion(m=4e-4, b1=1.0, k1=100.0, b2=1.0, k2=-100.0).sensed_share
