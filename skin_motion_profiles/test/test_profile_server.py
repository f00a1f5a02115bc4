"""The installed profile server against a driver in another process: every way in which a goal can end."""

import math
import signal

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("skin_testbed_msgs")

from action_msgs.msg import GoalStatus
from bench_of_one import Bench
from sensor_msgs.msg import JointState
from skin_testbed_msgs.action import ExecuteProfile

from skin_motion_profiles.profile_file import entry_from_text

Result = ExecuteProfile.Result
LONG = "{type: step, depth_mm: 1, hold_s: 20, rest_s: 0}"
RETRACTED = -0.002
EXPLICIT = "{type: explicit_force, forces_n: 6, stiffness_n_mm: 12, deepest_mm: 1.5, search_mm_s: 2, speed_mm_s: 4"


@pytest.fixture(scope="module")
def bench():
    bench = Bench()
    yield bench
    bench.close()


@pytest.fixture(autouse=True)
def mended(request):
    yield
    if "bench" in request.fixturenames:
        request.getfixturevalue("bench").mend()


@pytest.mark.parametrize("text", [
    "{type: sine, amplitude_mm: 0.3, frequency_hz: 2, offset_mm: 0.5, periods: 2}",
    "{type: step, depth_mm: 1, hold_s: 0.5}",
    "{type: stair_step, depth_mm: 1, steps: 3, hold_s: 0.2, speed_mm_s: 5}",
])  # fmt: skip
def test_the_plunger_does_what_the_profile_says(bench, text):
    bench.depths.clear()
    result = bench.run(text)
    assert (result.error_code, result.error_string) == (Result.SUCCESS, "executed to its end")
    trajectory = entry_from_text(text).trajectory()
    end = result.started.sec + 1e-9 * result.started.nanosec + approach(trajectory.start) + trajectory.duration
    t, x = np.array(bench.depths).T
    within = (t > end - trajectory.duration) & (t < end)
    assert within.sum() > 0.95 * 100 * trajectory.duration
    assert np.abs(x - trajectory.sample(t - end + trajectory.duration).x)[within].max() < 2e-6
    assert result.peak_depth == pytest.approx(trajectory.reach().high, abs=2e-6)
    assert result.peak_force == pytest.approx(12000.0 * trajectory.reach().high, rel=1e-2)


def approach(to):
    """Seconds of a trapezoid at 20 mm/s and 0.5 m/s^2 from the retracted depth."""
    way, peak = to - RETRACTED, min(0.02, math.sqrt((to - RETRACTED) * 0.5))
    return way / peak + peak / 0.5


def test_feedback_tells_progress_segment_depth_and_force(bench):
    bench.run("{type: battery, profiles: [{type: free_air, duration_s: 0.5}, {type: step, depth_mm: 1, hold_s: 1}]}")
    progress = [f.progress for f in bench.feedback]
    assert len(progress) > 8 and progress == sorted(progress) and progress[-1] > 0.9
    assert sorted({f.segment for f in bench.feedback}) == ["1/2 free_air", "2/2 step"]
    assert max(f.depth for f in bench.feedback) == pytest.approx(1e-3, abs=1e-6)
    assert bench.feedback[-1].peak_force == pytest.approx(12.0, rel=1e-3)


def test_joints_without_positions_are_passed_over(bench):
    odd = bench.node.create_publisher(JointState, "encoder", 10)
    bench.until(lambda: odd.get_subscription_count() >= 2, "server and bench")
    odd.publish(JointState(name=["indentation"]))
    odd.publish(JointState(name=["other", "indentation"], position=[0.0]))
    assert bench.run("{type: step, depth_mm: 0.2, hold_s: 0.1, rest_s: 0.1}").error_code == Result.SUCCESS


def test_a_battery_zeroes_and_tares_between_motions(bench):
    air, rest = "{type: free_air, duration_s: 0.2}", "{type: hold, duration_s: 0.2}"
    result = bench.run(f"{{type: battery, profiles: [{air}, {{type: tare}}, {{type: zero}}, {rest}]}}")
    assert result.error_code == Result.SUCCESS
    assert bench.depth == pytest.approx(0.0, abs=1e-6)


def test_after_zero_the_next_motion_waits_for_a_depth_that_counts_from_it(bench):
    bench.make_it("pause_after_zero")
    bench.spin(0.2)
    result = bench.run("{type: battery, profiles: [{type: free_air, duration_s: 0.2}, {type: zero}, {type: hold, duration_s: 0.2}]}")
    assert result.error_code == Result.SUCCESS, result.error_string
    assert bench.depth == pytest.approx(0.0, abs=1e-6)


