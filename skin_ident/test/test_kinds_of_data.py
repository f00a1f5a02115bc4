"""Every kind of data, from tables to findings: what is missing is said, what does not belong together is refused."""

from dataclasses import replace

import numpy as np
import pytest
from rows import rows
from world import make_sessions, protocols, without, write_case

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.errors import DiagnosisError
from skin_ident.recordings.load import load
from skin_ident.recordings.recording import Recording
from skin_ident.report.terminal import summary

RELAXING = ("stress_relaxation", "skin", "prony2", 1.5)


@pytest.fixture(scope="module")
def sessions():
    return make_sessions(*RELAXING, seed=71, n_sessions=2)[0]


def named(recordings, held=()):
    findings = diagnose(list(recordings), list(held)).findings
    return [(f["cause"], f["where"]) for f in findings["findings"]], findings


def read(folder, sessions):
    write_case(sessions, folder)
    return load(folder)


@pytest.mark.parametrize(("missing", "channels"), [("taxels", {"force"}), ("force", {"taxel_0"})])
def test_a_material_test_and_one_without_load_cell(tmp_path, sessions, missing, channels):
    first, second = read(tmp_path, [without(s, missing) for s in sessions])
    names, findings = named([first], [second])
    assert ("stress_relaxation", "skin") in names and set(findings["gain_by_channel"]) == channels
    worth = next(iter(findings["gain_by_channel"].values()))
    assert worth["held_out_rmse_after"] < worth["held_out_rmse_before"] and worth["ci95"][0] > 0.0
    if missing == "taxels":
        assert "there is no taxel" in next(u["because"] for u in findings["untestable"] if u["cause"] == "dead_taxel")
        (relaxes,) = (f["parameters"] for f in findings["findings"] if f["cause"] == "stress_relaxation")
        parts = {name: p for name, p in relaxes.items() if "_sensed" in name}
        assert parts and all(p["value"] == 0.0 and p["std"] is None for p in parts.values()), "the load cell alone knows one stiffness"
        assert 0.0 < relaxes["k_dispersed"]["std"] < 0.2 * relaxes["k_dispersed"]["value"]
        said = summary(findings)
        assert "k_dispersed" in said and "k_sensed" not in said


def left_in_a_hurry(path):
    """Sawtooth presses, each of which the plunger leaves faster than any skin follows."""
    for speed in (0.3, 0.6, 1.0, 1.5, 2.0):
        path.ramp(1.0, speed).hold(1.0).ramp(-0.1, 8.0).hold(1.0).ramp(0.7, speed).ramp(-0.1, 4.0).hold(0.5)
    for depth in (0.3, 0.6, 0.9, 0.5):
        path.ramp(depth, 3.0).hold(4.0)
    path.ramp(-0.1, 8.0)


@pytest.mark.parametrize("seed", rows((5, 6), 1))
@pytest.mark.parametrize("follows", rows((False, True), 1))
def test_what_a_taxel_reads_of_skin_that_nothing_presses_is_not_judged(tmp_path, seed, follows, monkeypatch):
    """Skin that recovers under no force may still press on its taxels, or not at all: in either case nothing is wrong."""
    monkeypatch.setitem(protocols.BODIES, "hurry", left_in_a_hurry)
    made = make_sessions(None, seed=seed, n_sessions=3, noise="white", protocol="hurry")[0]
    recordings = [replace(r, depth=None) for r in read(tmp_path, made)]
    if not follows:
        at_rest = [r.taxels[0][np.arange(len(r)) % 50] for r in recordings]  # in the air
        gone = [np.convolve(r.force, np.ones(5) / 5, "same") < 0.01 * r.force.max() for r in recordings]
        taxels = [np.where(g, quiet, r.taxels[0]) for g, quiet, r in zip(gone, at_rest, recordings, strict=True)]
        recordings = [replace(r, taxels=np.array([y])) for r, y in zip(recordings, taxels, strict=True)]
    assert named(recordings[:2], recordings[2:])[0] == []


@pytest.mark.parametrize(
    ("zeros", "gains", "cause"),
    [pytest.param((0.15, -0.2, 0.1), (1, 1, 1), "force_offset", marks=pytest.mark.slow), ((0, 0, 0), (1, 1, 0.95), "gain_error")],
)
def test_a_load_cell_that_drives_the_test_may_itself_be_wrong(tmp_path, zeros, gains, cause):
    made = make_sessions(None, seed=8, n_sessions=3, noise="white")[0]
    recordings = [replace(r, depth=None, force=g * r.force + z) for r, z, g in zip(read(tmp_path, made), zeros, gains, strict=True)]
    names, findings = named(recordings[:2], recordings[2:])
    alternatives = {(a["cause"], a["where"]) for f in findings["findings"] for a in f["alternatives"]}
    assert len(names) == 1 and {(cause, "load_cell"), (cause, "taxel")} <= {*names, *alternatives}, names


@pytest.mark.parametrize("seed", rows((8, 9), 1))
def test_a_zero_that_jumps_in_a_test_without_depth_is_no_drift(tmp_path, seed):
    made = make_sessions(None, seed=seed, n_sessions=3, noise="white")[0]
    recordings = read(tmp_path, made)
    jumps = [0.02 * r.force.max() * (r.t > share * r.t[-1]) for r, share in zip(recordings, (0.4, 0.6, 0.5), strict=True)]
    names, _ = named([replace(r, depth=None, taxels=r.taxels + j) for r, j in zip(recordings, jumps, strict=True)][:2])
    assert names == [("force_offset", "taxel")]


