"""The thesis as measured data."""

import numpy as np
import pytest

from skin_ident.criticism.scan.thesis import thesis_findings, thesis_spread
from skin_models.layout import row
from skin_models.model_file import load_model, save_model
from skin_models.simulated_skin import Presses, SimulatedSkin


@pytest.fixture(scope="module")
def spread():
    return thesis_spread()


def test_what_the_gaussian_gets_wrong_in_table_4_10(spread):
    findings = spread[0].findings
    assert [f["cause"] for f in findings["findings"]] == ["nonlinear_stiffness", "spread_shape"] and findings["verdict"] == "explained"
    law, shape = findings["findings"]
    assert law["parameters"]["exponent"]["value"] == pytest.approx(1.20, abs=0.02)
    assert shape["parameters"]["shape_power"]["value"] == pytest.approx(2.8, abs=0.2)  # flat top
    assert shape["parameters"]["tail_weight"]["value"] == pytest.approx(0.5, abs=0.1)  # and a tail
    assert [a["cause"] for a in shape["alternatives"]] == ["off_centre"]
    assert findings["baseline"]["parameters"]["width"]["value"] == pytest.approx(5.29e-3, abs=2e-5)
    assert sum("no level of the converter" in w for w in findings["warnings"]) == 2


def test_what_the_extension_gains_held_out_by_depth(spread):
    gain = spread[1]
    assert gain.table_4_8 == pytest.approx(0.167, abs=0.001) and gain.gaussian == pytest.approx(0.163, abs=0.002)
    assert gain.extended == pytest.approx(0.131, abs=0.002)
    assert gain.linear == pytest.approx(0.263, abs=0.003) and gain.nonlinear == pytest.approx(0.107, abs=0.002)


def test_the_simulated_skin_does_what_the_extended_model_says(spread, tmp_path):
    outcome = spread[0]
    save_model(outcome.model, tmp_path / "model.yaml", outcome.std)
    skin = SimulatedSkin(load_model(tmp_path / "model.yaml"), row(1, 0.01), 0.01)
    scan = outcome.scans[0]
    worst = 0.0
    for i in (0, 4, 9):
        for j in (0, 2, 5, 9):
            state, where = skin.initial(), np.array([[scan.distance[j], 0.0, 0.0]])
            for depth in np.linspace(0.0, scan.depth[i], 4):
                state, reading = skin.step(state, Presses(("plunger",), where, np.array([np.nan]), np.array([depth]), np.zeros(1)))
            worst = max(worst, abs(reading.taxels[0] - scan.extended[i, j]))
    assert worst < 0.06  # N, half the noise; the level is written as a polynomial, the shape as a table


PINNED = {  # table: entries that its own data cannot give, however they were rounded
    "4-4": {"2mm b1", "2mm b1_std"},
    "4-8": {"0.90 mm a"},
    "4-9": {f"{d} mm {p}" for d in ("2.5", "2.7", "2.8", "2.9") for p in ("a", "c", "r2")},
    "4-10": {"0.10 mm, 4 mm", "0.10 mm, 12 mm", "0.10 mm, 1 and 3 mm"},
    "4-11": {f"{d} mm, all distances" for d in ("2.5", "2.7", "2.8", "2.9")},
    "text": {"experiments at 1 mm/s", "plunger diameter, mm", "centre_error_frubber, %"},
}


def test_data_errors_of_all_tables():
    found = {}
    for d in thesis_findings():
        found.setdefault(d.table, set()).add(d.entry)
    assert found == PINNED
