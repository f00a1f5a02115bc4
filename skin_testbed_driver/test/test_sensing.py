import math

import numpy as np
import pytest

from skin_testbed_driver.calibration import LOAD_CELL_SLOPE, Calibration
from skin_testbed_driver.rig import Reading
from skin_testbed_driver.sensing import OK, SATURATED, STALE, STUCK, UNCALIBRATED, Differentiator, Sensing

PERIOD = 0.01


def sensing(slopes=(10.0, 10.0)) -> Sensing:
    return Sensing(Calibration(np.array(slopes)), zero=0.0, period=PERIOD)


def reading(position=0.0, volts=0.0, taxels=(0.0, 0.0)) -> Reading:
    return Reading(position, volts, taxel_voltage=np.array(taxels))


def test_equations_25_and_26():
    s = sensing((10.0, 14.0)).sample(reading(0.0, 8.0, (1.0, 1.0)))
    assert s.force == pytest.approx(25 * 4.44822)
    assert s.taxel_force.tolist() == [10.0, 14.0]
    assert pytest.approx(13.9006875) == LOAD_CELL_SLOPE


def test_what_cannot_be_trusted_is_nan_and_says_why():
    s = sensing((10.0, math.nan)).sample(reading(taxels=(5.0, 1.0)))
    assert s.taxel_status.tolist() == [SATURATED, UNCALIBRATED]
    assert np.isnan(s.taxel_force).all()
    s = sensing().sample(reading(taxels=(math.nan, 1.0)))
    assert s.taxel_status.tolist() == [STALE, OK]
    assert s.taxel_force[1] == 10.0


def test_a_taxel_that_repeats_itself_under_a_changing_load_is_stuck():
    sensor = sensing()
    for i in range(100):
        s = sensor.sample(reading(1e-5 * i, 0.01 * i, (0.37, 0.01 * i)))
    assert s.taxel_status.tolist() == [STUCK, OK]
    assert math.isnan(s.taxel_force[0])


def test_a_load_cell_that_repeats_itself_while_the_plunger_presses_is_stuck():
    sensor = sensing()
    forces = [sensor.sample(reading(2e-6 * i, 0.37)).force for i in range(100)]
    assert math.isfinite(forces[10]) and math.isnan(forces[-1])


def test_a_quiet_load_cell_that_a_slow_skin_has_left_is_not_stuck():
    """On the way out there is nothing to feel, and without noise nothing changes either."""
    sensor = sensing()
    for i in range(200):
        s = sensor.sample(reading(1e-3 - 4e-6 * i, 0.0))
    assert s.force == 0.0


def test_stuck_is_half_a_second_to_the_sample_and_over_as_soon_as_a_value_changes():
    """Against the rule itself: repeats counted one by one, and the farthest load of each run."""
    rng, sensor = np.random.default_rng(2), sensing((10.0,) * 5)
    last, repeats, start, farthest, seen = np.full(5, np.nan), np.zeros(5), np.zeros(5), np.zeros(5), 0
    volts = np.zeros(5)
    for i in range(6000):
        volts = np.where(rng.random(5) < (0.02, 0.05, 0.5, 0.01, 1.0), rng.random(5), volts)
        s = sensor.sample(reading(-1e-3, 0.3 * math.sin(0.01 * i) + 0.01 * rng.random(), volts))
        new = volts != last
        last, repeats = volts, np.where(new, 0, repeats + 1)
        start, farthest = np.where(new, s.load, start), np.where(new, 0.0, farthest)
        farthest = np.maximum(farthest, np.abs(s.load - start))
        expected = (repeats >= 50) & (farthest > 1.0)
        assert (s.taxel_status == STUCK).tolist() == expected.tolist()
        seen += expected.any()
    assert 100 < seen < 5900


def test_a_quiet_sensor_in_the_air_or_at_rest_is_not_stuck():
    sensor = sensing()
    for i in range(200):
        s = sensor.sample(reading(-2e-3 + 5e-6 * i, 0.0))
    for _ in range(200):
        s = sensor.sample(reading(-1e-3, 0.0))
    assert s.force == 0.0 and s.taxel_status.tolist() == [OK, OK]


@pytest.mark.parametrize("size", [2, 3, 10])
def test_speed_of_a_ramp_is_exact_and_two_samples_are_the_finite_difference(size):
    differentiator = Differentiator(size, PERIOD)
    assert math.isnan(differentiator.add(0.0))
    speeds = [differentiator.add(3e-3 * PERIOD * i) for i in range(1, 20)]
    np.testing.assert_allclose(speeds, 3e-3, rtol=1e-9)