@pytest.mark.parametrize("driven", [True, False])
@pytest.mark.parametrize("seed", rows((8, 9), 0))
def test_a_gain_that_steps_at_another_moment_in_every_session_by_another_amount(tmp_path, seed, driven):
    recordings = read(tmp_path, make_sessions(None, seed=seed, n_sessions=4, noise="white", n_taxels=2)[0])
    steps = ((0.3, 0.05), (0.7, -0.02), (0.5, 0.03), (0.8, 0.06))
    gains = [np.array([1.0 + size * (r.t > share * r.t[-1]), np.ones(len(r))]) for r, (share, size) in zip(recordings, steps, strict=True)]
    spoilt = [replace(r, depth=None if driven else r.depth, taxels=r.taxels * g) for r, g in zip(recordings, gains, strict=True)]
    assert named(spoilt[:3], spoilt[3:])[0] == [("gain_error", "taxel_0")]


@pytest.mark.slow
def test_training_sessions_may_decide_on_a_gain_of_which_the_held_out_one_has_little(tmp_path):
    """Less from session to session, to and fro: what the last one has of it changes its error by less than is asked for."""
    recordings = read(tmp_path, make_sessions(None, seed=8, n_sessions=4, noise="white", n_taxels=2)[0])

    def gain(i: int, t: np.ndarray) -> np.ndarray:
        return 1.0 + (1.0 - 0.3 * i) * (0.05 * (t > (0.3 + 0.03 * i) * t[-1]) - 0.07 * (t > (0.6 + 0.03 * i) * t[-1]))

    spoilt = [replace(r, depth=None, taxels=r.taxels * [gain(i, r.t), np.ones(len(r))]) for i, r in enumerate(recordings)]
    assert named(spoilt[:3], spoilt[3:])[0] == [("gain_error", "taxel_0")]


@pytest.mark.parametrize("seed", rows((8, 9, 10), 1))
def test_a_material_test_of_which_one_session_is_stiffer_by_some_percent_has_a_sound_load_cell(tmp_path, seed):
    """Nothing tells a gain of its only channel from a skin that is another on that day."""
    recordings = read(tmp_path, [without(s, "taxels") for s in make_sessions(None, seed=seed, n_sessions=3, noise="white")[0]])
    *first, last = [replace(r, force=g * r.force) for r, g in zip(recordings, (1.0, 1.0, 1.03), strict=True)]
    names, findings = named(first, [last])
    assert names == [] and "parameters" in {u["cause"] for u in findings["untestable"]}


def test_what_comes_late_in_a_test_without_depth_is_no_damping_below_nothing():
    """Skin with hardly any damping, always pressed, under a taxel that is late by two samples: damping that gave back what it never took
    would explain it."""

    def made(seed: int) -> Recording:
        rng, t = np.random.default_rng(seed), np.arange(6000) / 200.0
        force = 1.5 + sum(a * np.sin(w * t + rng.uniform(0.0, 6.0)) for a, w in ((0.5, 1.7), (0.4, 6.0), (0.3, 17.0)))
        taxel = 0.5 * np.interp(t - 0.01, t, force)
        noisy = [y + 0.004 * rng.standard_normal(t.size) for y in (force, taxel)]
        return Recording(f"made {seed}", t, None, noisy[0], noisy[1][None])

    names, findings = named([made(1), made(2)], [made(3)])
    assert names in ([("time_shift", "clock")], [("lag", "taxel")]), names
    late = findings["extended"]["parameters"]
    assert late["b1"]["value"] > -0.003 * late["k1"]["value"]


def test_one_session_says_what_the_second_would_be_for(tmp_path, sessions):
    names, findings = named(read(tmp_path, sessions[:1]))
    assert ("stress_relaxation", "skin") in names and any("record a second one" in w for w in findings["warnings"])
    assert len(findings["recordings"]) == 1 and findings["recordings"][0]["compared"]["left_out"] > 0


@pytest.mark.slow
def test_sessions_of_two_rates(tmp_path):
    both = [make_sessions(*RELAXING, seed=75, n_sessions=2, rate=r)[0][i] for i, r in enumerate((50.0, 100.0))]
    recordings = [read(tmp_path / str(i), [s])[0] for i, s in enumerate(both)]
    assert [round(1.0 / r.dt) for r in recordings] == [50, 100]
    assert ("stress_relaxation", "skin") in named(recordings[:1], recordings[1:])[0]


def test_skins_of_two_thicknesses_are_not_one_skin(tmp_path, sessions):
    first, second = read(tmp_path, sessions)
    other = replace(second, declared=replace(second.declared, skin_thickness_mm=17.0))
    with pytest.raises(DiagnosisError, match="and a model is of one skin"):
        diagnose([first, other])


def test_without_force_and_without_depth_nothing_can_be_said(tmp_path, sessions):
    first = read(tmp_path, sessions[:1])[0]
    with pytest.raises(DiagnosisError, match="taxels alone"):
        diagnose([replace(first, depth=None, force=None)])
    assert np.ptp(first.depth) > 0.0
