"""What belongs to one session alone is told from what all sessions share, and nothing is made up where there is nothing."""

import re
from dataclasses import replace

import numpy as np
import pytest
from gate_records import DEPTH, PLAIN, T, recorded
from hide_and_seek import seek
from rows import rows
from world import make_sessions, write_case
from world.hidden import Hide

from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.courses.carriers import SLOPE, ZERO
from skin_ident.criticism.courses.course import _run, shows_in_the_air
from skin_ident.criticism.courses.gate import _agrees, _share
from skin_ident.criticism.courses.ground import ground_of
from skin_ident.criticism.courses.kinds import CONSTANT, STEPS, Course
from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.gates.gate import Gain
from skin_ident.criticism.noise.whitening import fit_whitener, stack
from skin_ident.criticism.projection import basis
from skin_ident.criticism.sessions.session import prepare
from skin_ident.recordings.load import load

OWN = [
    ("gain_error", "load_cell", "step", 597305605),
    ("gain_error", "taxel_0", "loose", 12),
    ("position_offset", "rig", "lost_counts", 1347721059),
    ("force_offset", "load_cell", "each_session", 8),
]


@pytest.mark.parametrize(("cause", "where", "form", "seed"), rows(OWN, 1), ids=[c[2] for c in OWN])
def test_what_each_session_has_of_its_own_is_named(tmp_path, cause, where, form, seed):
    found = seek(tmp_path, cause, where=where, form=form, size=1.0, seed=seed, noise="white")
    assert found.right, found.names


@pytest.mark.slow
def test_the_finding_says_what_each_session_has(tmp_path):
    found = seek(tmp_path, "position_offset", where="rig", form="lost_counts", size=1.5, seed=1347721059, noise="white").findings
    said = next(f for f in found["findings"] if f["cause"] == "position_offset")["evidence"]["of_each_session"]
    assert set(said) == {"session_0.tsv", "session_1.tsv", "session_2.tsv"} and all("µm at" in words for words in said.values())


@pytest.mark.parametrize("seed", rows(range(3), 1))
def test_strongly_coloured_noise_is_no_drift(tmp_path, seed):
    assert seek(tmp_path, None, seed=900 + seed, noise="ar").names == []


@pytest.mark.parametrize("seed", rows([41, 42, 43], 1))
def test_a_gain_that_is_off_in_the_held_out_session_alone_is_named(tmp_path, seed):
    made, _ = make_sessions(None, seed=seed, n_sessions=3)
    write_case([*made[:2], replace(made[2], taxels=1.02 * made[2].taxels)], tmp_path)
    recordings = load(tmp_path)
    (found,) = diagnose(recordings[:2], recordings[2:]).findings["findings"]
    assert (found["cause"], found["where"]) == ("gain_error", "taxel") and set(found["evidence"]["of_each_session"]) == {"session_2.tsv"}


@pytest.mark.parametrize("moment", rows([19.9, 21.7, 24.0], 1))
def test_counts_are_lost_wherever_blocks_of_a_session_begin(tmp_path, moment):
    """Blocks of four seconds are fitted and predicted by turns: a moment at their border, or within one, is found as well."""
    made, truth = make_sessions(None, seed=round(10 * moment), n_sessions=3, noise="white", protocol="multisine_only")
    off = max(2.0 * truth.noise_rms["force"] / (truth.skin.k1 + truth.skin.k2), 5e-6)
    write_case([replace(s, x=s.x - off * (s.t > moment)) for s in made], tmp_path)
    recordings = load(tmp_path)
    (found,) = diagnose(recordings[:2], recordings[2:]).findings["findings"]
    assert (found["cause"], found["where"]) == ("position_offset", "rig")
    for words in found["evidence"]["of_each_session"].values():
        assert min(abs(float(at) - moment) for at in re.findall(r"at ([\d.]+) s", words)) < 0.2, words


@pytest.mark.parametrize(
    ("seed", "protocol", "late_s"), rows([(1222616119, "single_rate_triangles", 0.08), (51, "full", 0.0137), (52, "full", 0.0137)], 1)
)
def test_a_buffer_that_slips_is_late_in_steps(tmp_path, seed, protocol, late_s):
    made, _ = make_sessions(None, seed=seed, n_sessions=3, noise="white", protocol=protocol)

    def slipped(s):
        late = late_s * (s.t > np.quantile(s.t, 0.6))
        return replace(s, force=np.interp(s.t - late, s.t, s.force))

    write_case([slipped(s) for s in made], tmp_path)
    recordings = load(tmp_path)
    (found,) = diagnose(recordings[:2], recordings[2:]).findings["findings"]
    assert (found["cause"], found["where"]) == ("time_shift", "clock")
    assert all("ms at" in words for words in found["evidence"]["of_each_session"].values())


