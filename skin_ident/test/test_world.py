"""The world of hidden effects itself: sizes, determinism, nothing hidden in a null, sane physics."""

import json

import numpy as np
import pytest
from world import PLACES, Hide, forms, make_sessions, without, write_table
from world.blind import make_case, plan
from world.lookalikes import lookalikes
from world.memory import Arms, BoucWen, Plays, Relays, kww
from world.protocols import BODIES, make_path
from world.scans import CAUSES, make_scan, write_scan
from world.skin import Laws, press
from world.specimen import draw_specimen

DT = 1e-3


def pressed_along(x, skin, laws=None):
    v = np.gradient(x, DT)
    return press(x, v, np.gradient(v, DT), DT, skin, laws)


@pytest.fixture
def skin():
    return draw_specimen(np.random.default_rng(0), 4)


@pytest.mark.parametrize("cause", ["stress_relaxation", "nonlinear_stiffness", "backlash", "lag", "saturation", "mount_compliance"])
def test_the_hidden_effect_has_the_size_asked_for(cause):
    form = "several" if cause == "backlash" else None  # which form a seed draws changes with their number
    _, truth = make_sessions(cause, form=form, size=0.5, seed=1, n_sessions=1, thickness_mm=4)
    assert 0.9 < max(truth.hidden[0].visible[0]) / 0.5 < 1.1


def test_the_same_seed_gives_the_same_recording():
    (one,), _ = make_sessions("hysteresis", seed=4, n_sessions=1)
    (two,), _ = make_sessions("hysteresis", seed=4, n_sessions=1)
    assert np.array_equal(one.force, two.force) and np.array_equal(one.taxels, two.taxels) and np.array_equal(one.x, two.x)


def test_hiding_something_changes_neither_the_noise_nor_the_path():
    arguments = {"seed": 4, "n_sessions": 1, "noise": "white", "thickness_mm": 2}
    _, bare = make_sessions(None, **arguments)
    _, truth = make_sessions("drift", "load_cell", **arguments)
    assert np.array_equal(truth.plain[0].force, bare.plain[0].force)
    assert np.array_equal(truth.signals[0].taxels, bare.signals[0].taxels)


def test_a_null_hides_nothing():
    _, truth = make_sessions(None, seed=2, n_sessions=1, n_taxels=2)
    assert truth.cause is None and truth.channels == []
    assert np.array_equal(truth.signals[0].force, truth.plain[0].force)
    assert np.array_equal(truth.signals[0].taxels, truth.plain[0].taxels)


@pytest.mark.parametrize(("where", "channels"), [("load_cell", ["force"]), ("taxel_0", ["taxel_0"])])
def test_a_sensor_effect_stays_in_its_channel(where, channels):
    _, truth = make_sessions("drift", where, seed=2, n_sessions=1, n_taxels=2)
    assert truth.channels == channels


def test_a_skin_effect_shows_in_all_channels():
    _, truth = make_sessions("stress_relaxation", seed=2, n_sessions=1, n_taxels=2, layout="row_5mm")
    assert truth.channels == ["force", "taxel_0", "taxel_1"]


@pytest.mark.parametrize("cause", list(PLACES))
def test_every_form_of_every_cause_makes_finite_recordings(cause):
    for where in PLACES[cause]:
        for form in forms(cause, where):
            hide = [Hide(cause, where, form)]
            (session,), truth = make_sessions(hide, seed=3, n_sessions=1, n_taxels=2, protocol="single_rate_triangles")
            assert np.all(np.isfinite(session.force)) and np.all(np.isfinite(session.taxels)) and np.all(np.isfinite(session.x))
            assert truth.hidden[0].form == form


def test_the_bare_skin_pushes_only_and_dissipates(skin):
    x = make_path("full", np.random.default_rng(0), skin.depth_max, 1 / DT)
    pressed = pressed_along(x, skin)
    assert pressed.force.min() > -1e-6
    assert np.sum(pressed.force * np.gradient(x, DT)) > 0
    assert np.all(pressed.u >= x - 1e-12)


def test_in_contact_the_bare_skin_is_spring_and_damper(skin):
    t = np.arange(0, 4, DT)
    x = 0.0005 + 0.0002 * np.sin(2 * np.pi * 0.5 * t)
    pressed = pressed_along(x, skin)
    expected = skin.stiffness * x + skin.damping * np.gradient(x, DT) + skin.mass * np.gradient(np.gradient(x, DT), DT)
    assert np.allclose(pressed.force[5:-5], expected[5:-5], rtol=1e-9)


