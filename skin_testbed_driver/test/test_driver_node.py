"""The installed driver over real DDS."""

import math
import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("skin_testbed_msgs")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import WrenchStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.srv import DescribeParameters, SetParameters
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from skin_testbed_msgs.msg import DriverState, TaxelArray, TaxelLayout
from skin_testbed_msgs.srv import Tare, Zero
from std_srvs.srv import Trigger

from skin_models.ros.processes import Processes

DRIVER = "testbed_driver/"


def stamps(messages) -> list[int]:
    return [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in messages]


def depths(messages) -> np.ndarray:
    return np.array([m.position[0] for m in messages])


@pytest.mark.parametrize(("rate", "scale"), [(100.0, 1.0), (1000.0, 1.0), (100.0, 10.0)])
def test_every_sample_has_one_stamp_on_all_topics_and_none_is_missing(graph, rate, scale):
    graph.driver(sample_rate=rate, time_scale=scale)
    heard = [graph.hear(kind, name) for kind, name in ((JointState, "encoder"), (WrenchStamped, "force"), (TaxelArray, "taxels"))]
    graph.wait(lambda: min(map(len, heard)) > 300, "300 samples")
    first = max(stamps(h)[0] for h in heard)
    last = min(stamps(h)[-1] for h in heard)
    common = [[s for s in stamps(h) if first <= s <= last] for h in heard]
    assert common[0] == common[1] == common[2]
    assert set(np.diff(common[0])) == {round(1e9 / rate)}


def test_what_is_published_says_what_it_is(graph):
    graph.driver()
    force, encoder = graph.hear(WrenchStamped, "force"), graph.hear(JointState, "encoder")
    taxels, layout = graph.hear(TaxelArray, "taxels"), graph.hear(TaxelLayout, "taxel_layout", latched=True)
    truth, clock = graph.hear(TaxelArray, "taxels_truth"), graph.hear(Clock, "/clock")
    graph.wait(lambda: all((force, encoder, taxels, layout, truth, clock)), "all topics")
    assert force[0].header.frame_id == "load_cell"
    assert encoder[0].name == ["indentation"]
    assert taxels[0].header.frame_id == layout[0].header.frame_id == "skin"
    assert layout[0].names == ["taxel_0"] and layout[0].normals[0].z == 1.0
    assert graph.states[-1].max_force == pytest.approx(111.2055)


def test_pressing_gives_the_forces_of_the_specimen(graph):
    graph.driver()
    force, taxels = graph.hear(WrenchStamped, "force"), graph.hear(TaxelArray, "taxels")
    graph.command((3.0, 1e-3, 0.0))
    graph.wait(lambda: graph.state() == DriverState.MOVING, "motion")
    graph.wait(lambda: graph.state() == DriverState.READY, "the end of the motion")
    count = len(force)
    graph.wait(lambda: len(force) > count + 100 and len(taxels) > count + 100, "a second more")
    assert -np.mean([m.wrench.force.z for m in force[-50:]]) == pytest.approx(12.385, abs=0.1)
    assert np.mean([m.force[0] for m in taxels[-50:]]) == pytest.approx(9.619, abs=0.1)


def test_zero_and_tare_answer_when_they_are_done(graph):
    graph.driver(surface_offset=3e-4)
    encoder = graph.hear(JointState, "encoder")
    zero = graph.call(Zero, DRIVER + "zero")
    assert zero.success, zero.message
    assert zero.shift == pytest.approx(3e-4, abs=6e-6)
    tare = graph.call(Tare, DRIVER + "tare")
    assert tare.success and abs(tare.force_offset) < 0.05 and len(tare.taxel_offset) == 1
    graph.wait(lambda: graph.states[-1].zeroed and graph.states[-1].tared, "both in the state")
    assert (graph.states[-1].zero_count, graph.states[-1].tare_count) == (1, 1)
    assert encoder[-1].position[0] == pytest.approx(-0.002, abs=1e-5)
    assert graph.call(Trigger, DRIVER + "reset_tare").success


def call(graph, *arguments):
    """The installed command, from its start to its end."""
    process = graph.processes.start("skin_testbed_driver", "call", arguments)
    graph.wait(lambda: process.status is not None, "the end of call")
    return process


