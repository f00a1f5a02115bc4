"""Every battery on the simulated rig, executed by the installed driver and server; the thesis's own show what the thesis says.

Long: ./skin test -m campaign skin_motion_profiles/test/test_thesis_batteries.py
"""

import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

pytest.importorskip("rclpy")
pytest.importorskip("skin_testbed_msgs")

sys.path.insert(0, str(Path(__file__).parents[1] / "bench"))
from session import Session, seconds
from skin_testbed_msgs.action import ExecuteProfile
from skin_testbed_msgs.msg import TaxelArray

from skin_models.ros.qos import LISTENING
from skin_motion_profiles.battery_file import battery_names

pytestmark = pytest.mark.campaign
SERVER = {"use_sim_time": True}
BARE_TAXEL = 226.4e3  # N/m, mean of Table 3-2


class Run:
    """What came of one battery: times (s) with depth (m), force (N), taxel forces (N) and volts, all (N, …) and of the same samples."""

    def __init__(self, battery: dict, model: str = "silicone_4mm", **driver) -> None:
        with Session(driver={"time_scale": 5.0, "seed": 2, "model": model, **driver}, server=SERVER) as session:
            heard: list[TaxelArray] = []
            session.node.create_subscription(TaxelArray, "taxels", heard.append, LISTENING)
            session.until(lambda: heard, "taxels")
            heard.clear()
            self.result, encoder, force = session.execute(yaml.safe_dump(battery))
        assert self.result.error_code == ExecuteProfile.Result.SUCCESS, self.result.error_string
        self.t, self.depth = encoder.T
        self.force = np.interp(self.t, *force.T)
        times = [seconds(m.header.stamp) for m in heard]
        self.taxels, self.volts = (np.array([np.interp(self.t, times, row) for row in np.array(columns).T]).T for columns in (
            [m.force for m in heard], [m.voltage for m in heard])
        )  # fmt: skip
        self.place = np.interp(self.t, *np.array(session.place).T)

    def slope(self, y: np.ndarray, x: np.ndarray, where: np.ndarray) -> float:
        return float(np.polyfit(x[where], y[where], 1)[0])


def specimen(folder: Path, stiffness: float) -> str:
    """A model file: k in front of the taxel, hardly any damping."""
    units = {"m": "kg", "b1": "N*s/m", "k1": "N/m", "b2": "N*s/m", "k2": "N/m"}
    values = {"m": 0.0, "b1": 10.0, "k1": stiffness, "b2": 0.0, "k2": 1.0}
    dispersion = {name: {"value": values[name], "unit": unit} for name, unit in units.items()}
    path = folder / "specimen.yaml"
    path.write_text(yaml.safe_dump({"schema": 1, "name": "specimen", "dispersion": dispersion}))
    return str(path)


THESIS = {"taxel_calibration", "stiffness", "hysteresis_and_rate", "relaxation", "array_walk", "lateral_spread_scan"}


@pytest.mark.parametrize("name", sorted(set(battery_names()) - THESIS))
def test_every_battery_is_executed(name):
    run = Run({"battery": name})
    deepest = {"prepare": 0.0, "pseudo_random_validation_2mm": 3e-4, "sinusoidal_identification_2mm": 3e-4}
    deepest |= {"pseudo_random_validation_6mm": 1.5e-3, "sinusoidal_identification_6mm": 1.5e-3}
    if name != "prepare":
        assert run.depth.max() == pytest.approx(deepest.get(name, 1e-3), rel=0.05)
        assert run.force.max() > 0.9 * 12385.0 * run.depth.max()
    assert run.depth[-1] < 0.0  # in the air again


def test_taxel_calibration_gives_the_slope_of_table_3_1(tmp_path):
    run = Run({"battery": "taxel_calibration"}, specimen(tmp_path, BARE_TAXEL))
    assert run.force.max() == pytest.approx(0.12e-3 * BARE_TAXEL, rel=0.05)
    assert run.slope(run.force, run.volts[:, 0], run.force > 1.0) == pytest.approx(9.40825, rel=0.03)  # N/V, taxel 1


def test_stiffness_gives_the_slope_of_table_3_2(tmp_path):
    run = Run({"battery": "stiffness"}, specimen(tmp_path, BARE_TAXEL))
    assert run.slope(run.force, run.depth, run.force > 2.0) == pytest.approx(BARE_TAXEL, rel=0.05)


def test_hysteresis_grows_with_the_rate():
    run = Run({"battery": "hysteresis_and_rate"})
    speed = np.gradient(run.depth, run.t)
    middle = np.abs(run.depth - 4e-4) < 5e-5
    rise = [np.median(run.force[middle & (np.abs(speed - v) < 0.2 * v)]) for v in (1e-4, 1e-3, 5e-3)]
    assert rise[0] < rise[1] < rise[2]
    assert rise[2] - rise[0] == pytest.approx(1568.7 * 4.9e-3, rel=0.15)  # b v


def test_relaxation_loses_force_for_ten_seconds(tmp_path):
    from skin_models.effects.stress_relaxation import StressRelaxation
    from skin_models.materials import material
    from skin_models.model_file import save_model

    path = tmp_path / "relaxing.yaml"
    save_model(material("silicone_4mm").model.extended(StressRelaxation.typical("skin")), path)
    run = Run({"battery": "relaxation"}, str(path))
    deep = np.flatnonzero(run.depth > 0.99e-3)
    held = run.t - run.t[deep[0]]
    early, late = (np.mean(run.force[(held > a) & (held < a + 0.3)]) for a in (0.3, 10.0))
    assert late < 0.98 * early and abs(run.depth[deep] - 1e-3).max() < 1e-5


def test_array_walk_finds_every_taxel_where_it_is():
    run = Run({"battery": "array_walk"}, taxels=3)
    pressed = run.depth > 1.49e-3
    for i, x in enumerate((0.0, 0.014, 0.028)):
        places = np.round(run.place[pressed] / 0.007) * 0.007
        means = {p: run.taxels[pressed, i][places == p].mean() for p in np.unique(places)}
        assert max(means, key=means.get) == pytest.approx(x, abs=1e-9)


def test_lateral_spread_scan_shows_the_gaussian_of_table_4_8():
    from skin_models.materials import material
    from skin_models.simulated_skin import spread_width

    run = Run({"battery": "lateral_spread_scan"})
    deep = run.depth > 0.95e-3
    offsets = np.round(run.place[deep] * 1e3)
    felt = np.array([run.taxels[deep, 0][offsets == mm].mean() for mm in range(13)])
    near = felt > 0.05 * felt[0]
    slope = np.polyfit((np.arange(13)[near] * 1e-3) ** 2, np.log(felt[near]), 1)[0]
    assert (-slope) ** -0.5 == pytest.approx(spread_width(material("silicone_4mm").model.notes), rel=0.05)
    assert (np.diff(felt[near]) < 0.0).all()
