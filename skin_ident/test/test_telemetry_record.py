"""Faults of the record: found where they are, marked for what they are, and nothing raised over sound recordings or other causes."""

import numpy as np
import pytest
from scipy.signal import lfilter
from world import make_sessions, write_case

from skin_ident.criticism.record import inspect
from skin_ident.criticism.telemetry.outliers import find_outliers
from skin_ident.criticism.telemetry.quantization import step_of, uneven_step
from skin_ident.recordings.load import load

FAULTS = [
    ("outliers", "load_cell", "spikes"), ("outliers", "rig", "spikes"), ("outliers", "rig", "frozen"), ("outliers", "taxel_0", "dropouts"),
    ("quantization", "load_cell", "cut"), ("quantization", "rig", "round"), ("interference", "load_cell", "mains"),
    ("dead_taxel", "taxel_0", "stuck"), ("dead_taxel", "taxel_0", "dies"),
    ("data_error", None, "repeated_block"), ("data_error", None, "swapped_columns"), ("data_error", None, "unit_factor"),
    ("data_error", None, "unit_change"), ("data_error", None, "broken_time"), ("data_error", None, "copied_session"),
]  # fmt: skip


def looked(folder, cause, where=None, form=None, size=1.0, seed=0, taxels=1, noise="white"):
    sessions, _ = make_sessions(cause, where, form, size, seed, "full", 2, taxels, noise)
    write_case(sessions, folder)
    return inspect(load(folder))


@pytest.mark.parametrize(("cause", "where", "form"), FAULTS)
def test_a_fault_is_found_and_explained(tmp_path, cause, where, form):
    symptoms = [s for s in looked(tmp_path, cause, where, form, 2.0, 41).symptoms if s.cause == cause]
    assert symptoms
    assert any(c.isdigit() for c in symptoms[0].evidence["why"]) and "\n" not in symptoms[0].evidence["why"]


@pytest.mark.parametrize(("seed", "noise"), [(20, "ar_t3"), (35, "t3"), (3, "hetero"), (9, "ar")])
def test_sound_recordings_raise_nothing(tmp_path, seed, noise):
    assert not looked(tmp_path, "null", seed=seed, noise=noise).symptoms


@pytest.mark.parametrize("cause", ["inertia", "adhesion", "friction", "position_offset"])
def test_contacts_and_reversals_are_no_outliers(tmp_path, cause):
    assert not looked(tmp_path, cause, size=2.0, seed=102).symptoms


def test_bad_samples_have_no_weight_and_are_bridged(tmp_path):
    found = looked(tmp_path, "outliers", "load_cell", "spikes", 2.0, 41)
    bad = {k: m for s in found.symptoms for k, m in s.bad.items()}
    assert bad
    row = found.sessions[0].channels.index("force")
    assert np.any(found.sessions[0].weight[row] == 0.0)
    assert np.all(found.sessions[0].weight[found.sessions[0].channels.index("taxel_0")] == 1.0)


@pytest.mark.parametrize("seed", range(6))
def test_spikes_of_nine_standard_deviations_stand_apart_and_heavy_tails_do_not(seed):
    rng = np.random.default_rng(seed)
    slow = np.sin(np.arange(20_000) / 300.0)
    spikes = np.zeros(slow.size)
    spikes[rng.choice(slow.size, 40, replace=False)] = 9.0 * rng.choice([-1.0, 1.0], 40)

    def found(e):
        return find_outliers(["a"], ("force",), [e[None]], [slow[None] + e[None]], [np.zeros(slow.size, bool)], 0, 0.01)

    (symptom,) = found(spikes + rng.standard_normal(slow.size))
    assert 20 <= symptom.evidence["excursions"] <= 42
    assert not found(rng.standard_t(3, slow.size))


RINGING = np.array([1.0, 0.7, 0.5, 0.3, 0.2])


def loaded(seed, bursts, memory, noise):
    """Outliers of a load cell beside a force of three tones: `bursts` of 20 standard deviations that ring down, in noise with a memory."""
    rng, t = np.random.default_rng(seed), 0.01 * np.arange(6000)
    force = sum(a * np.sin(2 * np.pi * f * t + p) for a, f, p in zip((60, 20, 8), (0.2, 0.7, 1.7), rng.uniform(0, 6, 3), strict=True))
    e = lfilter([1.0], [1.0, -memory], noise(rng, t.size))
    for i in rng.integers(20, t.size - 30, bursts):
        ring = RINGING[: rng.integers(2, 6)]
        e[i : i + ring.size] += 20.0 * rng.choice([-1, 1]) * ring
    return find_outliers(["a"], ("force",), [e[None]], [(force + e)[None]], [np.zeros(t.size, bool)], 0, 0.01)


def test_bursts_that_ring_down_are_outliers_and_kicks_that_fade_in_noise_are_not():
    assert sum(bool(loaded(seed, 40, 0.0, lambda rng, n: rng.standard_normal(n))) for seed in range(10)) >= 9
    for memory in (0.0, 0.3, 0.6):
        assert not any(loaded(seed, 0, memory, lambda rng, n: rng.standard_t(3, n)) for seed in range(8))


def friction_at_turns(lasting):
    """What is left of a friction that jumps a little after each turn of the motion, and is soon there in the model, too."""
    rng, t = np.random.default_rng(1), 0.0025 * np.arange(20_000)
    force, e = 10.0 - 10.0 * np.cos(2 * np.pi * 0.5 * t), 0.02 * rng.standard_normal(t.size)
    for k in range(1, 49):
        e[400 * k + 5 : 400 * k + 5 + lasting] += (-1) ** k * np.linspace(1.0, 0.2, lasting)
    return find_outliers(["a"], ("force",), [e[None]], [(force + e)[None]], [np.zeros(t.size, bool)], 0, 0.0025)


def test_friction_that_jumps_where_the_motion_turns_is_no_burst():
    assert not friction_at_turns(6)


@pytest.mark.parametrize("seed", range(4))
def test_the_levels_of_a_converter_that_compresses_are_counted(seed):
    rng, t = np.random.default_rng(seed), 0.01 * np.arange(5000)
    y = 2.5 * (1.0 - np.cos(2 * np.pi * 0.3 * t)) + 0.02 * rng.standard_normal(t.size)
    bent = np.sign(y) * np.expm1(np.round(np.log1p(50.0 * np.abs(y)) / 0.3) * 0.3) / 50.0
    levels = np.unique(bent)
    assert step_of(bent) is None
    assert uneven_step(bent) == pytest.approx(np.mean(np.diff(levels)), rel=0.3)
    assert uneven_step(y) is None
    assert uneven_step(np.round(y / 0.2) * 0.2) is None


def test_a_taxel_whose_converter_compresses_has_coarse_steps_and_no_outliers(tmp_path):
    sessions, _ = make_sessions("null", seed=8, n_sessions=2, n_taxels=3, noise="white")
    for s in sessions:
        y = s.taxels[:, 1]
        top = np.abs(y).max()
        s.taxels[:, 1] = np.sign(y) * np.expm1(np.round(np.log1p(255.0 * np.abs(y) / top) / 0.28) * 0.28) * top / 255.0
        s.rig["taxel_step_n"] = 0.03
    write_case(sessions, tmp_path)
    (symptom,) = (s for s in inspect(load(tmp_path)).symptoms if s.where == "taxel_1")
    assert symptom.cause == "quantization" and symptom.evidence["uneven"]
