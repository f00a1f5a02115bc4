"""What a diagnosis refuses, in one sentence, and what it takes for still."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from skin_ident.cli.diagnose import apart
from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.one_rig import of_one_rig
from skin_ident.criticism.telemetry.bursts import told_of_bursts
from skin_ident.criticism.telemetry.dead import find_dead_taxels
from skin_ident.criticism.telemetry.quantization import find_buried, find_quantization, undeclared_steps
from skin_ident.criticism.telemetry.still import is_still
from skin_ident.criticism.telemetry.symptom import Symptom, quantity
from skin_ident.criticism.telemetry.units import find_unit_faults
from skin_ident.criticism.usable import are_other_data, belong_together, doubted, in_sound_units, something_moves
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.recording import Recording

T = np.arange(4000) / 200.0


def presses(seed: int = 0, **changed) -> Recording:
    """Two sinusoids into a linear skin, a load cell and a taxel with noise."""
    rng = np.random.default_rng(seed)
    x = 1e-3 * (0.8 * np.sin(3.0 * T) + 0.5 * np.sin(7.3 * T) + 0.3)
    force = 1500.0 * np.maximum(x, 0.0)
    rows = {"depth": x, "force": force + rng.normal(0.0, 0.03, T.size), "taxels": 0.7 * force[None] + rng.normal(0.0, 0.03, T.size)}
    return Recording(f"session_{seed}", T, **(rows | changed))


def refused(recordings: list) -> str:
    with pytest.raises(DiagnosisError) as error:
        belong_together(recordings)
        something_moves(recordings)
    return str(error.value)


def test_sound_presses_are_used():
    belong_together([presses(0), presses(1)])
    something_moves([presses(0), presses(1)])
    away = presses(2).depth + 2e-3  # preloaded, and so is the force
    belong_together([presses(2, depth=away, force=1500.0 * away)] * 2)


@pytest.mark.parametrize("seed", range(3))
def test_a_depth_and_a_force_that_are_exchanged_are_asked_about(seed):
    """The plunger rests at the surface for a while, as everywhere between two presses."""
    x = np.where(T < 3.0, -0.3e-3 * np.abs(np.sin(5.0 * T)), presses(seed).depth)
    rng, force = np.random.default_rng(seed), 1500.0 * np.maximum(x, 0.0)
    sound = presses(seed, depth=x, force=force + rng.normal(0.0, 0.005, T.size))
    belong_together([sound] * 2)
    exchanged = replace(sound, depth=1e-3 * sound.force, force=1e3 * sound.depth)
    assert "are the columns of depth and force exchanged?" in refused([exchanged] * 2)


def test_sessions_of_other_channels_are_told_apart_by_what_they_have():
    said = refused([presses(0), presses(1, force=None)])
    assert "session_0: depth, force and 1 taxel; session_1: depth and 1 taxel" in said


def declaring(*each: dict) -> list[Recording]:
    return [presses(i, declared=Declared(**declared)) for i, declared in enumerate(each)]


def test_what_one_session_declares_holds_for_all():
    shared = [r.declared for r in of_one_rig(declaring({"moving_mass_kg": 0.01}, {}, {"force_noise_n": 0.03}))]
    assert [(d.moving_mass_kg, d.force_noise_n) for d in shared] == [(0.01, 0.03)] * 3
    places = of_one_rig(declaring({"taxel_positions_mm": ((0.0, 0.0),), "contact_position_mm": {"": (5.0, 0.0)}}, {}))
    assert places[1].declared.taxel_positions_mm == () and places[1].declared.contact_position_mm == {}


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({"moving_mass_kg": 0.01}, {"moving_mass_kg": 0.2}),
        ({"skin_thickness_mm": 4.0}, {"skin_thickness_mm": 6.0}),
        ({"taxel_positions_mm": ((0.0, 0.0),)}, {"taxel_positions_mm": ((1.0, 0.0),)}),
    ],
)
def test_sessions_of_another_rig_are_refused(one, other):
    (key,) = one
    with pytest.raises(DiagnosisError, match=f"declares {key} .* for session_0 and .* for session_2, and a model is of one skin"):
        of_one_rig(declaring(one, one, other))


def test_of_steps_and_noise_that_differ_the_largest_is_expected_and_said():
    first, second = of_one_rig(declaring({"taxel_noise_n": (0.02,), "force_step_n": 0.1}, {"taxel_noise_n": (0.01,), "force_step_n": 0.2}))
    assert first.declared == second.declared
    assert (first.declared.taxel_noise_n, first.declared.force_step_n) == ((0.02,), 0.2)
    assert [w for w in first.warnings if "taxel_noise_n [0.02] for session_0 and [0.01] for session_1: the largest" in w]
    assert len(first.warnings) == 2 and not second.warnings


def test_what_is_held_out_must_not_have_been_fitted():
    are_other_data([presses(0), presses(1)], [presses(2)])
    with pytest.raises(DiagnosisError, match=r"copy, which is held out, holds the same samples as session_1"):
        are_other_data([presses(0), presses(1)], [replace(presses(1), name="copy")])


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"depth": None, "taxels": np.empty((0, 0))}, "force alone"),
        ({"force": None, "taxels": np.empty((0, 0))}, "depth alone"),
        ({"depth": np.full(T.size, 5e-4)}, "never moves"),
        ({"depth": 5e-4 + np.random.default_rng(3).normal(0.0, 1e-6, T.size)}, "never moves"),
        ({"force": np.ones(T.size)}, "does not follow"),
        ({"force": None, "taxels": np.ones((1, T.size))}, "no taxel follows"),
        ({"force": np.random.default_rng(3).normal(1.0, 0.03, T.size)}, "does not follow"),
        ({"depth": 0.0372 + presses().depth}, "stage's own zero"),
        ({"depth": 0.006 + presses().depth, "declared": Declared(skin_thickness_mm=4.0)}, "in a skin of 4 mm"),
    ],
)
def test_what_says_nothing_is_refused(changed, said):
    assert said in refused([presses(0, **changed), presses(1, **changed)])


def test_sizes_that_only_a_wrong_unit_gives_are_refused_with_depth_or_without():
    for changed in ({}, {"depth": None}, {"force": None}):
        sound = presses(0, **changed)
        assert in_sound_units([sound])[0].warnings == ()
        with pytest.raises(DiagnosisError, match=r"check (the units|its unit)"):
            in_sound_units([replace(sound, force=None if sound.force is None else 1e-3 * sound.force, taxels=1e4 * sound.taxels)])


def test_units_are_not_doubted_where_a_share_is_small_or_a_taxel_counts():
    small = presses(0, taxels=0.02 * presses().taxels + np.random.default_rng(5).normal(0.0, 0.003, T.size))
    assert in_sound_units([small])[0].warnings == ()
    counts = presses(0, taxels=np.round(400.0 * presses().taxels))
    assert in_sound_units([counts])[0].warnings == ()
    (faint,) = in_sound_units([presses(0, taxels=1e-3 * presses().taxels)])
    assert "0.07 % of the applied force" in faint.warnings[0]


def test_units_are_asked_about_where_no_taxel_feels_a_hundredth_of_the_force_in_any_session():
    """A load cell in grams-force looks like a taxel beside the plunger; in one session of several the plunger may be beside it."""
    grams = [presses(i, force=1e3 / 9.80665 * presses(i).force) for i in range(2)]
    first, second = in_sound_units(grams)
    assert "0.69 % of the applied force: check the units" in first.warnings[0] and not second.warnings
    assert [r.warnings for r in in_sound_units([grams[0], presses(1)])] == [(), ()]


def test_a_twin_of_the_same_size_vouches_for_it():
    soft = presses(0, force=0.01 * presses().force, taxels=0.01 * presses().taxels)
    with pytest.raises(DiagnosisError, match="units of depth and force"):
        in_sound_units([soft], twins=[presses(1)])
    assert in_sound_units([soft], twins=[replace(soft, name="twin")])[0] is soft


def test_seconds_between_samples_are_asked_about_unless_the_rate_is_declared():
    slow = [replace(presses(i), t=1e3 * T) for i in (0, 1)]
    with pytest.raises(RecordingError, match=r"is the time in milliseconds\? .* sample_rate_hz"):
        belong_together(slow)
    belong_together([replace(r, declared=Declared(sample_rate_hz=0.2)) for r in slow])


def test_volts_that_may_be_the_load_cell_are_asked_for():
    rows = np.vstack([presses().force, presses().taxels[0]])
    volts = [presses(i, force=None, taxels=rows, taxel_names=("ai0", "ai1"), taxel_units=("V", "V")) for i in (0, 1)]
    assert "ai0, ai1" in refused(volts) and "slope_n_per_v" in refused(volts)
    belong_together([replace(r, taxel_names=("taxel_0", "taxel_1")) for r in volts])
    belong_together([replace(r, force=presses().force) for r in volts])


def test_a_zero_that_may_be_off_is_warned_of():
    assert doubted(presses()).warnings == ()
    away = presses(0, depth=presses().depth + 3e-3)
    assert "may not be the surface" in doubted(away).warnings[0]
    assert doubted(replace(away, force=1500.0 * away.depth)).warnings == ()


def test_short_recordings_are_refused():
    assert "too short" in refused([presses(0).part(0, 200), presses(1)])
    assert "alone" in refused([presses(0).part(0, 800)])
    slow = presses(1)
    slow = replace(slow, t=20.0 * slow.t)  # what they have in common is seen at the slow one's rate alone
    assert "too short" in refused([presses(0).part(0, 400), slow])


def test_motion_is_told_from_noise():
    rng = np.random.default_rng(1)
    assert is_still(np.ones(50)) and is_still(rng.normal(1.0, 0.1, 5000))
    assert not is_still(np.sin(2.0 * np.pi * 0.16 * np.arange(5000)))
    spiky = np.sin(0.05 * np.arange(5000))
    spiky[::1000] = 1e3
    assert not is_still(spiky)


def test_no_taxel_is_dead_while_nothing_moves():
    noise = np.random.default_rng(2).normal(1.0, 0.03, (2, T.size))
    still = presses(0, depth=np.full(T.size, 5e-4), force=noise[0], taxels=noise[1:])
    assert find_dead_taxels([still]) == []
    assert find_dead_taxels([replace(still, taxels=np.ones((1, T.size)))]) == []
    (stuck,) = find_dead_taxels([presses(0, taxels=np.ones((1, T.size)))])
    assert stuck.cause == "dead_taxel"


def test_a_skin_that_is_left_behind_and_met_again_is_no_loose_contact():
    x = 1e-3 * (1.2 + np.sin(2.0 * np.pi * 0.5 * T))
    left = np.sin(2.0 * np.pi * 0.5 * T + 0.6) < 0.0  # parted on the way out, met at a jump on the way in
    reading = np.where(left, 0.0, 1500.0 * x)[None] + np.random.default_rng(4).normal(0.0, 0.01, T.size)
    assert find_dead_taxels([presses(0, depth=x, force=None, taxels=reading)]) == []
    gone = np.sin(2.0 * np.pi * 1.7 * T) < -0.4
    loose = np.where(gone, 0.0, 1500.0 * x)[None] + np.random.default_rng(4).normal(0.0, 0.01, T.size)
    (found,) = find_dead_taxels([presses(0, depth=x, force=None, taxels=loose)])
    assert found.evidence["kind"] == "intermittent"


@pytest.mark.parametrize(("zero", "warned"), [(0.0, False), (0.05, False), (1.0, True), (-1.0, True), (20.0, True)])
def test_a_driving_force_that_starts_far_from_zero_is_asked_about(zero, warned):
    sound = presses()
    r = doubted(replace(sound, depth=None, force=sound.force + zero))
    assert any("tare" in w for w in r.warnings) == warned
    assert not doubted(replace(sound, force=sound.force + zero)).warnings, "the depth drives"


def test_a_load_cell_that_is_upside_down_was_tared_all_the_same():
    turned = [replace(r, depth=None, force=-r.force) for r in (presses(0), presses(1), presses(2))]
    found = diagnose(turned[:2], turned[2:]).findings
    assert ("data_error", "load_cell") in {(f["cause"], f["where"]) for f in found["findings"]}
    assert not any("tare" in w for w in found["warnings"])


@pytest.mark.parametrize("zero", [0.0, 2.0, -2.0])
def test_a_loose_contact_is_found_whatever_the_taxel_reads_in_the_air(zero):
    x = 1e-3 * np.maximum(0.5 + np.sin(2.0 * np.pi * 0.5 * T), 0.0)
    gone = np.sin(2.0 * np.pi * 1.7 * T) < -0.4
    reading = zero + np.where(gone, 0.0, 1500.0 * x)[None] + np.random.default_rng(4).normal(0.0, 0.01, T.size)
    (found,) = find_dead_taxels([presses(0, depth=x, force=1e4 * x, taxels=reading)])
    assert found.evidence["kind"] == "intermittent"
    assert found.parameters["level"]["value"] == pytest.approx(zero, abs=0.05)


def test_steps_declared_in_newtons_say_nothing_of_volts():
    volts = np.round(presses().taxels / 0.01) * 0.0444822
    sessions = [presses(i, taxels=volts, taxel_units=("V",), declared=Declared(taxel_step_n=(0.01,))) for i in (0, 1)]
    assert find_unit_faults(sessions) == [] and find_quantization(sessions) == []
    newtons = [replace(r, taxel_units=("N",)) for r in sessions]
    assert [s.evidence["kind"] for s in find_unit_faults(newtons)] == ["unit factor"]


@pytest.mark.parametrize("odd", [(1,), (1, 3)])
def test_sessions_in_kilograms_are_one_fault_though_their_factor_is_near_ten(odd):
    sessions = [presses(i, force=presses(i).force * (9.80665 if i in odd else 1.0)) for i in range(5)]
    (symptom,) = find_unit_faults(sessions)
    assert symptom.parameters["factor"]["value"] == pytest.approx(9.80665)
    assert all((r.name in symptom.evidence["why"]) == (i in odd) for i, r in enumerate(sessions))


@pytest.mark.parametrize(("noise", "buried"), [(0.02, True), (0.05, False)])
def test_steps_that_nobody_declared_are_found_where_they_bury_the_noise(noise, buried):
    smooth = presses().force
    clean = 1500.0 * np.maximum(presses().depth, 0.0)
    stepped = 0.1 * np.rint((clean + np.random.default_rng(5).normal(0.0, noise, T.size)) / 0.1)
    sessions = [presses(i, force=stepped) for i in (0, 1)]
    assert undeclared_steps(sessions) == {"force": pytest.approx(0.1)} and undeclared_steps([presses(0, force=smooth)]) == {}
    rests = [np.array([stepped - clean])] * 2
    found = find_buried(sessions, ("force",), rests, [np.ones(T.size, bool)] * 2)
    assert [(s.cause, s.where) for s in found] == [("quantization", "load_cell")] * buried
    said = [replace(r, declared=Declared(force_step_n=0.1)) for r in sessions]
    assert find_buried(said, ("force",), rests, [np.ones(T.size, bool)] * 2) == []


def test_a_file_counts_once_and_a_held_out_one_is_not_fitted(tmp_path):
    a, b = (tmp_path / name for name in ("a.tsv", "b.tsv"))
    a.write_text("x"), b.write_text("x")
    assert apart([str(tmp_path)], [str(b)]) == ([(a, "")], [(b, "it was given to fit, too: it is held out, and not fitted")])
    ((file, said),), held = apart([str(a), str(a)], [])
    assert file == a and "counts once" in said and held == []
    with pytest.raises(RecordingError, match="none is left to fit"):
        apart([str(a)], [str(a)])


def test_a_line_that_comes_and_goes_is_told_with_its_size_in_bursts():
    line = Symptom("interference", "load_cell", ("force",), {"frequency": quantity(11.0, "Hz")}, {"why": "a line"})
    steady = 0.2 * np.sin(2.0 * np.pi * 11.0 * T) + np.random.default_rng(6).normal(0.0, 0.05, T.size)
    bursts = np.where(np.sin(0.7 * T) > 0.9, steady, steady - 0.2 * np.sin(2.0 * np.pi * 11.0 * T))
    recordings = [SimpleNamespace(name=name, dt=0.005) for name in ("a", "b")]
    assert told_of_bursts(line, recordings, ("force",), [steady[None]] * 2) == line
    told = told_of_bursts(line, recordings, ("force",), [bursts[None]] * 2)
    in_one = replace(line, evidence={**line.evidence, "only_in": ["a"]})
    quiet = np.random.default_rng(7).normal(0.0, 0.05, T.size)
    assert "in_bursts" in told_of_bursts(in_one, recordings, ("force",), [bursts[None], quiet[None]]).parameters
    assert "in bursts" in told.evidence["why"] and told.parameters["in_bursts"]["value"] == pytest.approx(0.2, rel=0.25)
