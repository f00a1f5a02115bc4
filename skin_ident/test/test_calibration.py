"""Slopes of taxels in volts come back with errors that hold, and what they are written to reads them."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from making import noise, recording, write_bag

from skin_ident.cli.fit import main
from skin_ident.estimators.calibration import as_rig_yaml, calibrate, direct_load, fit_line, stiffness
from skin_ident.estimators.errors import FitError
from skin_ident.recordings.declared import declared_from
from skin_ident.recordings.load import load
from skin_ident.recordings.recording import Recording
from skin_ident.recordings.slopes import slopes_in_use


def stairs(seed=0, slope=9.4, zero=0.31, rho=0.95):
    """Stair steps up and down, as the thesis calibrates its taxels."""
    force = np.repeat(np.concatenate([np.arange(0, 20), np.arange(20, -1, -1)]) * 2.0, 100)
    volts = force / slope + zero + noise(np.random.default_rng(seed), force.size, 0.01, rho)
    return Recording("stairs", np.arange(force.size) * 0.01, None, force, volts[None], ("ai1",), taxel_units=("V",))


def test_slope_and_zero_come_back_and_can_be_declared():
    line = calibrate([stairs(0), stairs(1)])["ai1"]
    assert line.slope == pytest.approx(9.4, abs=4 * line.slope_std) and line.zero == pytest.approx(0.31, abs=0.02) and line.r2 > 0.999
    assert declared_from(as_rig_yaml({"ai1": line})).calibration["ai1"].slope_n_per_v == pytest.approx(line.slope, rel=1e-5)


@pytest.mark.parametrize("rho", [0.0, 0.95])
def test_standard_error_matches_the_scatter(rho):
    lines = [calibrate([stairs(s, rho=rho)])["ai1"] for s in range(40)]
    assert 0.6 < np.mean([line.slope_std for line in lines]) / np.std([line.slope for line in lines]) < 1.6


def test_stiffness_of_a_slow_press():
    slopes = stiffness([recording(hz=0.01, n=10000, sigma=0.01)])
    assert slopes["force"].slope == pytest.approx(12385, rel=0.01) and slopes["taxel_0"].slope == pytest.approx(9619, rel=0.01)


def test_what_is_calibrated_is_not_told_to_lack_a_calibration(tmp_path, capsys):
    r = stairs()
    rows = np.column_stack([r.t, r.force, r.taxels[0]])
    np.savetxt(tmp_path / "s.csv", rows, delimiter=",", header="time_s,force_n,taxel_0_v", comments="")
    assert main([str(tmp_path / "s.csv"), "--what", "calibration"]) == 0
    said = capsys.readouterr().out
    assert "slope_n_per_v: 9." in said and "no calibration" not in said


def pressed_through_skin(tmp_path, rig=""):
    """A bag of a press of skin, with taxels in newtons and volts, made with 9.4 N/V; 0.78 of the force reaches the taxel."""

    def with_volts(_, __, message):
        return replace(message, voltage=message.force / 9.4) if hasattr(message, "voltage") else message

    write_bag(tmp_path / "press", recording(n=3000, sigma=0.01), change=with_volts)
    (tmp_path / "press" / "calibration.yaml").write_text("load_cell_n_per_v: 13.9\ntaxels_n_per_v: {taxel_0: 9.4, taxel_1: null}\n")
    (tmp_path / "press" / "rig.yaml").write_text(rig)
    return str(tmp_path / "press")


def test_a_slope_through_skin_is_warned_of_and_compared_with_the_one_in_use(tmp_path, capsys):
    assert main([pressed_through_skin(tmp_path), "--what", "calibration"]) == 0
    said = capsys.readouterr().out
    assert "taxel_0    is 1.3 times what it was recorded with: 9.4 N/V" in said
    assert "mm deep" in said and "known load on the bare taxel" in said and "for rig.yaml, if the load lay on the taxel itself" in said


def test_bare_loads_are_told_from_presses_of_skin():
    """Also where the load cell has a zero of its own, and the plunger comes from far away."""
    r = stairs()
    bare = replace(r, depth=np.where(r.force > 0.0, 1e-6 * r.force, -5e-3), force=r.force + 1.5)
    assert "through skin the slope holds" in direct_load([r])[0] and "mm deep" in direct_load([recording(n=1000)])[0]
    assert direct_load([bare]) == []


def test_slopes_in_use_are_read_from_files_that_say_them(tmp_path):
    bag = Path(pressed_through_skin(tmp_path))
    assert slopes_in_use(bag) == {"taxel_0": 9.4}
    for broken in ("[", "taxels_n_per_v: 3", "- 1", ""):
        (bag / "calibration.yaml").write_text(broken)
        assert slopes_in_use(bag) == {}
    (bag / "calibration.yaml").unlink()
    assert slopes_in_use(bag) == {} == slopes_in_use(tmp_path / "no.csv")


def test_a_calibration_of_what_is_in_newtons_already_is_said_to_be_unused(tmp_path, capsys):
    path = pressed_through_skin(tmp_path, "calibration: {taxel_0: {slope_n_per_v: 18.8, zero_v: 0}}")
    (said,) = [w for w in load(path)[0].warnings if "rig.yaml" in w]
    assert "in newtons here already: its entry is not used; with --topics taxels=/taxels:voltage" in said
    (volts,) = load(path, {"taxels": "/taxels:voltage"})
    assert np.allclose(volts.taxels, 2.0 * load(path)[0].taxels) and not any("rig.yaml" in w for w in volts.warnings)
    assert main([path, "--what", "calibration"]) == 2 and "rig.yaml calibrates taxel_0 already" in capsys.readouterr().err


def test_taxels_of_a_bag_keep_their_places_where_only_some_are_calibrated(tmp_path):
    def in_volts(_, __, message):
        return replace(message, force=np.array([]), voltage=message.force / 10.0) if hasattr(message, "voltage") else message

    made = recording(n=300, shares=(1.0, 0.5, 0.2))
    write_bag(tmp_path / "bag", made, change=in_volts)
    lines = "{taxel_0: {slope_n_per_v: 10, zero_v: 0}, taxel_2: {slope_n_per_v: 10, zero_v: 0}}"
    (tmp_path / "bag" / "rig.yaml").write_text(f"calibration: {lines}\ntaxel_noise_n: [0.1, 0.2, 0.3]\n")
    (r,) = load(tmp_path / "bag")
    assert r.taxel_names == ("taxel_0", "taxel_1", "taxel_2") and r.taxel_units == ("N", "V", "N")
    assert np.allclose(r.taxels, made.taxels * [[1.0], [0.1], [1.0]])
    assert [w.partition(" is in volts")[0] for w in r.warnings if "no calibration" in w] == ["taxel_1"]


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_a_zero_is_taken_from_the_first_second_of_numbers(tmp_path):
    """A channel may begin to tell later than the others."""
    t = np.arange(500) * 0.01
    volts = np.where(t < 3.0, 0.31, 0.31 + (t - 3.0) / 9.4)
    cells = [f"{a:.2f},{0.1 * a:.3f}," + ("" if a < 1.5 else f"{v:.6f}") for a, v in zip(t, volts, strict=True)]
    (tmp_path / "a.csv").write_text("\n".join(["t_s,force_n,taxel_0_v", *cells]) + "\n")
    (tmp_path / "rig.yaml").write_text("calibration: {taxel_0: {slope_n_per_v: 9.4}}\n")
    (r,) = load(tmp_path / "a.csv")
    assert r.taxels[0, -1] == pytest.approx(1.99, abs=0.01)
    assert "taxel_0: zero taken as 0.31 V, the median of the first second from 1.5 s on, where its numbers begin" in " ".join(r.warnings)


PRESS = recording(2, shares=(1.0, 0.3), n=1000)
AIR = replace(PRESS, name="air", depth=PRESS.depth - 2e-3, force=0.0 * PRESS.force, taxels=0.0 * PRESS.taxels)


def silenced(r, row, value):
    rows = r.taxels.copy()
    rows[row] = value
    return replace(r, taxels=rows)


@pytest.mark.parametrize(
    ("made", "left", "told"),
    [([replace(PRESS, force=np.full(1000, 0.7))], ["taxel_0", "taxel_1"], "force has no line: it never changes"),
     ([silenced(PRESS, 1, 0.0)], ["force", "taxel_0"], "taxel_1 has no line: it never changes"),
     ([silenced(PRESS, 1, np.random.default_rng(0).normal(size=1000))], ["force", "taxel_0"], "taxel_1 has no line: the two hardly"),
     ([PRESS, AIR], ["force", "taxel_0", "taxel_1"], "air is left out: the plunger does not touch the skin")],
)  # fmt: skip
def test_one_channel_without_a_stiffness_leaves_those_of_the_others(made, left, told):
    found = stiffness(made)
    assert list(found) == left and any(note.startswith(told) for note in found.notes)
    assert all(line.slope > 1000.0 and np.isfinite(line.zero) for line in found.values())


def test_a_dead_taxel_is_not_taken_for_the_load(tmp_path, capsys):
    r = stairs()
    both = replace(r, taxels=np.vstack([r.taxels, np.full(len(r), 0.3)]), taxel_names=("ai1", "ai2"), taxel_units=("V", "V"))
    found = calibrate([both])
    assert list(found) == ["ai1"] and found.notes == ("ai2 has no line: it never changes: it is dead, or nothing acted on it",)
    rows = np.column_stack([both.t, both.force, *both.taxels])
    np.savetxt(tmp_path / "s.csv", rows, delimiter=",", header="time_s,force_n,ai1_v,ai2_v", comments="")
    assert main([str(tmp_path / "s.csv"), "--what", "calibration", "--out", str(tmp_path / "out")]) == 0
    written = json.loads((tmp_path / "out" / "fit.json").read_text())
    assert found.notes[0] in capsys.readouterr().out and found.notes[0] in written["warnings"]


@pytest.mark.parametrize(
    ("call", "says"),
    [(lambda: stiffness([AIR]), "never touches the skin"),
     (lambda: stiffness([replace(PRESS, depth=np.full(1000, 1e-3))]), "the depth never changes"),
     (lambda: stiffness([replace(PRESS, force=0.0 * PRESS.force, taxels=0.0 * PRESS.taxels)]), "force has no line.*taxel_0.*taxel_1"),
     (lambda: calibrate([replace(stairs(), force=np.zeros(len(stairs())))]), "the force never changes")],
)  # fmt: skip
def test_what_no_channel_has_is_said(call, says):
    with pytest.raises(FitError, match=says):
        call()


@pytest.mark.parametrize(
    ("call", "says"),
    [(lambda: calibrate([recording(n=100)]), "volts"), (lambda: fit_line([np.zeros(50)], [np.zeros(50)]), "never changes"),
     (lambda: fit_line([np.random.default_rng(0).normal(size=500)], [np.random.default_rng(1).normal(size=500)]), "hardly")],
)  # fmt: skip
def test_useless_calibrations_are_refused(call, says):
    with pytest.raises(FitError, match=says):
        call()