def test_a_skin_left_behind_comes_back_exponentially(skin):
    t = np.arange(0, 3, DT)
    x = np.where(t < 1, 0.0008, np.maximum(0.0008 - 0.02 * (t - 1), -0.0003))
    pressed = pressed_along(x, skin)
    gone = np.flatnonzero(~pressed.touching & (t > 1))[2:]
    rate = np.diff(np.log(pressed.u[gone])) / DT
    assert np.allclose(rate[:500], -skin.stiffness / skin.damping, rtol=1e-6)


def test_a_stiff_mount_is_no_mount(skin):
    x = make_path("single_sine", np.random.default_rng(0), skin.depth_max, 1 / DT)
    rigid, mounted = pressed_along(x, skin), pressed_along(x, skin, Laws(mount_stiffness=lambda s: 300 * skin.stiffness))
    assert np.sqrt(np.mean((rigid.force - mounted.force) ** 2)) < 0.02 * rigid.force.max()


def test_a_hold_relaxes(skin):
    t = np.arange(0, 10, DT)
    x = np.minimum(t * 0.002, 0.0008)
    pressed = pressed_along(x, skin, Laws([kww(0.3 * skin.stiffness, 1.0, 0.5)]))
    held = pressed.force[t > 0.5]
    assert held[0] > held[-1] + 0.5 and np.all(np.diff(held) <= 1e-9)


@pytest.mark.parametrize("element", [
    Arms([3000], [0.8]), BoucWen(3000, 1e-4, 1.5, 0.7), Plays([2000, 2000], [5e-5, 2e-4]),
    Relays(2.0, np.linspace(2e-4, 9e-4, 80), np.linspace(5e-5, 6e-4, 80), 3e-6),
])  # fmt: skip
def test_loops_of_a_skin_take_up_work(element):
    x = 0.0005 + 0.0004 * np.sin(2 * np.pi * 0.25 * np.arange(0, 12, DT))
    force = np.array([element.step(u, du, DT) for u, du in zip(x, np.diff(x, prepend=x[0]), strict=True)])
    last = slice(-8000, None)
    assert np.sum(force[last] * np.gradient(x)[last]) > 0


@pytest.mark.parametrize("name", list(BODIES))
def test_paths_stay_within_depth_and_speed(name, skin):
    x = make_path(name, np.random.default_rng(3), skin.depth_max, 1 / DT)
    assert x.min() > -0.00031 and x.max() < 1.02 * skin.depth_max
    assert np.max(np.abs(np.diff(x))) / DT < 0.012
    assert 10 < x.size * DT < 120


def test_a_table_says_what_was_recorded(tmp_path):
    (session,), _ = make_sessions(None, seed=2, n_sessions=1, n_taxels=2, protocol="single_sine")
    path = write_table(session, tmp_path / "a.tsv")
    assert path.read_text().splitlines()[0] == "t_s\tx_mm\tforce_n\ttaxel_0_n\ttaxel_1_n"
    table = np.loadtxt(path, skiprows=1)
    assert np.allclose(table[:, 1] * 1e-3, session.x, atol=1e-9)
    assert np.allclose(table[:, 3:], session.taxels, atol=1e-6)
    poorer = write_table(without(session, "x"), tmp_path / "b.tsv")
    assert poorer.read_text().splitlines()[0] == "t_s\tforce_n\ttaxel_0_n\ttaxel_1_n"


@pytest.mark.parametrize("cause", [None, *CAUSES])
def test_a_scan_looks_like_the_thesis_table(cause, tmp_path):
    scans, truth = make_scan(cause, seed=1, size=2.0)
    head = write_scan(scans[0], tmp_path / "scan.csv").read_text().splitlines()[0]
    assert head.startswith("depth_mm,f_")
    assert scans[0].forces.shape == (10, scans[0].distances.size)
    assert truth.cause == cause


def test_relaxation_and_hysteresis_look_alike_in_triangles_of_one_rate():
    _, truth = make_sessions("stress_relaxation", form="prony2", seed=5, protocol="single_rate_triangles", n_sessions=1, noise="white")
    assert ("hysteresis", "skin") in [row[:2] for row in lookalikes(truth)]


def test_a_blind_case_keeps_its_answer_apart_from_its_data(tmp_path):
    index = next(i for i in range(100) if plan(i, 0)["kind"] == "null")
    answer = make_case(index, 0, tmp_path)
    assert answer["hidden"] == []
    names = {p.name for p in (tmp_path / "data" / f"case_{index:03d}").iterdir()}
    assert names == {"session_0.tsv", "session_1.tsv", "session_2.tsv", "rig.yaml"}
    json.dumps(answer, default=str)
