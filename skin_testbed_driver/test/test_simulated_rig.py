import math
from dataclasses import replace

import numpy as np
import pytest

from skin_models.catalogue import effect_class
from skin_models.dispersion import Dispersion
from skin_models.effects.off_centre import OffCentre
from skin_models.model import Model
from skin_models.signals import motion
from skin_testbed_driver.calibration import LOAD_CELL_SLOPE, thesis_calibration
from skin_testbed_driver.rigs.simulated import CONVERTER_STEP, ENCODER_STEP, Imperfections, SimulatedRig

SILICONE = Model(Dispersion(m=0.000432, b1=939.5, k1=9619.0, b2=629.2, k2=2766.0))
IDEAL = Imperfections(0.0, 0.0, 0.0, 0.0, quantised=False)
SURFACE = 0.075


def press(rig: SimulatedRig, n: int = 600, rate: float = 100.0):
    """Follow 0.5 mm (1 - cos) from the surface, 0.5 Hz."""
    rig.open(rate)
    t = np.arange(n) / rate
    w = 2.0 * math.pi * 0.5
    x, v = 5e-4 * (1.0 - np.cos(w * t)), 5e-4 * w * np.sin(w * t)
    readings = []
    for depth, speed in zip(x, v, strict=True):
        rig.command(SURFACE + depth, speed)
        readings.append(rig.read())
    return t, x, v, readings


def rig_of(model: Model, **options) -> SimulatedRig:
    return SimulatedRig(model, thesis_calibration(len(model.shares)), surface=SURFACE, start=SURFACE, **options)


def test_an_ideal_rig_is_the_model_of_its_motion():
    model = SILICONE.extended(effect_class("stress_relaxation", "skin").typical("skin"))
    t, x, v, readings = press(rig_of(model, imperfections=IDEAL))
    expected = model.simulate(motion(t, x, v))
    force = np.array([r.load_cell_voltage for r in readings]) * LOAD_CELL_SLOPE
    np.testing.assert_allclose(force[2:-2], expected.force[2:-2], atol=1e-4)  # the mass: its acceleration is a difference
    np.testing.assert_allclose([r.position - SURFACE for r in readings], x, atol=1e-15)


def test_volts_and_positions_lie_on_the_grids_of_the_hardware():
    _, _, _, readings = press(rig_of(SILICONE))
    volts = np.array([[r.load_cell_voltage, *r.taxel_voltage] for r in readings]) / CONVERTER_STEP
    np.testing.assert_allclose(volts, np.rint(volts), atol=1e-9)
    steps = np.array([r.position for r in readings]) / ENCODER_STEP
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-6)


def test_the_taxel_saturates_at_five_volts():
    stiff = replace(SILICONE, dispersion=replace(SILICONE.dispersion, k1=2e5))
    _, _, _, readings = press(rig_of(stiff, imperfections=IDEAL))
    assert max(r.taxel_voltage[0] for r in readings) == 5.0


def test_a_seed_fixes_every_reading_and_another_changes_them():
    runs = [press(rig_of(SILICONE, seed=seed), 100)[3] for seed in (1, 1, 2)]
    volts = [[r.load_cell_voltage for r in run] for run in runs]
    assert volts[0] == volts[1] != volts[2]


def test_a_reading_prepared_when_the_command_is_known_is_the_same_reading():
    prepared = rig_of(SILICONE, seed=3)
    prepared.command = lambda x, v, command=prepared.command: (command(x, v), prepared.prepare(), prepared.prepare())
    for a, b in zip(press(rig_of(SILICONE, seed=3), 200)[3], press(prepared, 200)[3], strict=True):
        assert a[:2] == b[:2] and (a.taxel_voltage == b.taxel_voltage).all() and (a.taxels_truth == b.taxels_truth).all()


def test_noise_has_the_size_it_was_given():
    rig = rig_of(SILICONE, imperfections=replace(IDEAL, load_cell_noise=0.01))
    rig.open(100.0)
    volts = [rig.read().load_cell_voltage for _ in range(4000)]
    assert np.std(volts) == pytest.approx(0.01, rel=0.05)


def test_the_stage_rests_one_to_five_micrometres_beside_and_the_encoder_shows_it():
    rig = rig_of(SILICONE)
    rig.open(100.0)
    rests = []
    for i in range(1, 40):
        rig.command(SURFACE - 1e-3 - 1e-5 * i, 0.0)
        for _ in range(200):
            reading = rig.read()
        rests.append(abs(reading.position - (SURFACE - 1e-3 - 1e-5 * i)))
    assert max(rests) <= 6e-6
    assert np.mean(np.array(rests) >= 0.9e-6) > 0.8


