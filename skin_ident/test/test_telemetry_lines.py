"""Tones of other origin are found within the motion's own band, steady or in bursts; what the motion makes of itself is none."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from gate_records import PLAIN
from rows import rows
from scipy.signal import lfilter
from world import make_sessions, write_case

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.record import inspect
from skin_ident.criticism.telemetry.lines import find_interference, not_searched
from skin_ident.criticism.telling.findings import telemetry_words
from skin_ident.recordings.load import load
from skin_ident.recordings.recording import Recording
from skin_models.signals import motion


def named(folder, sessions):
    write_case(sessions, folder)
    return [s for s in inspect(load(folder)).symptoms if s.cause == "interference"]


def humming(tone, amplitude, seed=3):
    """Sessions whose load cell picks up `amplitude` (N) times `tone(t)`."""
    sessions, _ = make_sessions("null", seed=seed, n_sessions=3, noise="white")
    return [replace(s, force=s.force + amplitude * tone(s.t + 100.0 * k)) for k, s in enumerate(sessions)]


def two(t):
    return np.sin(2 * np.pi * 1.7 * t) + 0.6 * np.sin(2 * np.pi * 7.3 * t + 1)


def burst(t):
    return np.sin(2 * np.pi * 4.1 * t) * (t % 17 < 5)


def slow(t):
    return np.sign(np.sin(2 * np.pi * 0.8 * t))


@pytest.mark.parametrize(("tone", "lines"), [(two, [1.7, 7.3]), (burst, [4.1]), (slow, [0.8])])
def test_a_tone_in_the_band_is_found(tmp_path, tone, lines):
    found = named(tmp_path, humming(tone, 0.08))
    assert [s.where for s in found] == ["load_cell"]
    assert found[0].evidence["lines"][: len(lines)] == pytest.approx(lines, abs=0.1)


def wandering(t):
    """A motor's hum, whose speed goes up and down by 2 %."""
    return np.sin(2 * np.pi * (6.0 * t - 0.12 * 7.0 / (2 * np.pi) * np.cos(2 * np.pi * t / 7.0)))


@pytest.mark.parametrize("tone", [wandering, burst])
def test_a_tone_is_no_noise_that_is_alike_from_sample_to_sample(tmp_path, tone):
    write_case(humming(tone, 0.4), tmp_path)
    _, truth = make_sessions("null", seed=3, n_sessions=3, noise="white")
    with (tmp_path / "rig.yaml").open("a") as rig:
        rig.write(f"force_noise_n: {truth.noise_rms['force']}\n")
    sessions = load(tmp_path)
    content = diagnose(sessions[:2], sessions[2:]).findings
    assert [(f["cause"], f["where"]) for f in content["findings"]] == [("interference", "load_cell")]


def test_where_the_encoder_is_coarse_a_tone_that_goes_on_at_rest_is_found(tmp_path):
    """Its steps leave lines of their own while the stage moves."""
    sessions = [replace(s, x=2e-5 * np.round(s.x / 2e-5)) for s in humming(lambda t: np.sin(2 * np.pi * 7.3 * t), 0.08)]
    (found,) = named(tmp_path, sessions)
    assert found.where == "load_cell" and found.parameters["frequency"]["value"] == pytest.approx(7.3, abs=0.01)


def test_a_steady_tone_has_its_amplitude(tmp_path):
    (found,) = named(tmp_path, humming(two, 0.08))
    assert found.parameters["amplitude"]["value"] == pytest.approx(0.08, rel=0.1)
    assert found.parameters["frequency"]["value"] == pytest.approx(1.7, abs=0.01)


@pytest.mark.parametrize("seed", range(4))
def test_a_frame_that_rings_is_no_tone(tmp_path, seed):
    sessions, _ = make_sessions("null", seed=60 + seed, n_sessions=3, noise="white")
    rng, dt = np.random.default_rng(seed), float(sessions[0].t[1] - sessions[0].t[0])
    ring = [1.0, -2 * 0.985 * np.cos(2 * np.pi * 7.0 * dt), 0.985**2]

    def rung(s):
        e = lfilter([1.0], ring, rng.standard_normal(s.force.size))
        return replace(s, force=s.force + 0.06 * e / e.std())

    assert not named(tmp_path, [rung(s) for s in sessions])


@pytest.mark.parametrize("cause", ["nonlinear_stiffness", "friction", "backlash", "rate_dependence", "hysteresis"])
@pytest.mark.parametrize("hertz", rows([0.5, 1.5], 1))
def test_harmonics_of_a_periodic_motion_are_no_tones(tmp_path, cause, hertz, monkeypatch):
    from world import protocols

    def sine(path):
        path.ramp(0.5, 1.0)
        path.add(0.4 * np.sin(2 * np.pi * hertz * np.arange(1, round(30 * path.rate)) / path.rate))

    monkeypatch.setitem(protocols.BODIES, "long_sine", sine)
    sessions, _ = make_sessions(cause, size=6.0, seed=11, protocol="long_sine", n_sessions=3, n_taxels=2, noise="white")
    assert not named(tmp_path, sessions)


def corners(seed):
    """A force (N,), N, that moves in straight strokes of uneven length for ten seconds: corners move it a little at every frequency."""
    rng = np.random.default_rng(seed)
    at = np.sort(rng.uniform(0.0, 10.0, 30))
    return np.interp(0.01 * np.arange(1000), at, rng.uniform(0.0, 8.0, 30))


def beside(seed, made_of, tone):
    """Interference in three sessions of such forces, measured with noise, with what is `made_of` the force, and with a tone."""
    rng, t = np.random.default_rng(seed), 0.01 * np.arange(1000)
    forces = [corners(3 * seed + k) for k in range(3)]
    return interference([0.01 * rng.standard_normal(t.size) + made_of(f) + tone(t + 100.0 * k) for k, f in enumerate(forces)], forces)