def test_services_are_called_from_the_command_line(graph):
    driver = graph.driver(surface_offset=3e-4)
    assert call(graph, "stop").status == 0
    driver.wait_for_output("stopped: the service stop was called; to go on, .*run skin_testbed_driver call reset", 60.0)
    refused = call(graph, "zero")
    assert refused.status == 1 and "call: zero: the driver is stopped" in refused.output() and "call reset" in refused.output()
    reset = call(graph, "reset")
    assert (reset.status, reset.output()) == (0, "reset: ready\n")
    assert call(graph, "zero").status == 0 and call(graph, "tare").status == 0
    graph.wait(lambda: graph.states[-1].zeroed and graph.states[-1].tared, "both in the state")


def test_an_interrupted_call_ends_the_search_and_leaves_the_driver_ready(graph):
    graph.driver(time_scale=1.0)
    process = graph.processes.start("skin_testbed_driver", "call", ["zero"])
    graph.wait(lambda: graph.state() == DriverState.MOVING, "the search")
    process.send(signal.SIGINT)
    graph.wait(lambda: process.status is not None, "the end of call")
    assert (process.status, process.output()) == (1, "call: zero: cancelled\n")
    graph.wait(lambda: graph.state() == DriverState.READY, "readiness")


def test_a_call_without_a_driver_says_so(graph):
    absent = call(graph, "reset")
    assert absent.status == 1 and "nobody offers the service /testbed_driver/reset: does driver_node run" in absent.output()
    unknown = call(graph, "resett")
    assert unknown.status == 2 and "invalid choice: 'resett'" in unknown.output()


def test_killing_the_commander_stops_the_motion_until_a_reset(graph):
    """The profile server streams a sine; it is killed in the middle of it."""
    from rclpy.action import ActionClient
    from skin_testbed_msgs.action import ExecuteProfile

    graph.driver(time_scale=1.0)
    server = graph.processes.start("skin_motion_profiles", "profile_server")
    client = ActionClient(graph.node, ExecuteProfile, "execute_profile")
    graph.wait(client.server_is_ready, "the profile server")
    profile = "{type: sine, amplitude_mm: 0.4, frequency_hz: 0.5, offset_mm: 0.5, periods: 30}"
    sent = client.send_goal_async(ExecuteProfile.Goal(profile=profile))
    graph.wait(sent.done, "the goal")
    encoder = graph.hear(JointState, "encoder")
    graph.wait(lambda: encoder and encoder[-1].position[0] > 3e-4, "the sine")
    server.kill()
    killed = len(encoder)
    graph.wait(lambda: graph.state() == DriverState.STOPPED, "the stop")
    assert "ran out" in graph.states[-1].reason
    count = len(encoder)
    graph.wait(lambda: len(encoder) > count + 100, "a second more")
    x = depths(encoder)
    assert np.abs(x[-50:] - x[-1]).max() <= 6e-6  # it settles, and rests
    assert len(encoder[killed:count]) < 200  # the lookahead of the server, and braking
    graph.command((1.0, 0.0, 0.0))
    graph.wait(lambda: len(encoder) > count + 150, "a command that is not obeyed")
    assert graph.state() == DriverState.STOPPED
    assert graph.call(Trigger, DRIVER + "reset").success
    graph.wait(lambda: graph.state() == DriverState.READY, "readiness")


def test_over_force_stops_and_retracts(graph):
    graph.driver(max_force=5.0)
    force, encoder = graph.hear(WrenchStamped, "force"), graph.hear(JointState, "encoder")
    graph.command((3.0, 3e-3, 0.0))
    graph.wait(lambda: graph.state() == DriverState.STOPPED, "the stop")
    graph.wait(lambda: encoder[-1].position[0] < -1.99e-3, "the retraction")
    assert "more than the limit of 5.0 N" in graph.states[-1].reason
    n = [-m.wrench.force.z for m in force]
    first = next(i for i, value in enumerate(n) if value > 5.0)
    seen, x = stamps(force)[first], dict(zip(stamps(encoder), depths(encoder), strict=True))
    period = 10**7
    assert x[seen + 3 * period] < x[seen]
    assert max(x.values()) <= x[seen] + 1.5 * (x[seen] - x[seen - period])


