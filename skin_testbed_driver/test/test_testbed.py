import math

import numpy as np
import pytest

from skin_models.dispersion import Dispersion
from skin_models.model import Model
from skin_testbed_driver.calibration import thesis_calibration
from skin_testbed_driver.motion import Activity
from skin_testbed_driver.rig import Reading, RigError
from skin_testbed_driver.rigs.simulated import SimulatedRig
from skin_testbed_driver.safety import CommandError, Limits
from skin_testbed_driver.testbed import Testbed
from skin_testbed_driver.trajectory import Trajectory
from skin_testbed_driver.zeroing import ZeroSettings

SILICONE = Model(Dispersion(m=0.000432, b1=939.5, k1=9619.0, b2=629.2, k2=2766.0))
PERIOD = 0.01


class Bench:
    """A testbed and its clock."""

    def __init__(self, limits=Limits(), rig_type=SimulatedRig, **rig_options):  # noqa: B008
        calibration = thesis_calibration(1)
        self.rig = rig_type(SILICONE, calibration, **rig_options)
        self.testbed, self.n, self.samples = Testbed(self.rig, calibration, limits), 0, []

    def run(self, seconds):
        for _ in range(round(seconds / PERIOD)):
            self.samples.append(self.testbed.tick(self.n * PERIOD))
            self.n += 1
        return self.samples[-1]

    def go(self, depth, seconds, speed=0.0):
        target = self.n * PERIOD + seconds
        self.testbed.follow(lambda now: Trajectory((target,), (depth,), (speed,)))


class LosableRig(SimulatedRig):
    """Hardware whose cable can be pulled."""

    lost = ""

    def read(self):
        reading = super().read()
        if self.lost == "encoder":
            return Reading(math.nan, reading.load_cell_voltage, taxel_voltage=reading.taxel_voltage)
        if self.lost == "load cell":
            return Reading(reading.position, taxel_voltage=reading.taxel_voltage)
        if self.lost == "rig":
            raise RigError("the rig does not answer")
        return reading


def test_it_follows_and_measures_what_the_model_says():
    bench = Bench()
    bench.run(0.1)
    bench.go(1e-3, 2.0)
    sample = bench.run(6.0)
    assert sample.depth == pytest.approx(1e-3, abs=6e-6)
    assert sample.force == pytest.approx(12.385, abs=0.3)
    assert sample.taxel_force[0] == pytest.approx(9.619, abs=0.3)
    assert bench.testbed.status().activity is Activity.READY


def test_zero_finds_a_surface_that_lies_deeper_than_thought():
    bench, outcomes = Bench(surface=0.0755, start=0.073), []
    bench.run(0.1)
    bench.testbed.zero(ZeroSettings(), outcomes.append)
    bench.run(40.0)
    assert outcomes[0].value == pytest.approx(5e-4, abs=5e-6)
    assert bench.testbed.status().zeroed and bench.testbed.status().zero_count == 1
    assert bench.samples[-1].depth == pytest.approx(-0.002, abs=1e-5)
    assert bench.samples[-1].position == pytest.approx(0.0735, abs=5e-5)


@pytest.mark.parametrize("begin", [0.1, 0.113, 0.139])
def test_the_surface_is_where_the_force_begins_to_rise_and_the_thesis_finds_it_deeper(begin):
    found = []
    for extrapolate in (True, False):
        bench = Bench(surface=0.0755, start=0.073)
        bench.run(begin)
        bench.testbed.zero(ZeroSettings(extrapolate=extrapolate), found.append)
        bench.run(45.0)
    assert found[0].value == pytest.approx(5e-4, abs=5e-6)
    assert found[1].value == pytest.approx(5e-4 + 19e-6, abs=6e-6)


def test_zero_without_anything_below_says_so():
    bench, outcomes = Bench(surface=0.14, start=0.073), []
    bench.run(0.1)
    bench.testbed.zero(ZeroSettings(), outcomes.append)
    bench.run(30.0)
    assert outcomes[0].value is None and "no contact" in outcomes[0].message
    assert not bench.testbed.status().zeroed


