"""The installed profile server with the installed driver and its simulated rig."""

import signal
import sys
import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("skin_testbed_msgs")

sys.path.insert(0, str(Path(__file__).parents[1] / "bench"))
from session import Session, seconds
from skin_testbed_msgs.action import ExecuteProfile

from skin_motion_profiles.plan import Travel, stages
from skin_motion_profiles.profile_file import entry_from_text

Result = ExecuteProfile.Result
FAST = {"driver": {"time_scale": 5.0, "seed": 1}, "server": {"use_sim_time": True}}


def test_the_demo_battery_is_executed_as_planned():
    with Session(**FAST) as session:
        first, _, _ = session.execute("{type: straight_line, to_mm: -1, speed_mm_s: 10}")
        assert first.error_code == Result.SUCCESS, first.error_string
        result, encoder, force = session.execute("{battery: demo, depth_mm: 0.8, seed: 3}")
    assert result.error_code == Result.SUCCESS, result.error_string
    plan = stages(entry_from_text("{battery: demo, depth_mm: 0.8, seed: 3}"))[0].motion(-0.001, Travel(0.002, 0.05)).trajectory
    t = encoder[:, 0] - seconds(result.started)
    within = (t > 0.0) & (t < plan.duration)
    assert np.abs(encoder[:, 1] - plan.sample(t).x)[within].max() < 2e-5
    assert within.sum() > 0.99 * 100.0 * plan.duration
    assert force[:, 1].max() == pytest.approx(result.peak_force, abs=0.5) and result.peak_force > 5.0


def test_a_lateral_scan_moves_the_motorised_stage():
    with Session(**FAST) as session:
        result, encoder, force = session.execute("{type: lateral_scan, offsets_mm: [0, 5], depth_mm: 0.6, settle_s: 0.5}")
    assert result.error_code == Result.SUCCESS, result.error_string
    assert encoder[:, 1].max() == pytest.approx(0.0006, abs=1e-5) and force[:, 1].max() > 5.0


def test_zero_finds_the_surface_and_depths_count_from_there():
    with Session(driver={**FAST["driver"], "surface_offset": 0.0003}, server=FAST["server"]) as session:
        result, _, _ = session.execute("{battery: prepare}")
        assert result.error_code == Result.SUCCESS, result.error_string
        result, _, force = session.execute("{type: step, depth_mm: 0.5, speed_mm_s: 1, hold_s: 1}")
    assert result.error_code == Result.SUCCESS, result.error_string
    assert np.median(force[force[:, 1] > 4.0][:, 1]) == pytest.approx(0.5 * 12.4, rel=0.1)


def test_where_a_step_ends_no_tare_is_taken_and_prepare_still_works():
    with Session(**FAST) as session:
        result, _, _ = session.execute("{type: step, depth_mm: 0.5, speed_mm_s: 2, hold_s: 1}")
        assert result.error_code == Result.SUCCESS, result.error_string
        refused, _, _ = session.execute("{type: tare}")
        assert refused.error_code == Result.DRIVER_FAULT and "retract it to 0.1 mm above or more" in refused.error_string
        result, _, _ = session.execute("{battery: prepare}")
    assert result.error_code == Result.SUCCESS, result.error_string


def test_what_stops_the_driver_ends_the_goal_with_its_words():
    with Session(driver={"max_force": 4.0}) as session:
        result, _, _ = session.execute("{type: step, depth_mm: 1}")
    assert result.error_code == Result.DRIVER_FAULT
    assert "more than the limit of 4.0 N" in result.error_string


@pytest.mark.parametrize("hold", [False, True])
def test_a_cancel_while_the_driver_zeroes_leaves_it_ready(hold):
    with Session(**FAST) as session:
        goal = session.begin("{type: zero}", on_stop=int(hold))
        start = session.encoder[-1][1]
        session.until(lambda: session.encoder[-1][1] > start + 5e-4, "the search")
        result = session.cancel(goal)
        assert result.error_code == Result.CANCELLED
        rests = session.encoder[-1][1]
        assert rests > start + 4e-4 if hold else rests == pytest.approx(-0.002, abs=1e-5)
        again, _, _ = session.execute("{battery: prepare}")
        assert again.error_code == Result.SUCCESS, again.error_string


def test_over_force_in_quick_time_ends_the_goal_and_retracts():
    with Session(**FAST) as session:
        result, encoder, _ = session.execute("{type: step, depth_mm: 1.2, speed_mm_s: 1, hold_s: 5}", max_force=5.0)
    assert result.error_code == Result.OVER_FORCE and "more than the allowed 5 N" in result.error_string
    assert encoder[-1, 1] == pytest.approx(-0.002, abs=1e-5)
    assert encoder[:, 1].max() < 0.001  # it did not go where it would have


def test_over_force_of_the_driver_in_quick_time_retracts_at_once():
    with Session(driver={**FAST["driver"], "max_force": 5.0}, server=FAST["server"]) as session:
        result, encoder, force = session.execute("{type: step, depth_mm: 1.2, speed_mm_s: 1, hold_s: 5}")
        assert result.error_code == Result.DRIVER_FAULT and "more than the limit of 5.0 N" in result.error_string
        session.until(lambda: session.encoder[-1][1] < -0.00199, "the retreat")
    seen = force[np.argmax(force[:, 1] > 5.0), 0]
    x = dict(encoder.tolist())
    at, later = x[seen], [v for t, v in x.items() if seen + 0.025 < t < seen + 0.035]
    assert later and later[0] < at  # three samples after its detection the plunger is on its way back


@pytest.mark.parametrize("pause", [1.0, 3.0])
def test_a_server_that_was_held_up_itself_gives_the_reason_of_the_driver(pause):
    with Session(driver={"seed": 1}) as session:
        goal = session.begin("{type: sine, amplitude_mm: 0.5, frequency_hz: 0.3, periods: 20}")  # half a second in hand ends with speed
        session.until(lambda: session.encoder[-1][1] > 6e-4, "motion")
        session.server.send(signal.SIGSTOP)
        time.sleep(pause)
        session.server.send(signal.SIGCONT)
        result = session.end(goal)
    assert result.error_code == Result.DRIVER_FAULT and "the commands ran out" in result.error_string, result.error_string