def test_a_zero_that_finds_nothing_ends_the_goal(bench):
    bench.make_it("no_surface")
    result = bench.run("{type: battery, profiles: [{type: free_air, duration_s: 0.2}, {type: zero}, {type: hold, duration_s: 9}]}")
    assert (result.error_code, result.error_string) == (Result.DRIVER_FAULT, "zero: no contact within 10 mm")


def test_tare_in_the_skin_is_refused(bench):
    result = bench.run("{type: battery, profiles: [{type: straight_line, to_mm: 0.5, speed_mm_s: 20}, {type: tare}]}")
    assert (result.error_code, result.error_string) == (Result.DRIVER_FAULT, "tare: retract it, then tare")


def test_a_person_at_the_stage_says_when_to_go_on(bench):
    from std_srvs.srv import Trigger

    handle = bench.give("{type: lateral_scan, offsets_mm: 3, depth_mm: 0.5, settle_s: 0.1}")
    bench.until(lambda: any("x = 3 mm" in f.segment for f in bench.feedback), "the request to move the stage")
    client = bench.node.create_client(Trigger, "profile_server/proceed")
    bench.until(client.service_is_ready, "the service")
    client.call_async(Trigger.Request())
    assert bench.end(handle)[1].error_code == Result.SUCCESS


@pytest.mark.parametrize("text, sentence", [
    ("{type: sin}", "did you mean sine"),
    ("{type: step, depth_mm: 5}", "step goes down to 5.000 mm, but the limit of depth is 3.000 mm"),
    ("{type: step, depth_mm: 1, speed_mm_s: 50, acceleration_mm_s2: 20000}", "limit of speed is 20.000 mm/s"),
    ("{type: step, depth_mm: 1, acceleration_mm_s2: 900}", "accelerates by 900.0 mm/s^2, but the limit is 500.0"),
    ("{type: free_air, clearance_mm: 9}", "the limit in the air is -5.000 mm"),
])  # fmt: skip
def test_what_the_limits_forbid_is_refused_before_anything_moves(bench, text, sentence):
    bench.spin(0.2)
    bench.commands.clear()
    status, result = bench.end(bench.give(text))
    assert (status, result.error_code) == (GoalStatus.STATUS_ABORTED, Result.INVALID_PROFILE)
    assert sentence in result.error_string
    bench.spin(0.3)
    assert not bench.commands


@pytest.mark.parametrize("more, sentence", [({"max_force": -1.0}, "must be positive"), ({"max_force": math.nan}, "must be positive")])
def test_a_senseless_force_is_refused(bench, more, sentence):
    result = bench.run(LONG, **more)
    assert result.error_code == Result.INVALID_PROFILE and sentence in result.error_string


def test_a_second_goal_is_busy_and_the_first_goes_on(bench):
    first = bench.give("{type: step, depth_mm: 1, hold_s: 1}")
    bench.moving()
    status, result = bench.end(bench.give("{type: hold, duration_s: 1}"))
    assert (status, result.error_code) == (GoalStatus.STATUS_ABORTED, Result.BUSY)
    assert "another profile is running" in result.error_string
    assert bench.end(first)[1].error_code == Result.SUCCESS


@pytest.mark.parametrize("hold", [False, True])
def test_cancel_retracts_or_holds(bench, hold):
    handle = bench.give(LONG, hold=hold)
    bench.moving(0.0009)
    handle.cancel_goal_async()
    status, result = bench.end(handle)
    assert (status, result.error_code) == (GoalStatus.STATUS_CANCELED, Result.CANCELLED)
    assert bench.depth > 0.0009 if hold else bench.depth == pytest.approx(RETRACTED, abs=2e-6)


@pytest.mark.parametrize("hold", [False, True])
def test_over_force_retracts_or_holds(bench, hold):
    result = bench.run(LONG, max_force=6.0, hold=hold)
    assert result.error_code == Result.OVER_FORCE
    assert "more than the allowed 6 N" in result.error_string
    assert result.peak_force > 6.0
    bench.spin(0.1)
    assert bench.depth > 0.0005 if hold else bench.depth == pytest.approx(RETRACTED, abs=2e-6)


def test_after_a_stop_the_speed_never_jumps(bench):
    bench.depths.clear()
    handle = bench.give("{type: sine, amplitude_mm: 0.8, frequency_hz: 1, offset_mm: 1, periods: 20}")
    bench.moving(0.0015)
    handle.cancel_goal_async()
    bench.end(handle)
    t, x = np.array(bench.depths).T
    speed = np.diff(x) / np.diff(t)
    assert np.abs(np.diff(speed)).max() < 1.5 * 0.5 * 0.01  # the greatest acceleration times a sample