class ForceRig(SimulatedRig):
    """A load cell that gives newtons."""

    sign = 1.0

    def read(self):
        reading = super().read()
        force = self.sign * thesis_calibration(1).force(reading.load_cell_voltage)
        return Reading(reading.position, force=force, taxel_voltage=reading.taxel_voltage)


def test_zero_finds_the_surface_with_a_load_cell_that_gives_newtons():
    bench, outcomes = Bench(rig_type=ForceRig, surface=0.0755, start=0.073), []
    bench.run(0.1)
    bench.testbed.zero(ZeroSettings(), outcomes.append)
    bench.run(40.0)
    assert outcomes[0].value == pytest.approx(5e-4, abs=6e-6)
    assert max(s.force for s in bench.samples) < 2.0


def test_zero_with_a_load_cell_of_the_wrong_sign_ends_before_it_presses():
    bench, outcomes = Bench(rig_type=ForceRig), []
    bench.rig.sign = -1.0
    bench.run(0.1)
    bench.testbed.zero(ZeroSettings(), outcomes.append)
    bench.run(30.0)
    assert outcomes[0].value is None and "sign" in outcomes[0].message
    assert min(s.force for s in bench.samples) > -2.0
    assert bench.samples[-1].depth == pytest.approx(-0.002, abs=1e-5)


def test_zero_from_within_the_skin_is_no_zero():
    bench, outcomes = Bench(surface=0.075, start=0.076), []  # it believes to be 2 mm above
    bench.run(0.1)
    bench.testbed.zero(ZeroSettings(), outcomes.append)
    bench.run(30.0)
    assert outcomes[0].value is None and "before the search began" in outcomes[0].message
    assert not bench.testbed.status().zeroed


def test_after_a_search_in_vain_the_plunger_is_back_and_can_be_commanded():
    bench, outcomes = Bench(surface=0.14, start=0.073), []
    bench.run(0.1)
    bench.testbed.zero(ZeroSettings(), outcomes.append)
    bench.run(30.0)
    assert bench.samples[-1].depth == pytest.approx(-0.002, abs=1e-5)
    assert bench.testbed.status().activity is Activity.READY


def test_who_is_beyond_a_limit_of_depth_may_go_back_but_no_farther():
    bench, outcomes = Bench(surface=0.14, start=0.073), []
    bench.run(0.1)
    bench.testbed.zero(ZeroSettings(), outcomes.append)
    bench.run(16.0)
    bench.testbed.cancel()
    bench.run(0.5)
    assert bench.samples[-1].depth > 5e-3
    bench.go(0.0, 2.0)
    assert bench.run(2.5).depth == pytest.approx(0.0, abs=1e-5)
    with pytest.raises(CommandError, match="deeper than the limit"):
        bench.go(4.1e-3, 2.0)


def test_an_axis_that_others_moved_during_a_pause_stays_where_they_put_it():
    bench = Bench()
    bench.run(0.1)
    bench.testbed.stop("a pause")
    bench.rig.command(0.0735, 0.0)  # of somebody else
    bench.rig.read()
    bench.testbed.resume()
    assert bench.run(1.0).position == pytest.approx(0.0735, abs=6e-6)
    assert bench.testbed.status().reason == "a pause"
    bench.testbed.reset()
    bench.go(-1e-3, 1.0)
    assert bench.run(1.5).depth == pytest.approx(-1e-3, abs=6e-6)


def test_an_axis_that_comes_back_elsewhere_after_a_stop_is_not_moved():
    bench = Bench(rig_type=LosableRig)
    bench.run(0.1)
    bench.testbed.stop("enough")
    bench.run(0.1)
    bench.rig.lost = "encoder"
    bench.run(0.1)
    bench.rig.command(0.0735, 0.0)
    bench.rig.read()
    bench.rig.lost = ""
    assert bench.run(1.0).position == pytest.approx(0.0735, abs=6e-6)
    assert bench.testbed.status().reason == "enough"