def test_deactivating_brakes_and_says_so(graph):
    graph.driver()
    encoder = graph.hear(JointState, "encoder")
    graph.command((60.0, 3e-3, 0.0))
    graph.wait(lambda: graph.state() == DriverState.MOVING and len(encoder) > 100, "motion")
    request = ChangeState.Request(transition=Transition(id=Transition.TRANSITION_DEACTIVATE))
    assert graph.call(ChangeState, DRIVER + "change_state", request).success
    graph.wait(lambda: graph.state() == DriverState.INACTIVE, "inactivity")
    x = depths(encoder)
    assert abs(x[-1] - x[-2]) <= 2e-6
    request.transition.id = Transition.TRANSITION_ACTIVATE
    assert graph.call(ChangeState, DRIVER + "change_state", request).success
    graph.wait(lambda: graph.state() == DriverState.STOPPED, "the stop")
    assert "deactivated" in graph.states[-1].reason


def test_stamps_are_those_of_the_clock_also_after_a_pause(graph):
    graph.driver(time_scale=1.0)
    arrivals = []
    graph.node.create_subscription(JointState, "encoder", lambda m: arrivals.append((time.time(), stamps([m])[0] * 1e-9)), 1000)
    graph.wait(lambda: len(arrivals) > 100, "samples")
    for transition in (Transition.TRANSITION_DEACTIVATE, Transition.TRANSITION_ACTIVATE):
        request = ChangeState.Request(transition=Transition(id=transition))
        assert graph.call(ChangeState, DRIVER + "change_state", request).success
    count = len(arrivals)
    graph.wait(lambda: len(arrivals) > count + 100, "samples after the pause")
    for part in (arrivals[:count], arrivals[count + 10 :]):
        assert 0.0 <= min(came - stamp for came, stamp in part) < 0.04


def test_without_autostart_a_manager_leads_through_the_states(graph):
    graph.processes.start("skin_testbed_driver", "driver_node", parameters={"autostart": False})
    encoder = graph.hear(JointState, "encoder")
    for transition in (
        Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE, Transition.TRANSITION_DEACTIVATE,
        Transition.TRANSITION_CLEANUP, Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE,
    ):  # fmt: skip
        request = ChangeState.Request(transition=Transition(id=transition))
        assert graph.call(ChangeState, DRIVER + "change_state", request).success, transition
    count = len(encoder)
    graph.wait(lambda: len(encoder) > count + 10, "samples")


def test_a_driver_that_is_not_active_says_so_to_whoever_asks_for_anything(graph):
    graph.driver()
    inactive = ChangeState.Request(transition=Transition(id=Transition.TRANSITION_DEACTIVATE))
    assert graph.call(ChangeState, DRIVER + "change_state", inactive).success
    for kind, name in ((Zero, "zero"), (Tare, "tare"), *((Trigger, name) for name in ("stop", "reset", "cancel", "reset_tare"))):
        answer = graph.call(kind, DRIVER + name)
        assert not answer.success and "activate it first" in answer.message, name


def test_what_makes_no_sense_is_answered_and_ends_nothing(graph):
    driver = graph.driver()
    wrong = Transition(id=77), Transition(id=Transition.TRANSITION_ACTIVATE), Transition(label="fly")
    for transition in wrong:
        assert not graph.call(ChangeState, DRIVER + "change_state", ChangeState.Request(transition=transition)).success
    for request in (Zero.Request(threshold=math.nan), Zero.Request(threshold=-1.0), Zero.Request(samples=10**9)):
        answer = graph.call(Zero, DRIVER + "zero", request)
        assert not answer.success and "zero_" in answer.message
    for duration in (math.nan, math.inf, -1.0, 1e9):
        answer = graph.call(Tare, DRIVER + "tare", Tare.Request(duration=duration))
        assert not answer.success and "tare_duration" in answer.message
    assert graph.state() == DriverState.READY and driver.status is None


def test_a_command_of_another_clock_is_refused(graph):
    graph.driver()
    for seconds, words in ((1000, "ago: check the clock"), (2 * 10**9, "from now: check the clock")):
        graph.command((1.0, -1e-3, 0.0), stamp=seconds)
        graph.wait(lambda w=words: w in graph.states[-1].reason, "the stop")
        graph.wait(lambda: graph.call(Trigger, DRIVER + "reset").success, "a reset")
        graph.wait(lambda: graph.state() == DriverState.READY, "readiness")


