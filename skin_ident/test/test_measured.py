"""What the diagnosis says of data that others measured, held against an independent look at them. Left out where they are absent."""

import numpy as np
import pytest
from measured_layout import ABSENT, HERE, PRESSES, SCALE, WATER, fluid_rows, fluid_skin, insole, insole_rows, one_press, starts
from scipy.ndimage import median_filter
from scipy.optimize import minimize_scalar
from scipy.signal import lfilter

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.record import inspect
from skin_ident.recordings.chosen import only_taxels
from skin_ident.recordings.load import load

pytestmark = pytest.mark.skipif(HERE is None, reason=ABSENT)


def said(findings):
    every = [x for f in findings["findings"] for x in (f, *f["alternatives"])]
    return {(x["cause"], x["where"]) for x in every}


def gains_by_press(name):
    """Slope of both sensors against the force at the end of each press."""
    rows = fluid_rows(name)
    zero = np.median(rows[:100], axis=0)
    held = [slice(i + 120, i + 190) for i in starts(rows)]
    force = np.array([-SCALE * np.median(rows[h, 1] - zero[1]) for h in held])
    return np.array([[np.median(rows[h, c] - zero[c]) for h in held] for c in (2, 3)]) / force


def lag_of(force, y):
    """Time constant of the one first-order lag between force and sensor that leaves least."""

    def left(p):
        e = np.exp(-0.01 / np.exp(p))
        u = lfilter([1.0 - e], [1.0, -e], force)
        return float(np.sum((y - u * (u @ y) / (u @ u)) ** 2))

    return float(np.exp(minimize_scalar(left, bounds=(np.log(0.01), np.log(5.0)), method="bounded").x))


def test_the_walk_of_the_press_is_a_gain_that_changes(tmp_path):
    fluid_skin(tmp_path)
    recordings = [load(tmp_path / f"{name}.csv")[0] for name in WATER[1:]]
    findings = diagnose(recordings[:2], recordings[2:]).findings
    left, right = gains_by_press("50mm")
    assert left.size == PRESSES and np.all(np.diff(left[:-1]) < 0.0) and np.all(np.diff(right[1:]) > 0.0)
    changing = {w for c, w in said(findings) if c in ("gain_error", "drift")}
    assert {"taxel_0", "taxel_1"} <= changing or "taxel" in changing
    for worth in findings["gain_by_channel"].values():
        assert worth["held_out_rmse_after"] < 0.5 * worth["held_out_rmse_before"] and worth["ci95"][0] > 0.0
    assert findings["verdict"] == "partly_explained"  # nobody logged where the press was


def test_no_fault_of_the_record_is_claimed_where_none_is_seen(tmp_path):
    for name in WATER:
        assert not inspect(load(fluid_skin(tmp_path) / f"{name}.csv")).symptoms


def test_the_far_sensor_lags_more(tmp_path):
    one_press(tmp_path, 7)
    rows = np.genfromtxt(tmp_path / "50mm.csv", delimiter=",", skip_header=1)
    rows = rows - np.median(rows[:100], axis=0)
    far, near = (lag_of(-rows[:, 1], rows[:, c]) for c in (2, 3))
    assert far > near + 0.04
    recordings = [load(tmp_path / f"{name}.csv")[0] for name in WATER[1:]]
    findings = diagnose(recordings[:2], recordings[2:]).findings
    doubted = {(e["cause"], e.get("where")) for e in findings["untestable"] if e.get("in_doubt")}
    assert ("lag", "taxel_0") in said(findings) | doubted  # three presses of six seconds


def test_spikes_of_the_chamber_pressure_and_nothing_on_the_taxels(tmp_path):
    insole(tmp_path)
    for name in ("experiment_Inf_15September_dynamic_1", "validation_dataset_3"):
        (r,) = only_taxels(load(tmp_path / f"{name}.csv"), ["34", "74", "36"])
        symptoms = inspect([r]).symptoms
        assert [(s.cause, s.where) for s in symptoms] == [("outliers", "load_cell")]
        mask = next(iter(symptoms[0].bad.values()))
        t, pressure, _ = insole_rows(name)
        spikes = t[np.abs(pressure - median_filter(pressure, 9)) > 0.015]  # a plain threshold sees them as well
        assert np.mean([np.min(np.abs(spikes - at)) < 0.1 for at in r.t[mask]]) > 0.8


def test_what_the_pressure_of_the_second_insole_file_lacks_is_found(tmp_path):
    insole(tmp_path)
    files = ("experiment_Inf_15September_dynamic_1", "validation_dataset_3")
    first, second = (only_taxels(load(tmp_path / f"{name}.csv"), ["34", "74", "36"])[0] for name in files)
    at = np.arange(6.0, 17.0)
    means = [np.array([r.taxels[:, np.abs(r.force - f) < 0.5].mean(axis=1) for f in at]) for r in (first, second)]
    more = (means[1] - means[0]).mean(axis=1)
    slope, middle = np.polyfit(at - at.mean(), more, 1)
    assert middle > 1.0 and abs(slope) * np.ptp(at) < 0.5 * middle  # for the same pressure, and as much at any: it is no gain
    findings = diagnose([first], [second]).findings
    assert ("force_offset", "load_cell") in said(findings)
    for worth in findings["gain_by_channel"].values():
        assert worth["held_out_rmse_after"] < 0.5 * worth["held_out_rmse_before"]