def test_zero_is_refused_while_moving_and_ended_by_a_stop():
    bench, outcomes = Bench(), []
    bench.run(0.1)
    bench.go(-1e-3, 1.0)
    with pytest.raises(CommandError, match="moving"):
        bench.testbed.zero(ZeroSettings(), outcomes.append)
    bench.run(2.0)
    bench.testbed.zero(ZeroSettings(), outcomes.append)
    bench.run(0.5)
    bench.testbed.stop("enough")
    assert outcomes[0].value is None and "enough" in outcomes[0].message


def test_a_cancelled_zero_leaves_the_driver_ready():
    bench, outcomes = Bench(), []
    bench.run(0.1)
    with pytest.raises(CommandError, match="neither"):
        bench.testbed.cancel()
    bench.testbed.zero(ZeroSettings(), outcomes.append)
    bench.run(0.5)
    bench.testbed.cancel()
    bench.run(0.5)
    assert outcomes[0].value is None and outcomes[0].message == "cancelled"
    assert bench.testbed.status().activity is Activity.READY
    assert abs(bench.samples[-1].depth - bench.samples[-30].depth) <= 3e-6
    bench.go(-1e-3, 1.0)
    assert bench.run(1.5).depth == pytest.approx(-1e-3, abs=6e-6)


def test_tare_subtracts_the_mean_and_reset_gives_it_back():
    bench, outcomes = Bench(), []
    bench.run(0.1)
    bench.testbed.tare(1.0, outcomes.append)
    bench.run(1.1)
    offsets = outcomes[0].value
    assert bench.testbed.status().tared and bench.testbed.status().tare_count == 1
    assert bench.samples[-1].force == bench.samples[-1].load - offsets.force
    bench.testbed.reset_tare()
    assert bench.run(PERIOD).force == bench.samples[-1].load
    bench.testbed.reset_tare()  # there is nothing to be taken back
    assert bench.testbed.status().tare_count == 2 and not bench.testbed.status().tared


def test_a_tare_needs_air_between_plunger_and_skin():
    bench, outcomes = Bench(), []
    bench.run(0.1)
    for depth, words in ((5e-4, "mm in the skin"), (-4e-5, "may touch the skin"), (-8e-5, "retract it to 0.1 mm above")):
        bench.go(depth, 1.0)
        bench.run(2.0)
        with pytest.raises(CommandError, match=words):
            bench.testbed.tare(0.5, outcomes.append)
    bench.go(-1.5e-4, 1.0)
    bench.run(2.0)
    bench.testbed.tare(0.5, outcomes.append)
    bench.run(0.6)
    assert abs(outcomes[0].value.force) < 0.05


def test_a_tare_is_possible_as_soon_as_the_surface_was_found():
    bench, outcomes = Bench(surface=0.078), []
    bench.run(0.1)
    bench.testbed.zero(ZeroSettings(), outcomes.append)
    while not outcomes:
        bench.run(PERIOD)
    bench.testbed.tare(0.5, outcomes.append)
    bench.run(0.6)
    assert abs(outcomes[1].value.force) < 0.05


def test_a_taxel_that_misses_a_sample_is_tared_by_the_others():
    bench, outcomes = Bench(), []
    read, silent = bench.rig.read, math.nan
    bench.rig.read = lambda: read()._replace(taxel_voltage=np.array([silent if bench.n % 10 == 0 else 0.02]))
    bench.run(0.1)
    bench.testbed.tare(0.5, outcomes.append)
    bench.run(0.6)
    assert outcomes[0].value.taxels == pytest.approx(thesis_calibration(1).taxel_force(np.array([0.02])))
    bench.rig.read = lambda: read()._replace(taxel_voltage=np.array([silent]))
    bench.testbed.tare(0.5, outcomes.append)
    bench.run(0.6)
    assert outcomes[1].value.taxels.tolist() == [0.0] and "1 of the taxels said nothing" in outcomes[1].message


