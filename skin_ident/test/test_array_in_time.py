"""What goes on in time is found in rows that are pressed at several places, where every session has shares of its own."""

from dataclasses import replace

import numpy as np
import pytest
from array_making import Spread, found, names, names_or_rivals, record_at
from rows import rows

from skin_ident.criticism.array.layout import layout_of
from skin_ident.criticism.array.spreading import with_spread
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.baseline.settling import settled
from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.sessions.session import prepare, with_reference
from skin_models.catalogue import effects

ROW = ((0, 0), (4, 0), (-4, 0), (2, 0))
HOW = {"noise": "white", "thickness_mm": 4, "layout": "row_5mm"}


@pytest.mark.parametrize(
    ("cause", "form", "where"),
    rows(
        [
            ("lag", "one_pole", "taxel_1"),
            ("drift", None, "taxel_1"),
            ("saturation", "soft", "taxel_0"),
            ("dead_zone", "threshold", "taxel_0"),
            ("nonlinear_stiffness", None, "skin"),
            ("backlash", None, "rig"),
        ],
        quick=0,
    ),
)
def test_a_cause_is_named_at_its_place_and_alone(tmp_path, cause, form, where):
    assert names(found(record_at(tmp_path, ROW, cause, form, where, size=2.0, seed=5, **HOW))) == [(cause, where)]


def driven_at(folder, contacts, *hidden, **how):
    """The same without a depth: a force drives the simulation."""
    return [replace(r, depth=None) for r in record_at(folder, contacts, *hidden, seed=5, **how, **HOW)]


@pytest.mark.parametrize(("cause", "form", "where"), [(None, None, None), ("lag", "one_pole", "taxel_1")])
@pytest.mark.slow
def test_the_same_where_a_force_drives_the_test(tmp_path, cause, form, where):
    recordings = driven_at(tmp_path, ((0, 0), (7, 0), (-7, 0), (4, 0)), cause, form, where, size=2.0)
    assert names(found(recordings)) == ([(cause, where)] if cause else [])


def test_a_fit_to_a_driving_force_starts_from_the_shares_of_each_session(tmp_path):
    """However little a taxel is pressed in most places, the model itself shares the force alike."""
    recordings = driven_at(tmp_path, ((-4, 0), (7, 0), (8, 0)))
    sessions = [prepare(r) for r in with_spread(recordings, layout_of(recordings))]
    assert dispersion_start(sessions).shares == pytest.approx((1.0,) * 3)


@pytest.mark.slow
def test_the_loop_of_one_taxel_is_named_or_admitted(tmp_path):
    findings = found(record_at(tmp_path, ROW, "hysteresis", None, "taxel_0", size=2.0, seed=5, **HOW))
    assert ("hysteresis", "taxel_0") in names_or_rivals(findings) and len(names(findings)) == 1


@pytest.mark.slow
def test_a_spread_that_widens_with_depth_is_told_from_sessions_at_several_places(tmp_path):
    findings = found(record_at(tmp_path, ROW, seed=5, also=[(Spread("deepening"), 0.05)], **HOW))
    assert names(findings) == [("spread_depth", "skin")]


@pytest.mark.parametrize("seed", rows(range(3), 0))
def test_sound_rows_are_silent(tmp_path, seed):
    assert not names(found(record_at(tmp_path, ROW, seed=seed, thickness_mm=4, layout="row_5mm")))


@pytest.fixture(scope="module")
def row(tmp_path_factory):
    recordings = record_at(tmp_path_factory.mktemp("row"), ROW[:3], seed=1, **HOW)
    sessions = with_reference([prepare(r) for r in with_spread(recordings, layout_of(recordings))])
    return dispersion_start(sessions), sessions


def test_one_taxel_of_one_session_is_the_reference(row):
    _, sessions = row
    kept = [(i, s.reference) for i, s in enumerate(sessions) if s.reference is not None]
    assert len(kept) == 1 and sessions[kept[0][0]].spread[kept[0][1]] == max(s.spread.max() for s in sessions)


def test_what_a_session_says_of_its_shares_does_not_matter_but_for_the_reference(row):
    model, sessions = row
    for s in sessions:
        factors = np.where(np.arange(3) == s.reference, 1.0, [0.7, 1.2, 0.9])
        assert np.allclose(residual(model, replace(s, spread=s.spread * factors)), residual(model, s), atol=1e-9)


def test_shares_settle_under_a_taxel_that_swallows_small_forces(row):
    model, sessions = row
    dead = next(e for e in effects() if e.cause == "dead_zone" and e.form == "hard")
    swallowing = model.extended(dead("taxel", threshold=0.3))
    s = replace(sessions[0], reference=None)
    told = replace(s, pinned=True)
    measured = told.measured - residual(swallowing, told)
    found_again = settled(swallowing, replace(s, measured=measured, spread=s.spread * [0.8, 1.3, 0.9]))
    assert np.allclose(found_again.spread, s.spread, rtol=2e-3)