def interference(rest, forces):
    """What is found of interference in sessions that leave `rest` of forces [(N,), …], N."""
    names = [f"session_{k + 1}" for k in range(len(rest))]
    return find_interference(names, ("taxel_0",), [e[None] for e in rest], [f[None] for f in forces], 0.01, 1)


def test_a_tone_stands_out_of_a_motion_that_moves_as_much_there_but_has_no_line():
    def beating(t):
        return 0.007 * (np.sin(2 * np.pi * 7.3 * t + 0.3 * np.sin(t)) + np.sin(2 * np.pi * 7.9 * t))

    found = [beside(seed, np.zeros_like, beating) for seed in range(8)]
    assert sum(any(abs(q - line) < 0.15 for s in f for q in s.evidence["lines"] for line in (7.3, 7.9)) for f in found) >= 6


@pytest.mark.parametrize("made_of", [lambda f: 0.02 * f**2, lambda f: 0.3 * np.sign(np.gradient(f)), lambda f: 2.0 * np.gradient(f)])
def test_what_is_made_of_such_a_motion_is_no_tone(made_of):
    assert not any(beside(seed, made_of, np.zeros_like) for seed in range(8))


def test_a_tone_of_some_sessions_is_told_with_them():
    t, hum = 0.01 * np.arange(1000), 0.02

    def seen(having):
        rng, forces = np.random.default_rng(3), [corners(50 + k) for k in range(5)]
        rest = [0.01 * rng.standard_normal(t.size) + hum * (k in having) * np.sin(2 * np.pi * 31.3 * t + k) for k in range(5)]
        return interference(rest, forces)

    (some,), (every,) = seen({1, 3}), seen(range(5))
    assert some.evidence["only_in"] == ["session_2", "session_4"] and "in session_2 and session_4" in some.evidence["why"]
    assert all(abs(s.evidence["lines"][0] - 31.3) < 0.1 for s in (some, every)) and "only_in" not in every.evidence
    assert not seen({2}), "one session alone may do anything"


def hums(sessions):
    """The frequency of the tallest line that is found in recordings, as they come; None without one."""
    return next((s.evidence["lines"][0] for s in inspect(sessions).symptoms if s.cause == "interference"), None)


def steady(t):
    return np.sin(2 * np.pi * 6.3 * t)


def test_a_session_of_seconds_hides_no_tone_of_the_long_ones(tmp_path):
    write_case(humming(steady, 0.08), tmp_path)
    *long, other = load(tmp_path)
    short = other.part(500, 800)
    assert hums([*long, short]) == pytest.approx(6.3, abs=0.05)
    assert "in session_2 alone" in not_searched([*long, short]) and not not_searched([*long, other])


def test_where_no_session_is_long_enough_for_any_line_none_is_said_to_be_looked_for():
    t = np.arange(40) / 10.0
    held = [Recording(f"session_{k}", t, force=np.ones(t.size), taxels=np.ones((1, t.size))) for k in range(3)]
    assert "too short" in not_searched(held)
    assert "too short" in telemetry_words(held, given=False)["interference"]


def test_a_tone_is_found_in_whatever_order_sessions_of_two_rates_come(tmp_path):
    write_case(humming(steady, 0.08), tmp_path)
    first, *rest = load(tmp_path)
    slower = replace(first, t=first.t[::2], depth=first.depth[::2], force=first.force[::2], taxels=first.taxels[:, ::2])
    assert all(hums(list(order)) == pytest.approx(6.3, abs=0.05) for order in permutations([slower, *rest]))
    assert "in session_0 alone" in not_searched([slower, *rest])


@pytest.mark.parametrize(("hum", "found"), [(0.003, True), (0.0, False)])
def test_a_tone_of_two_sessions_may_be_less_clear_in_one_of_them(hum, found):
    """More is wrong with the second session, which hides most of a tone that the first one shows."""
    t, seen = 0.01 * np.arange(4000), []
    for seed in range(8):
        rng, forces = np.random.default_rng(seed), [np.interp(t, 0.01 * np.arange(1000), corners(2 * seed + k)) for k in range(2)]
        seen.append(interference([e * rng.standard_normal(t.size) + hum * np.sin(2 * np.pi * 31.3 * t) for e in (0.005, 0.018)], forces))
    assert sum(map(bool, seen)) >= 7 if found else not any(seen)


@pytest.mark.parametrize("of_the_stage", [True, False], ids=["the stage vibrates", "the load cell picks up"])
def test_a_tone_that_the_depth_has_too_is_the_stage_that_vibrates(of_the_stage):
    """A servo hunts at 37 Hz by 0.4 µm, in contact and in the air, and its encoder reads that."""
    t = np.arange(12000) / 200.0
    path = 0.2e-3 + 0.4e-3 * np.clip(2.0 * np.sin(0.5 * t), -1.0, 1.0)  # it rests in contact and in the air

    def session(seed):
        rng = np.random.default_rng(seed)
        tone = np.sin(2.0 * np.pi * 37.3 * t + rng.uniform(0.0, 2.0 * np.pi))
        depth = path + 0.4e-6 * tone * of_the_stage
        truth = PLAIN.simulate(motion(t, depth))
        force = truth.force + 0.05 * tone * (not of_the_stage)
        y = np.vstack([force, truth.taxels]) + 0.02 * rng.standard_normal((2, t.size))
        return Recording(f"made_{seed}", t, 5e-8 * np.round(depth / 5e-8), y[0], y[1:])

    found = {(s.cause, s.where) for s in inspect([session(seed) for seed in (1, 2, 3)]).symptoms}
    assert found == (set() if of_the_stage else {("interference", "load_cell")})