def test_over_force_retracts_within_one_sample_of_its_detection():
    bench = Bench(Limits(max_force=5.0))
    bench.run(0.1)
    bench.go(3e-3, 3.0)
    bench.run(6.0)
    forces = np.array([s.force for s in bench.samples])
    first = int(np.argmax(forces > 5.0))
    depths = np.array([s.depth for s in bench.samples])
    assert "5.0 N" in bench.testbed.status().reason
    # Seen in `first`, commanded for `first + 1`: from there on the plunger only slows down and leaves.
    assert (np.diff(depths, 2)[first - 1 : first + 2] <= 1.5e-6).all()
    assert depths[first + 3] < depths[first]
    assert depths[-1] == pytest.approx(-0.002, abs=6e-6)


def test_a_saturated_load_cell_retracts_whatever_the_limit():
    bench = Bench(Limits(max_force=1000.0, max_depth=0.02), start=0.0749)
    bench.run(0.1)
    bench.go(0.015, 8.0)
    bench.run(10.0)
    assert "end of its range" in bench.testbed.status().reason
    assert max(s.depth for s in bench.samples) < 0.012
    assert bench.samples[-1].depth == pytest.approx(-0.002, abs=6e-6)


def test_over_force_above_the_retracted_depth_leaves_backwards_too():
    bench = Bench(Limits(max_force=5.0, retracted_depth=-5e-4), surface=0.0735, start=0.073)  # the skin is 1.5 mm higher than thought
    bench.run(0.1)
    bench.go(0.0, 2.0)
    bench.run(4.0)
    forces, depths = np.array([s.force for s in bench.samples]), np.array([s.depth for s in bench.samples])
    hit = depths[int(np.argmax(forces > 5.0))]
    assert hit < -5e-4 and depths.max() < hit + 5e-5
    assert depths[-1] == pytest.approx(hit - 2e-3, abs=5e-5) and forces[-50:].mean() < 0.1


@pytest.mark.parametrize(("what", "words"), [("encoder", "encoder"), ("load cell", "load cell"), ("rig", "does not answer")])
def test_a_lost_sensor_stops_the_axis_and_gives_no_number(what, words):
    bench = Bench(rig_type=LosableRig)
    bench.run(0.1)
    bench.go(1e-3, 4.0)
    bench.run(2.0)
    bench.rig.lost = what
    sample = bench.run(1.0)
    assert words in bench.testbed.status().reason
    assert bench.testbed.status().activity is Activity.STOPPED
    assert math.isnan(sample.depth) or what == "load cell"
    assert math.isnan(sample.force) or what == "encoder"
    bench.rig.lost = ""
    bench.run(1.0)
    speeds = [s.speed for s in bench.samples[-50:]]
    assert np.abs(speeds).max() <= 1.1e-4  # one encoder step per sample
    bench.testbed.reset()
    assert bench.testbed.status().activity is Activity.READY


def test_a_refused_command_stops_whatever_moves():
    bench = Bench()
    bench.run(0.1)
    bench.go(1e-3, 4.0)
    bench.run(1.0)
    with pytest.raises(CommandError):
        bench.go(1.0, 0.5)
    bench.run(1.0)
    assert "refused" in bench.testbed.status().reason
    assert abs(bench.samples[-1].depth - bench.samples[-30].depth) <= 3e-6


def test_the_x_y_stage_moves_only_while_the_plunger_is_in_the_air():
    bench = Bench()
    bench.run(0.1)
    bench.testbed.place(1e-3, 0.0)
    bench.run(1.0)
    assert bench.rig.placed() == pytest.approx((1e-3, 0.0))
    bench.go(1e-3, 2.0)
    bench.run(2.5)
    with pytest.raises(CommandError, match="in the skin"):
        bench.testbed.place(0.0, 0.0)