@pytest.mark.parametrize("seed", rows([61, 62], 1))
def test_where_two_sessions_are_all_a_gain_that_steps_is_told_beside_another_skin(tmp_path, seed):
    """The skin of the held-out session is 3 % softer, as two gains would be; half a percent of the load cell's steps away."""
    made, _ = make_sessions(None, seed=seed, n_sessions=2, n_taxels=1, noise="white", protocol="full")
    softer = [1.0, 0.97]
    stepped = [1.0 + 0.005 * (s.t > np.quantile(s.t, 0.4)) for s in made]
    each = zip(made, softer, stepped, strict=True)
    write_case([replace(s, force=s.force * soft * step, taxels=s.taxels * soft) for s, soft, step in each], tmp_path)
    recordings = load(tmp_path)
    findings = diagnose(recordings[:1], recordings[1:]).findings
    assert [(f["cause"], f["where"]) for f in findings["findings"]] == [("gain_error", "load_cell")]
    values = [abs(q["value"]) for own in findings["findings"][0]["evidence"]["sessions"].values() for q in own]
    assert max(values) < 0.01 and ("parameters", "skin") in {(u["cause"], u.get("where")) for u in findings["untestable"]}


@pytest.mark.parametrize("late_s", rows([0.006, 0.015], 0))
def test_a_clock_that_wanders_is_late_by_so_much_in_turn(tmp_path, late_s):
    """Damping takes the mean of the delay, up to all that there is; what is left steps nowhere."""
    made, _ = make_sessions(None, seed=53, n_sessions=3, noise="white")
    write_case([replace(s, force=np.interp(s.t - late_s * (1.0 + 0.6 * np.sin(s.t / 2.7)), s.t, s.force)) for s in made], tmp_path)
    recordings = load(tmp_path)
    assert {(f["cause"], f["where"]) for f in diagnose(recordings[:2], recordings[2:]).findings["findings"]} == {("time_shift", "clock")}


@pytest.mark.slow
def test_a_clock_that_slips_in_one_fitted_session_alone_is_named(tmp_path):
    """No held-out session has it, so its gain is measured in the one that does."""
    how = {"seed": 301, "protocol": "full", "n_sessions": 5, "noise": "white"}
    plain, late = (make_sessions(hidden, **how)[0] for hidden in ([], [Hide("time_shift", "clock", "buffer", 1.5)]))
    write_case([plain[0], late[1], *plain[2:]], tmp_path)
    recordings = load(tmp_path)
    (found,) = diagnose(recordings[:3], recordings[3:]).findings["findings"]
    assert (found["cause"], found["where"]) == ("time_shift", "clock")
    assert "ms at" in found["evidence"]["of_each_session"][recordings[1].name]


@pytest.mark.parametrize(
    ("relative", "lower", "after", "agree"),
    [(0.02, 0.01, 0.9, True), (0.001, -0.001, 0.999, True), (-0.003, -0.006, 0.999, True), (0.001, -0.05, 0.999, False),
     (-0.05, -0.06, 0.9, False), (0.001, -0.001, 1.01, False)],
    ids=["they gain", "chance for it", "chance against it", "who knows", "they lose", "their error grows"],
)  # fmt: skip
def test_sessions_that_a_course_does_not_concern_do_not_contradict_it(relative, lower, after, agree):
    assert _agrees(Gain("force", ("force",), 1.0, after, (0.0, 0.0), relative, lower, "")) is agree


@pytest.mark.parametrize("held", rows([2, 3], 0))
def test_a_load_cell_with_a_gain_of_its_own_in_each_session_is_named(tmp_path, held):
    """Also where the gain of the held-out session is near to the mean, so that this one alone could not tell."""
    made, _ = make_sessions(None, seed=61, n_sessions=4, noise="white")
    gains = (1.0, 1.02, 0.99, 1.006) if held == 3 else (1.0, 1.02, 0.98, 1.01)
    write_case([replace(s, force=g * s.force) for s, g in zip(made, gains, strict=True)], tmp_path)
    recordings = load(tmp_path)
    (found,) = diagnose(recordings[:held], recordings[held:]).findings["findings"]
    assert (found["cause"], found["where"]) == ("gain_error", "load_cell")
    assert all(words.endswith(" %") for words in found["evidence"]["of_each_session"].values())


@pytest.mark.slow
def test_skin_that_is_stiffer_in_one_session_is_no_gain_of_a_sensor(tmp_path):
    made, _ = make_sessions(None, seed=62, n_sessions=3, noise="white")
    stiffness = (1.0, 1.03, 0.98)
    write_case([replace(s, force=k * s.force, taxels=k * s.taxels) for s, k in zip(made, stiffness, strict=True)], tmp_path)
    recordings = load(tmp_path)
    named = diagnose(recordings[:2], recordings[2:]).findings["findings"]
    assert not [f for f in named if f["cause"] == "gain_error"]


