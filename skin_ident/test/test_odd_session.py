"""A session that differs from the others in whole is found, put right and said; no number that was fitted is refused for its size."""

from dataclasses import replace

import numpy as np
import pytest
from test_faults import session

from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.sessions.session import prepare
from skin_ident.criticism.telemetry.odd_session import put_right
from skin_ident.recordings.declared import Declared
from skin_models.effects.gain_error import GainError
from skin_models.parameter import clipped


def sessions(count, odd=1, change=lambda r: r):
    return [change(r) if i == odd else r for i, r in enumerate(session(i) for i in range(count))]


def times(channel, factor):
    def change(r):
        if channel == "force":
            return replace(r, force=factor * r.force)
        taxels = r.taxels.copy()
        taxels[int(channel[-1])] *= factor
        return replace(r, taxels=taxels)

    return change


def reordered(order):
    return lambda r: replace(r, taxels=r.taxels[list(order)])


@pytest.mark.parametrize(("channel", "factor"), [("taxel_0", 1000.0), ("taxel_2", 1e-3), ("force", 4.44822), ("taxel_1", -1.0)])
@pytest.mark.parametrize("count", [3, 5])
def test_a_factor_in_one_session(channel, factor, count):
    right, (symptom,) = put_right(sessions(count, 1, times(channel, factor)))
    assert (symptom.cause, symptom.channels, symptom.evidence["session"]) == ("data_error", (channel,), "session_1")
    assert symptom.parameters["factor"]["value"] == pytest.approx(factor)
    assert np.allclose(right[1].channels[channel], session(1).channels[channel])


@pytest.mark.parametrize(("factor", "found"), [(1e3, 1), (10.0, 0), (1e5, 0)])
def test_a_taxel_in_millinewtons_where_every_session_presses_elsewhere(factor, found):
    places = Declared(contact_position_mm={f"session_{i}": (float(i), 0.0) for i in range(3)})
    right, symptoms = put_right([replace(r, declared=places) for r in sessions(3, 1, times("taxel_2", factor))])
    assert [(s.cause, s.channels, s.evidence["session"]) for s in symptoms] == [("data_error", ("taxel_2",), "session_1")] * found
    assert np.allclose(right[1].taxels, (1.0 if found else [[1.0], [1.0], [factor]]) * session(1).taxels)


@pytest.mark.parametrize("change", [times("force", 1e-3), lambda r: replace(r, depth=np.full(len(r), 1e-4)), lambda r: r.warned("")])
def test_neither_a_force_in_kilonewtons_nor_a_plunger_at_rest_says_that_of_a_taxel(change):
    places = Declared(contact_position_mm={f"session_{i}": (float(i), 0.0) for i in range(3)})
    assert put_right([replace(r, declared=places) for r in sessions(3, 1, change)])[1] == ()


def test_taxels_in_volts_are_in_no_wrong_unit():
    volts = [replace(r, taxel_units=("V",) * 3) for r in sessions(3, 1, times("taxel_2", 1e3))]
    places = Declared(contact_position_mm={f"session_{i}": (float(i), 0.0) for i in range(3)})
    assert put_right([replace(r, declared=places) for r in volts])[1] == ()


@pytest.mark.parametrize("change", [times("taxel_1", -1.0), reordered((1, 0, 2))])
def test_what_a_minority_of_sessions_has_is_one_finding(change):
    right, (symptom,) = put_right([change(r) if i in (1, 4) else r for i, r in enumerate(sessions(5))])
    assert symptom.cause == "data_error" and symptom.evidence["only_in"] == ["session_1", "session_4"]
    assert "in session_1 and session_4" in symptom.evidence["why"]
    assert all(np.allclose(r.taxels, session(i).taxels) for i, r in enumerate(right))


def test_of_as_many_sessions_nobody_knows_which_are_in_order():
    assert not put_right([reordered((1, 0, 2))(r) if i in (1, 3) else r for i, r in enumerate(sessions(4))])[1]


@pytest.mark.parametrize("factor", [1e-3, 1e3, 1 / 25.4, 0.1])
@pytest.mark.parametrize("count", [2, 4])
def test_a_depth_in_another_unit_of_length(count, factor):
    right, (symptom,) = put_right(sessions(count, 1, lambda r: replace(r, depth=factor * r.depth)))
    assert (symptom.cause, symptom.where, symptom.channels, symptom.evidence["session"]) == ("data_error", "rig", ("depth",), "session_1")
    assert symptom.parameters["factor"]["value"] == factor and np.allclose(right[1].depth, session(1).depth)