@pytest.mark.parametrize("fault, code, sentence", [
    ("mute_encoder", Result.NO_FEEDBACK, "no valid sample on encoder for 2 s"),
    ("mute_force", Result.NO_FEEDBACK, "no valid sample on force for 2 s"),
    ("nan_force", Result.NO_FEEDBACK, "no valid sample on force for 2 s"),
    ("stop", Result.DRIVER_FAULT, "the driver has stopped: somebody pressed the button"),
    ("block", Result.OVER_FORCE, "the force reached 500.00 N"),
])  # fmt: skip
def test_a_fault_ends_the_goal_with_its_reason(bench, fault, code, sentence):
    handle = bench.give(LONG)
    bench.moving(0.0009)
    bench.make_it(fault)
    status, result = bench.end(handle)
    assert (status, result.error_code) == (GoalStatus.STATUS_ABORTED, code)
    assert sentence in result.error_string


def test_a_stage_that_sticks_is_a_depth_error(bench):
    handle = bench.give("{type: sine, amplitude_mm: 0.5, frequency_hz: 0.5, periods: 20}")
    bench.moving(0.0006)
    bench.make_it("stick")
    result = bench.end(handle)[1]
    assert result.error_code == Result.DEPTH_ERROR and "the stage does not follow" in result.error_string


def test_a_stopped_driver_takes_no_goal(bench):
    bench.make_it("stop")
    bench.spin(0.2)
    result = bench.run(LONG)
    assert result.error_code == Result.DRIVER_FAULT and "somebody pressed the button" in result.error_string


@pytest.mark.parametrize("text, error", [
    (EXPLICIT + ", ramp_n_s: 20, hold_s: 3}", 0.1),
    ("{type: incremental_force, force_n: 6, deepest_mm: 1.5, duration_s: 5, search_mm_s: 1, speed_mm_s: 5}", 0.4),
])  # fmt: skip
def test_a_controlled_force_is_reached(bench, text, error):
    result = bench.run(text)
    assert result.error_code == Result.SUCCESS, result.error_string
    assert 12000.0 * bench.depth == pytest.approx(6.0, abs=error)


def test_a_search_that_finds_nothing_ends_the_goal(bench):
    result = bench.run("{type: incremental_force, force_n: 6, deepest_mm: -0.5, highest_mm: -2, search_mm_s: 4, speed_mm_s: 4}")
    assert result.error_code == Result.DEPTH_ERROR and "no contact of 0.3 N down to deepest_mm = -0.5" in result.error_string


def test_a_controlled_force_can_be_cancelled(bench):
    handle = bench.give(EXPLICIT + ", hold_s: 30}")
    bench.moving(0.0002)
    handle.cancel_goal_async()
    assert bench.end(handle)[1].error_code == Result.CANCELLED
    assert bench.depth == pytest.approx(RETRACTED, abs=2e-6)


def test_without_a_driver_a_goal_ends_with_a_hint():
    bench = Bench(driver=False)
    try:
        result = bench.run(LONG)
        assert result.error_code == Result.DRIVER_FAULT and "start driver_node" in result.error_string
    finally:
        bench.close()


def test_the_death_of_the_driver_ends_the_goal():
    bench = Bench()
    try:
        handle = bench.give(LONG)
        bench.moving(0.0009)
        bench.driver.kill()
        result = bench.end(handle)[1]
        assert result.error_code == Result.NO_FEEDBACK and "no valid sample on" in result.error_string
    finally:
        bench.close()


def test_a_server_asked_to_end_lets_the_plunger_retract_and_says_so():
    bench = Bench()
    try:
        handle = bench.give(LONG)
        bench.moving(0.0009)
        bench.server.send(signal.SIGINT)
        assert bench.end(handle)[1].error_code == Result.CANCELLED
        assert bench.server.wait(10.0) == 0
        bench.until(lambda: abs(bench.depth - RETRACTED) < 1e-5, "the retreat", 5.0)
    finally:
        bench.close()


def test_ten_times_faster_than_real():
    bench = Bench(scale=10.0)
    try:
        sine = "{type: sine, amplitude_mm: 0.3, frequency_hz: 2, periods: 30}"
        result = bench.run(f"{{type: battery, profiles: [{{type: free_air}}, {sine}, {{type: free_air}}]}}")
        assert result.error_code == Result.SUCCESS, result.error_string
        assert result.duration > 18.0  # of simulated time
    finally:
        bench.close()


def test_another_clock_is_said_so():
    bench = Bench(scale=10.0, parameters={"use_sim_time": False})
    try:
        bench.spin(1.5)
        result = bench.run(LONG)
        assert result.error_code == Result.NO_FEEDBACK and "set use_sim_time as the driver does" in result.error_string
    finally:
        bench.close()
