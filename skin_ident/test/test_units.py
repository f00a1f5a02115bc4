"""Signs and units are asked of sessions that can tell them: not of a hold in which the stage gives way, nor at a place nobody declared."""

from dataclasses import replace

import numpy as np
import pytest

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.telemetry.odd_session import put_right
from skin_ident.criticism.telemetry.units import by_grid, find_unit_faults
from skin_ident.criticism.vocabulary import UNIT_FACTOR
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.recording import Recording

T = np.arange(3000) / 100.0
STIFFNESS, NOISE = 12000.0, 0.03  # N/m, N
DEPTH = 0.5e-3  # m
GRID = np.array([(x, y) for x in (-5.0, 0.0, 5.0) for y in (-5.0, 0.0, 5.0)])  # mm
WIDTH = 5.25  # mm


def made(name, seed, depth, force, shares=(0.7,)):
    """A recording of 1 µm in depth, with noise in its load cell and its taxels."""
    rng = np.random.default_rng(seed)
    rows = [share * force + NOISE * rng.standard_normal(force.size) for share in (1.0, *shares)]
    return Recording(name, T[: force.size], 1e-6 * np.rint(1e6 * depth), rows[0], np.array(rows[1:]))


def sines(seed, shares=(0.7,)):
    depth = DEPTH + 0.3e-3 * np.sin(2.0 * np.pi * 0.25 * T)
    return made(f"sines_{seed}", seed, depth, STIFFNESS * depth, shares)


def hold(creep, seed=9):
    """A hold that starts after touch: the skin relaxes by a quarter, and the depth grows by `creep`, m, as the force falls."""
    fallen = 1.0 - np.exp(-T / 10.0)
    return made("hold", seed, DEPTH + creep * fallen, STIFFNESS * DEPTH * (1.0 - 0.25 * fallen))


def held_force(creep):
    """The same under a force that is held instead of a depth: the taxel falls as the force grows by `creep`, N."""
    fallen = 1.0 - np.exp(-T / 10.0)
    return replace(made("hold", 9, 0.0 * T, 6.0 - 1.5 * fallen), depth=None, force=6.0 + creep * fallen)


def turned(r):
    return replace(r, taxels=-r.taxels)


def pressed_at(place, seed, name):
    return replace(sines(seed, 0.6 * np.exp(-((GRID - place) ** 2).sum(axis=1) / WIDTH**2)), name=name)


@pytest.mark.parametrize("creep", [3.5e-6, 20e-6, 60e-6, -0.4e-6, -3.5e-6, -12e-6, -20e-6])
@pytest.mark.parametrize("beside", [0, 1, 2, 4])
def test_a_stage_that_gives_way_in_a_hold_tells_neither_a_sign_nor_a_unit(creep, beside):
    recordings = [*map(sines, range(beside)), hold(creep)]
    assert find_unit_faults(recordings) == [] and put_right(recordings)[1] == ()


@pytest.mark.parametrize("relaxed", [0.4, 0.6])
@pytest.mark.parametrize("deeper", [0.3, 0.5])
def test_nor_does_a_slow_ramp_into_a_skin_that_still_relaxes(relaxed, deeper):
    depth = DEPTH * (1.0 + deeper * T / T[-1])
    recordings = [made("ramp", 9, depth, STIFFNESS * depth * (1.0 - relaxed + relaxed * np.exp(-T / 7.5)))]
    assert find_unit_faults(recordings) == [] and put_right(recordings)[1] == ()


def test_nor_does_one_spike_of_the_encoder_make_it_move():
    creeping = hold(20e-6)
    depth = creeping.depth.copy()
    depth[-5:] += 0.15e-3
    recordings = [replace(creeping, depth=depth)]
    assert find_unit_faults(recordings) == [] and put_right(recordings)[1] == ()


@pytest.mark.parametrize("creep", [0.01, 0.3])
def test_nor_a_force_that_is_held(creep):
    assert find_unit_faults([held_force(creep)]) == [] and put_right([held_force(creep)])[1] == ()


@pytest.mark.slow
def test_nor_does_a_diagnosis_that_has_the_hold_among_its_sessions():
    found = diagnose([sines(1), hold(3.5e-6)], [sines(2)]).findings["findings"]
    assert [f for f in found if f["cause"] == "data_error"] == []


@pytest.mark.parametrize("held", [0, 1])
def test_a_taxel_that_is_upside_down_is_turned_in_the_hold_too(held):
    upright = [sines(1), sines(2), *[hold(3.5e-6)] * held]
    right, (symptom,) = put_right([turned(r) for r in upright])
    assert (symptom.where, symptom.evidence["kind"]) == ("taxel", "sign")
    assert all(np.allclose(r.taxels, was.taxels) for r, was in zip(right, upright, strict=True))


def test_a_sign_that_is_wrong_in_one_session_is_found_beside_a_hold():
    upright = [sines(1), sines(2), sines(3), hold(3.5e-6)]
    right, (symptom,) = put_right([upright[0], turned(upright[1]), *upright[2:]])
    assert (symptom.evidence["kind"], symptom.evidence["session"]) == ("sign", "sines_2")
    assert np.allclose(right[1].taxels, upright[1].taxels) and np.array_equal(right[3].taxels, upright[3].taxels)


