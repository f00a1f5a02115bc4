"""Slopes of taxels in volts come back with errors that hold, and what they are written to reads them."""

import numpy as np
import pytest
from making import noise, recording

from skin_ident.cli.fit import main
from skin_ident.estimators.calibration import as_rig_yaml, calibrate, fit_line, stiffness
from skin_ident.estimators.errors import FitError
from skin_ident.recordings.declared import declared_from
from skin_ident.recordings.recording import Recording


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


@pytest.mark.parametrize(
    ("call", "says"),
    [(lambda: calibrate([recording(n=100)]), "volts"), (lambda: fit_line([np.zeros(50)], [np.zeros(50)]), "never changes"),
     (lambda: fit_line([np.random.default_rng(0).normal(size=500)], [np.random.default_rng(1).normal(size=500)]), "hardly")],
)  # fmt: skip
def test_useless_calibrations_are_refused(call, says):
    with pytest.raises(FitError, match=says):
        call()