@pytest.mark.parametrize(("where", "times"), rows([("load_cell", 6.0), ("taxel", 6.0), ("load_cell", 3.0), ("taxel", 3.0)], 1))
def test_a_zero_that_jumps_is_an_offset_and_no_drift(tmp_path, where, times):
    """A gauge that comes loose, three times in every session and back again, at moments of each session's own."""
    made, truth = make_sessions(None, seed=63, n_sessions=3, noise="white")
    rng = np.random.default_rng(7)

    def jumping(s):
        at = s.t[0] + np.ptp(s.t) * (np.array([0.2, 0.45, 0.7]) + rng.uniform(-0.08, 0.08, 3))
        zero = times * np.array([0.0, 0.5, -0.5, 0.6])[np.searchsorted(at, s.t)]
        force, taxel = truth.noise_rms.values()
        return replace(s, force=s.force + force * zero) if where == "load_cell" else replace(s, taxels=s.taxels + taxel * zero[:, None])

    write_case([jumping(s) for s in made], tmp_path)
    recordings = load(tmp_path)
    (found,) = diagnose(recordings[:2], recordings[2:]).findings["findings"]
    assert (found["cause"], found["where"]) == ("force_offset", where)
    assert all("N at" in words for words in found["evidence"]["of_each_session"].values())


@pytest.mark.slow
def test_a_zero_that_jumps_at_about_the_same_time_in_every_session_is_no_drift(tmp_path):
    """Sessions share most of that, as a drift would have it; there is nothing for one to do beside the jumps."""
    made, truth = make_sessions(None, seed=64, n_sessions=3, noise="white")
    size = 5.0 * truth.noise_rms["force"]

    def jumping(s):
        begun = (s.t - s.t[0]) / np.ptp(s.t)
        return replace(s, force=s.force + size * ((begun > 0.3) & (begun < 0.6)))

    write_case([jumping(s) for s in made], tmp_path)
    recordings = load(tmp_path)
    assert [(f["cause"], f["where"]) for f in diagnose(recordings[:2], recordings[2:]).findings["findings"]] == [
        ("force_offset", "load_cell")
    ]


STEP_OF_ZERO = Course(ZERO, STEPS, (0,), "load_cell")


def stepping(depth=DEPTH, size=0.1, spikes=0.0):
    """A session whose load cell's zero steps half-way, with spikes that telemetry has bridged, and its noise."""
    r = recorded(PLAIN, depth)
    force = r.force + size * (T > 20.0)
    at = np.arange(100, 3900, 130)
    bad = np.zeros((2, T.size), bool)
    bad[0, at] = spikes != 0.0
    force[at] += spikes
    plain = prepare(recorded(PLAIN, depth, seed=5))
    return prepare(replace(r, force=force), bad), fit_whitener([residual(PLAIN, plain)], [plain])


def test_without_air_a_zero_that_jumps_is_judged_under_load():
    s, noise = stepping(DEPTH + 1e-3)
    ground = ground_of(PLAIN, [s], noise)
    run = _run(STEP_OF_ZERO, ground)
    assert run.score > 100.0 and shows_in_the_air(run, ground.plain, ground.sessions)


@pytest.mark.parametrize(("stiffer", "zero", "shows"), [(0.9, 0.0, False), (1.0, -0.1, True), (0.99, -0.1, True)])
def test_a_zero_of_a_session_shows_in_its_air_and_a_skin_that_differs_does_not(stiffer, zero, shows):
    r = recorded(PLAIN, np.where(T < 4.0, -2e-4, DEPTH))
    s = prepare(replace(r, force=stiffer * r.force + zero))
    ground = ground_of(PLAIN, [s], fit_whitener([residual(PLAIN, prepare(r))], [prepare(r)]))
    run = _run(replace(STEP_OF_ZERO, shape=CONSTANT), ground)
    assert run.score > 100.0 and run.largest > 0.05
    assert shows_in_the_air(run, ground.plain, ground.sessions) == shows


@pytest.mark.parametrize("spikes", [5.0, 50.0])
def test_samples_that_are_ruled_out_make_no_zero_faint(spikes):
    shares = []
    for size in (0.0, spikes):
        s, noise = stepping(spikes=size)
        shares.append(_share(_run(STEP_OF_ZERO, ground_of(PLAIN, [s], noise)), PLAIN, [s]))
    assert shares[1] > 0.9 * shares[0]


def test_of_gains_whose_mean_is_the_stiffness_one_fewer_is_charged():
    sessions = [prepare(recorded(PLAIN, seed=seed)) for seed in (1, 2, 3)]
    noise = fit_whitener([residual(PLAIN, s) for s in sessions], sessions)
    some = basis(stack([np.zeros((1, *s.measured.shape)) for s in sessions], sessions, noise))
    ground = ground_of(PLAIN, sessions, noise, some)
    gains, zeros = (_run(Course(carrier, CONSTANT, (0,), "load_cell"), ground) for carrier in (SLOPE, ZERO))
    assert gains.charge == pytest.approx(2.0 / 3.0 * zeros.charge)


def test_a_taxel_that_nothing_loads_has_no_gain():
    silent = replace(PLAIN, shares=(0.0,))
    s = prepare(recorded(silent))
    noise = fit_whitener([residual(silent, s)], [s])
    some = basis(stack([np.zeros((1, *s.measured.shape))], [s], noise))
    ground = ground_of(silent, [s, replace(s, name="b")], noise, np.concatenate([some, some]))
    assert _run(Course(SLOPE, CONSTANT, (1,), "taxel"), ground).score == 0.0