def test_truth_is_beside_what_is_measured():
    model = replace(SILICONE, shares=(1.0, 0.25))
    _, _, _, readings = press(rig_of(model, imperfections=IDEAL))
    truth = np.array([r.taxels_truth for r in readings])
    np.testing.assert_allclose(truth[:, 1], 0.25 * truth[:, 0])
    np.testing.assert_allclose([r.taxel_voltage[0] * 9.40825 for r in readings], truth[:, 0], atol=1e-12)


def test_the_x_y_stage_brings_other_taxels_under_the_plunger():
    model = replace(SILICONE, shares=(1.0, math.exp(-((0.014 / 0.00525) ** 2))))
    rig = rig_of(model, imperfections=IDEAL)
    rig.open(100.0)
    rig.place(0.014, 0.0)
    rig.command(SURFACE + 1e-3, 0.0)
    for _ in range(200):
        reading = rig.read()
    assert rig.placed() == pytest.approx((0.014, 0.0))
    assert reading.taxels_truth[1] == pytest.approx(9.619, rel=1e-6)
    assert reading.taxels_truth[0] == pytest.approx(9.619 * math.exp(-((0.014 / 0.00525) ** 2)), rel=1e-6)


def test_a_model_without_effects_takes_a_short_way_that_gives_the_same_readings(monkeypatch):
    model = replace(SILICONE, shares=(1.0, math.exp(-((0.014 / 0.00525) ** 2))))

    def readings() -> list:
        rig = rig_of(model, seed=3)
        found = press(rig, 300)[3]
        rig.place(0.01, 0.002)
        rig.command(SURFACE + 1e-3, 0.0)
        return found + [rig.read() for _ in range(200)]

    short = readings()
    monkeypatch.setattr("skin_testbed_driver.rigs.simulated.is_bare", lambda _: False)
    for a, b in zip(short, readings(), strict=True):
        assert a.position == b.position and a.load_cell_voltage == b.load_cell_voltage and a.force_truth == b.force_truth
        assert np.array_equal(a.taxel_voltage, b.taxel_voltage)
        np.testing.assert_allclose(a.taxels_truth, b.taxels_truth, rtol=1e-14)


def test_a_contact_off_centre_and_a_spread_of_another_shape_show_wherever_the_stage_is():
    shares = (1.0, math.exp(-((0.014 / 0.00525) ** 2)))
    notes = {**SILICONE.notes, "spread": {"ratio": {"value": 1.5, "unit": "1"}}}
    beside = OffCentre(where="rig", dx=2e-3, dy=0.0)
    rig = rig_of(replace(SILICONE, shares=shares, notes=notes, effects=(beside,)), imperfections=IDEAL)
    rig.open(100.0)
    rig.place(0.01, 0.0)
    rig.command(SURFACE + 1e-3, 0.0)
    for _ in range(200):
        reading = rig.read()
    width = 0.00525 * math.sqrt(1.5)
    assert reading.taxels_truth[0] == pytest.approx(9.619 * math.exp(-((0.012 / width) ** 2)), rel=1e-6)


@pytest.mark.parametrize("rate", [100.0, 1000.0])
@pytest.mark.parametrize("compliance", [4.4e-6, 5e-5])
def test_a_soft_mount_bends_under_its_force_and_no_more(rate, compliance):
    """In every sample the model, pressed by what is left of the depth, gives the force that bends the mount."""
    soft = rig_of(SILICONE, imperfections=replace(IDEAL, mount_compliance=compliance))
    t, x, v, readings = press(soft, n=round(4 * rate), rate=rate)
    force = np.array([r.force_truth for r in readings])
    tip, speed = x - compliance * force, v - compliance * np.diff(force, prepend=0.0) * rate
    expected = np.where(tip > 0.0, 12385.0 * tip + 1568.7 * speed, 0.0)
    loaded = (force > 0.2) & (t > 0.1)
    off = np.abs(force - expected)[loaded] > 0.01  # the mass is left out
    assert off.mean() < 0.005  # where the plunger meets skin that has not recovered the force jumps, and nothing balances
    assert force.max() < 0.98 * max(r.force_truth for r in press(rig_of(SILICONE, imperfections=IDEAL), n=round(4 * rate), rate=rate)[3])


def test_a_soft_mount_at_rest_is_two_springs_in_series():
    rig = rig_of(SILICONE, imperfections=replace(IDEAL, mount_compliance=4.4e-6))
    rig.open(100.0)
    for i in range(400):
        rig.command(SURFACE + 1e-3 * min(i / 100.0, 1.0), 0.0)
        reading = rig.read()
    assert reading.force_truth == pytest.approx(1e-3 / (1.0 / 12385.0 + 4.4e-6), abs=0.005)