def test_one_session_of_many_that_hold_does_not_turn_them():
    recordings = [turned(sines(1)), hold(3.5e-6), hold(0.0)]
    assert put_right(recordings)[1] == ()
    (symptom,) = find_unit_faults(recordings)
    assert "in 1 of 1 sessions that tell it" in symptom.evidence["why"]


def test_a_sign_is_told_though_the_second_half_is_spent_in_the_air():
    depth = np.where(T < 14.0, DEPTH * np.abs(np.sin(0.5 * np.pi * T)), -0.9e-3 * np.maximum(T - 14.0, 0.0) / 16.0)
    (symptom,) = find_unit_faults([turned(made("retracting", 1, depth, STIFFNESS * np.maximum(depth, 0.0)))])
    assert (symptom.where, symptom.evidence["kind"]) == ("taxel", "sign")


@pytest.mark.parametrize("amplitude", [0.05e-3, 0.09e-3])
def test_a_sign_is_told_by_a_small_motion_about_a_preload(amplitude):
    depth = 1e-3 + amplitude * np.sin(np.pi * T)
    recordings = [made("about_a_preload", 1, depth, STIFFNESS * depth)]
    (symptom,) = find_unit_faults([turned(r) for r in recordings])
    assert symptom.evidence["kind"] == "sign" and find_unit_faults(recordings) == []


def test_a_factor_of_units_is_found_beside_a_taxel_that_has_come_loose():
    recordings = [pressed_at(0.0, k, f"session_{k}") for k in range(4)]
    wrong = recordings[3].scaled({"taxel_1": 1.0 / 9.80665, "taxel_3": 0.75})
    assert [s.channels for s in find_unit_faults([*recordings[:3], wrong])] == [("taxel_1",)]


@pytest.mark.parametrize("elsewhere", [1, 2])
def test_a_second_place_that_nobody_declared_is_no_factor_of_units(elsewhere):
    for seed in range(8):
        place = np.random.default_rng(seed).uniform(-5.0, 5.0, 2)
        recordings = [pressed_at(0.0 if k < 3 else place, 10 * seed + k, f"session_{k}") for k in range(3 + elsewhere)]
        assert find_unit_faults(recordings) == [] and put_right(recordings)[1] == (), f"pressed at {place} mm"


@pytest.mark.parametrize("channel", [1, 4])
@pytest.mark.parametrize("factor", [1000.0, 1.0 / 9.80665])
def test_a_factor_of_units_of_one_taxel_is_found_at_one_place(channel, factor):
    recordings = [pressed_at(0.0, k, f"session_{k}") for k in range(4)]
    wrong = recordings[3].scaled({f"taxel_{channel}": factor})
    for (symptom,) in (find_unit_faults([*recordings[:3], wrong]), put_right([*recordings[:3], wrong])[1]):
        assert (symptom.channels, symptom.evidence["session"]) == ((f"taxel_{channel}",), "session_3")
        assert symptom.parameters["factor"]["value"] == pytest.approx(factor, rel=0.05)


def test_two_taxels_in_other_units_do_not_speak_for_another_place():
    recordings = [pressed_at(0.0, k, f"session_{k}") for k in range(4)]
    wrong = recordings[3].scaled({"taxel_1": 1000.0, "taxel_4": 1.0 / 9.80665})
    assert {s.channels for s in put_right([*recordings[:3], wrong])[1]} == {("taxel_1",), ("taxel_4",)}


def test_a_factor_of_units_is_found_beside_a_hold():
    recordings = [*map(sines, range(3)), sines(3).scaled({"force": 9.80665}), hold(3.5e-6)]
    for (symptom,) in (find_unit_faults(recordings), put_right(recordings)[1]):
        assert (symptom.channels, symptom.evidence["session"]) == (("force",), "sines_3")


def test_the_time_at_which_a_unit_changes_is_that_of_the_record():
    r = replace(sines(0), declared=Declared(force_step_n=0.02))
    pounds = np.where(T < 20.0, 1.0, 4.44822) * 0.02 * np.round(r.force / 0.02)
    (symptom,) = find_unit_faults([replace(r, force=pounds, t=T + 1000.0)])
    assert "from about 1020.0 s on" in symptom.evidence["why"]


def test_levels_of_a_tenth_of_the_declared_step_are_of_an_amplifier_that_averages():
    def found(factor: float) -> list:
        apart, noise = 0.004, np.random.default_rng(4).normal(scale=0.05, size=(2, T.size))
        rounded = [replace(sines(i), force=apart * np.round(row / apart)) for i, row in enumerate(noise)]
        return by_grid([replace(r, declared=Declared(force_step_n=apart / factor)) for r in rounded], "force")

    assert found(0.1) == [] and found(1.0) == []
    assert [s.evidence["kind"] for s in (*found(4.44822), *found(0.0980665))] == [UNIT_FACTOR] * 2
