"""Without a depth the force drives the simulation: a fault of its load cell shows in the taxels, and is told as a candidate there."""

from dataclasses import replace

import numpy as np
import pytest
from rows import rows
from world import make_sessions, without, write_case

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.vocabulary import CAUSES
from skin_ident.recordings.load import load
from skin_ident.report.counsel import sure
from skin_ident.report.reading import view
from skin_models.catalogue import effects

OF_LOAD_CELL = {c.name for c in CAUSES} & {cls.cause for cls in effects() if "load_cell" in cls.places}


def driven(folder, cause=None, where=None, form=None, size=3.0, seed=1, taxels=1):
    """Three sessions of load cell and taxels, from a rig in which something is hidden."""
    write_case([without(s, "x") for s in make_sessions(cause, where, form, size, seed=seed, n_sessions=3, n_taxels=taxels)[0]], folder)
    return load(folder)


def answers(recordings):
    """The findings, and all the names in them."""
    findings = diagnose(recordings[:2], recordings[2:]).findings
    return findings, {(e["cause"], e["where"]) for f in findings["findings"] for e in (f, *f["alternatives"])}


def untestable_of_load_cell(findings):
    return [u["cause"] for u in findings["untestable"] if u.get("where") == "load_cell"]


HIDDEN = [
    ("friction", "coulomb", 1, 1), ("drift", "linear", 1, 1), ("gain_error", "step", 1, 1), ("force_offset", "each_session", 1, 1),
    ("saturation", "hard", 1, 1), ("hysteresis", "sliders", 2, 1), ("drift", "linear", 1, 3), ("lag", "one_pole", 2, 1),
    ("friction", "coulomb", 2, 1), ("friction", "stribeck", 2, 1), ("friction", "coulomb", 1, 3), ("drift", "linear", 2, 1),
    ("drift", "logarithmic", 2, 1), ("drift", "creep_under_load", 1, 1), ("drift", "creep_under_load", 2, 1), ("gain_error", "step", 2, 1),
    ("gain_error", "loose", 1, 1), ("gain_error", "step", 1, 3), ("force_offset", "constant", 1, 1), ("force_offset", "constant", 2, 1),
    ("force_offset", "each_session", 2, 1), ("force_offset", "constant", 2, 3), ("saturation", "hard", 24, 1), ("saturation", "soft", 1, 1),
    ("hysteresis", "bouc_wen", 2, 1), ("hysteresis", "preisach", 2, 1), ("hysteresis", "preisach", 1, 3), ("lag", "one_sided", 1, 1),
]  # fmt: skip


@pytest.mark.parametrize(("cause", "form", "seed", "taxels"), rows(HIDDEN, 0))
def test_a_fault_of_the_load_cell_is_among_the_names(tmp_path, cause, form, seed, taxels):
    findings, names = answers(driven(tmp_path, cause, "load_cell", form, seed=seed, taxels=taxels))
    assert (cause, "load_cell") in names, names
    assert OF_LOAD_CELL - {"outliers", "quantization"} <= {c for c, w in names if w == "load_cell"} | {*untestable_of_load_cell(findings)}
    assert any("the load cell itself may be what is wrong" in why for why in sure(view(findings))[1])
    rivals = [f for f in findings["findings"] if any(a["where"] == "load_cell" for a in f["alternatives"])]
    assert all("the depth (encoder), or a known load on the load cell" in f["separating_experiment"] for f in rivals)


@pytest.mark.parametrize("taxels", [1, 3])
@pytest.mark.parametrize("seed", rows([1, 2, 3, 4], 2))
def test_nothing_is_named_where_nothing_is_wrong_and_every_cause_of_the_load_cell_is_said_to_be_untested(tmp_path, seed, taxels):
    findings, names = answers(driven(tmp_path, seed=seed, taxels=taxels))
    assert (findings["verdict"], names) == ("nothing_wrong", set())
    untold = untestable_of_load_cell(findings)
    assert {*untold} == OF_LOAD_CELL - {"outliers", "quantization"} and len(untold) == len({*untold})
    assert not {u["cause"] for u in findings["untestable"] if "where" not in u} & {*untold}


@pytest.mark.parametrize(("cause", "form", "seed"), [("gain_error", "step", 1), ("force_offset", "constant", 3)])
@pytest.mark.slow
def test_what_one_taxel_of_several_has_is_no_fault_of_the_load_cell(tmp_path, cause, form, seed):
    _, names = answers(driven(tmp_path, cause, "taxel_0", form, seed=seed, taxels=3))
    assert (cause, "taxel_0") in names and not any(where == "load_cell" for _, where in names), names


@pytest.mark.slow
def test_a_taxel_that_comes_late_is_no_load_cell_that_does(tmp_path):
    late = [replace(r, taxels=np.array([np.interp(r.t - 0.03, r.t, y) for y in r.taxels])) for r in driven(tmp_path)]
    _, names = answers(late)
    assert names and ("lag", "load_cell") not in names, names
    early = [replace(r, force=np.interp(r.t - 0.03, r.t, r.force)) for r in driven(tmp_path)]
    assert ("lag", "load_cell") in answers(early)[1]


def test_with_a_depth_nothing_of_this_is_said(tmp_path):
    write_case(make_sessions(None, seed=1, n_sessions=3)[0], tmp_path)
    findings, _ = answers(load(tmp_path))
    assert all("drives the simulation" not in u["because"] for u in findings["untestable"])