@pytest.mark.parametrize("count", [1, 3])
def test_a_taxel_that_is_upside_down_in_all_sessions_is_turned_round(count):
    right, (symptom,) = put_right([times("taxel_1", -1.0)(session(i)) for i in range(count)])
    assert (symptom.cause, symptom.where, symptom.evidence["kind"]) == ("data_error", "taxel_1", "sign")
    assert all(np.allclose(r.taxels, session(i).taxels) for i, r in enumerate(right))


@pytest.mark.parametrize("driven", [False, True], ids=["with a depth", "driven by the force"])
def test_a_load_cell_that_is_upside_down_in_all_sessions_is_turned_round(driven):
    made = [replace(r, depth=None) if driven else r for r in sessions(3)]
    right, (symptom,) = put_right([times("force", -1.0)(r) for r in made])
    assert (symptom.cause, symptom.where, symptom.evidence["kind"]) == ("data_error", "load_cell", "sign")
    assert all(np.allclose(r.force, session(i).force) and np.allclose(r.taxels, session(i).taxels) for i, r in enumerate(right))


def test_taxels_that_fall_while_a_force_presses_are_upside_down_themselves():
    right, symptoms = put_right([replace(r, depth=None, taxels=-r.taxels) for r in sessions(3)])
    assert {s.where for s in symptoms} == {"taxel_0", "taxel_1", "taxel_2"}
    assert all(np.allclose(r.force, session(i).force) for i, r in enumerate(right))


@pytest.mark.parametrize(("order", "moved"), [((2, 1, 0), ("taxel_0", "taxel_2")), ((1, 2, 0), ("taxel_0", "taxel_1", "taxel_2"))])
def test_columns_in_another_order(order, moved):
    right, (symptom,) = put_right(sessions(4, 3, reordered(order)))
    assert (symptom.cause, symptom.channels, symptom.evidence["session"]) == ("data_error", moved, "session_3")
    assert np.array_equal(right[3].taxels, session(3).taxels)


def test_columns_that_are_much_alike_are_known_where_the_other_sessions_agree():
    def alike(r):
        return replace(r, taxels=np.array([1.0, 0.9, 1.05])[:, None] * r.taxels[:1] + 0.01 * (r.taxels - r.taxels[:1]))

    made = [alike(session(i)) for i in range(3)]
    right, (symptom,) = put_right([made[0], reordered((1, 0, 2))(made[1]), made[2]])
    assert (symptom.evidence["kind"], symptom.channels) == ("swapped columns", ("taxel_0", "taxel_1"))
    assert np.array_equal(right[1].taxels, made[1].taxels)
    assert not put_right([made[0], times("taxel_1", 1.1)(made[1]), made[2]])[1]


def test_with_two_sessions_nobody_knows_which():
    _, (symptom,) = put_right(sessions(2, 1, reordered((2, 1, 0))))
    assert "the other one" in symptom.evidence["why"]


@pytest.mark.parametrize("factor", [1.3, 0.6, 2.0])
def test_a_gain_or_a_stiffer_day_is_no_error_of_data(factor):
    assert not put_right(sessions(4, 2, times("taxel_1", factor)))[1]
    assert not put_right(sessions(4, 2, lambda r: replace(r, depth=r.depth * factor)))[1]


def test_sessions_at_other_places_are_not_compared():
    r = [replace(s, declared=replace(s.declared, contact_position_mm={s.name: (float(i), 0.0)})) for i, s in enumerate(sessions(3))]
    assert not put_right([reordered((2, 1, 0))(r[0]), *r[1:]])[1]


@pytest.mark.slow
def test_it_is_the_finding_and_the_rest_is_judged_without_it():
    outcome = diagnose(sessions(4, 1, reordered((2, 1, 0))))
    assert [f["cause"] for f in outcome.findings["findings"]] == ["data_error"] and outcome.findings["verdict"] == "explained"
    assert outcome.findings["baseline"]["parameters"]["k1"]["value"] == pytest.approx(9619.0, rel=0.01)


def test_taxels_in_other_units_throughout_are_fitted():
    recordings = [times("taxel_0", 1e3)(r) for r in sessions(2)]
    assert dispersion_start([prepare(r) for r in recordings]).dispersion.k2 < -9e6


def test_what_is_too_large_is_clipped():
    assert clipped(GainError, gain=-0.98) == {"gain": -0.95} and clipped(GainError, gain=0.2) == {"gain": 0.2}