def test_diagnostics_tell_rate_drops_and_faults(graph):
    graph.driver()
    heard = graph.hear(DiagnosticArray, "/diagnostics")
    graph.call(Trigger, DRIVER + "stop")
    graph.wait(lambda: heard and any(s.level == b"\x02" for s in heard[-1].status), "the stop as an error")
    sampling, motion, sensors = heard[-1].status
    keys = {v.key for v in sampling.values}
    assert {"achieved_rate_hz", "jitter_p99_us", "overruns", "skipped"} <= keys
    assert "the service stop was called" in motion.message
    assert sensors.level == b"\x00"


def test_a_second_driver_on_the_same_topics_does_not_go_unnoticed(graph):
    first = graph.driver(time_scale=1.0)
    second = graph.driver(time_scale=1.0)
    heard = graph.hear(DiagnosticArray, "/diagnostics")
    for process in (first, second):
        graph.wait(lambda p=process: "/testbed_driver publishes the same topics" in p.output(), "the complaint")
    graph.wait(lambda: any("publishes the same" in m.status[0].message for m in heard), "an error")
    assert all(m.status[0].level == DiagnosticStatus.ERROR for m in heard if "publishes the same" in m.status[0].message)
    second.end(30.0)
    graph.wait(lambda: heard and "samples skipped" in heard[-1].status[0].message, "peace")


def test_two_clocks_do_not_go_unnoticed_either(graph):
    first = graph.driver(time_scale=2.0)
    graph.processes.start("skin_testbed_driver", "driver_node", parameters={"time_scale": 3.0}, remap={"__ns": "/other"})
    graph.wait(lambda: "/other/testbed_driver publishes the same topics" in first.output(), "the complaint")


def test_real_time_priority_is_had_or_its_lack_is_said(graph):
    process = graph.driver(realtime_priority=10)
    encoder = graph.hear(JointState, "encoder")
    graph.wait(lambda: len(encoder) > 50, "samples")
    policies = {os.sched_getscheduler(int(task.name)) for task in Path(f"/proc/{process.pid}/task").iterdir()}
    assert os.SCHED_FIFO in policies or "no real-time priority for sampling" in process.output()


def test_parameters_are_described_ranged_and_checked_on_set(graph):
    graph.driver()
    request = DescribeParameters.Request(names=["max_force", "zero_samples", "rig"])
    force, samples, rig = graph.call(DescribeParameters, DRIVER + "describe_parameters", request).descriptors
    assert force.description.startswith("N,") and force.floating_point_range[0].to_value == 10000.0 and force.read_only
    assert samples.integer_range[0].from_value == 1 and not samples.read_only
    assert "simulated" in rig.description
    for name, value, accepted in (("zero_samples", 50, True), ("zero_samples", 0, False), ("zero_slow", 0.01, False)):
        request = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
        result = graph.call(SetParameters, DRIVER + "set_parameters", request).results[0]
        assert result.successful is accepted
        assert accepted or name in result.reason


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"sample_rate": 5000.0}, "sample_rate must lie between 1.0 and 1000.0"),
        ({"sample_rate": 100}, "decimal point"),
        ({"rig": "imaginary"}, "rig must be one of"),
        ({"model": "/nowhere/model.yaml"}, "cannot read the model"),
        ({"model": "silicon_4mm"}, "there is no material 'silicon_4mm', only"),
        ({"start_depth": 0.1}, "outside its travel"),
        ({"calibration_file": "/nowhere/c.yaml"}, "cannot read the calibration"),
        ({"min_depth": -0.001, "retracted_depth": -0.002}, "in the order"),
        ({"max_force": math.nan}, "max_force"),
    ],
)
def test_what_cannot_be_used_ends_with_one_sentence_and_status_2(graph, parameters, words):
    with Processes(graph.domain.environment()) as processes:
        process = processes.start("skin_testbed_driver", "driver_node", parameters=parameters)
        assert process.wait(60.0) == 2
        lines = [line for line in process.output().splitlines() if line]
    assert len(lines) == 1 and words in lines[0]


def test_it_ends_cleanly_and_rests_before(graph):
    process = graph.driver()
    encoder = graph.hear(JointState, "encoder")
    graph.command((60.0, 3e-3, 0.0))
    graph.wait(lambda: graph.state() == DriverState.MOVING and len(encoder) > 100, "motion")
    assert process.end(LOADED := 30.0) == 0, LOADED
    graph.wait(lambda: graph.state() == DriverState.INACTIVE, "its last word")
