"""The world of hidden effects itself: sizes, determinism, nothing hidden in a null, sane physics."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

from world import make_sessions, write_table
from world.protocols import make_path
from world.skin import press
from world.specimen import draw_specimen


@pytest.mark.parametrize("cause", ["stress_relaxation", "nonlinear_stiffness", "backlash", "lag", "saturation"])
def test_the_hidden_effect_has_the_size_asked_for(cause):
    _, truth = make_sessions(cause, size=0.5, seed=1, n_sessions=1, thickness_mm=4)
    assert 0.9 < max(truth.hidden[0].visible[0]) / 0.5 < 1.1


def test_the_same_seed_gives_the_same_recording():
    (one,), _ = make_sessions("hysteresis", seed=4, n_sessions=1)
    (two,), _ = make_sessions("hysteresis", seed=4, n_sessions=1)
    assert np.array_equal(one.force, two.force) and np.array_equal(one.taxels, two.taxels) and np.array_equal(one.x, two.x)


def test_a_null_hides_nothing():
    _, truth = make_sessions(None, seed=2, n_sessions=1, n_taxels=2)
    assert truth.cause is None
    assert np.array_equal(truth.signals[0].force, truth.plain[0].force)
    assert np.array_equal(truth.signals[0].taxels, truth.plain[0].taxels)


def test_the_bare_skin_pushes_only_and_dissipates():
    rng = np.random.default_rng(0)
    skin = draw_specimen(rng, 4)
    x = make_path("full", rng, skin.depth_max, 1000.0)
    v = np.gradient(x, 1e-3)
    pressed = press(x, v, np.gradient(v, 1e-3), 1e-3, skin)
    assert pressed.force.min() > -1e-6
    assert np.sum(pressed.force * v) > 0
    assert np.all(pressed.u >= x - 1e-12)


def test_a_table_says_what_was_recorded(tmp_path):
    (session,), _ = make_sessions(None, seed=2, n_sessions=1, n_taxels=2, protocol="single_sine")
    path = write_table(session, tmp_path / "a.tsv")
    assert path.read_text().splitlines()[0] == "t_s\tx_mm\tforce_n\ttaxel_0_n\ttaxel_1_n"
    table = np.loadtxt(path, skiprows=1)
    assert np.allclose(table[:, 1] * 1e-3, session.x, atol=1e-9)
    assert np.allclose(table[:, 3:], session.taxels, atol=1e-8)
