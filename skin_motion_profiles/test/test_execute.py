"""The installed command line client: what it prints, and its exit status."""

import re
import signal
import time

import pytest

pytest.importorskip("rclpy")
pytest.importorskip("skin_testbed_msgs")

from bench_of_one import Bench

from skin_models.ros.processes import Processes

SLOW = "{type: step, depth_mm: 1, hold_s: 20}"


@pytest.fixture(scope="module")
def bench():
    bench = Bench()
    yield bench
    bench.close()


def execute(bench, *arguments, name="execute"):
    return bench.processes.start("skin_motion_profiles", "execute", arguments, remap={"__node": name})


def in_the_graph(bench, *arguments):
    """Start it under a name of its own, for a node that has ended stays in the graph for a while, and wait until it is seen."""
    name = f"client_{time.monotonic_ns()}"
    process = execute(bench, *arguments, name=name)
    bench.until(lambda: name in bench.node.get_node_names(), "the client")
    return process


def outcome(bench, *arguments):
    process = execute(bench, *arguments)
    return bench.wait(process), process.output()


def test_success_is_0_and_tells_every_profile(bench):
    step, air = "{type: step, depth_mm: 1, hold_s: 0.3}", "{type: free_air, duration_s: 0.3}"
    status, output = outcome(bench, f"{{type: battery, profiles: [{step}, {air}]}}")
    assert status == 0, output
    assert "1/2 step" in output and "2/2 free_air" in output
    assert re.search(r"executed to its end: \d+\.\d s, peak force 1[12]\.\d\d N, greatest depth 1\.000 mm", output)


def test_a_failed_goal_is_1_with_its_reason(bench):
    status, output = outcome(bench, "{type: step, depth_mm: 1}", "--max-force", "5")
    assert status == 1 and re.search(r"execute: OVER_FORCE: the force reached \d+\.\d\d N, more than the allowed 5 N", output)


def test_arguments_that_ros_cannot_parse_are_2(bench):
    status, output = outcome(bench, "{type: step}", "--ros-args", "--params-file", "no_such.yaml")
    assert status == 2 and output.startswith("execute: ROS arguments cannot be used: ") and len(output.splitlines()) == 1


def test_a_motion_beyond_the_limits_is_2(bench):
    status, output = outcome(bench, "{type: step}", "depth_mm=5")
    assert status == 2 and "INVALID_PROFILE: step goes down to 5.000 mm, but the limit of depth is 3.000 mm" in output


def test_interrupt_cancels_and_waits_for_the_retreat(bench):
    process = execute(bench, SLOW)
    bench.depths.clear()
    bench.moving(0.0009)
    process.send(signal.SIGINT)
    assert bench.wait(process) == 1
    assert "CANCELLED: cancelled" in process.output()
    bench.spin(0.2)
    assert bench.depth == pytest.approx(-0.002, abs=1e-5)


def test_whenever_it_is_interrupted_no_goal_runs_on(bench):
    """The moments are spread over the start: discovery, the goal's acceptance, the approach."""
    for k in range(6):
        process = in_the_graph(bench, SLOW)
        bench.spin(0.02 * 3.0**k / 4.0)
        process.send(signal.SIGINT)
        assert bench.wait(process) == 1, process.output()
        assert re.search(r"execute: (interrupted before|CANCELLED: cancelled)", process.output()), process.output()
        assert "Traceback" not in process.output()
        assert bench.run("{type: free_air, duration_s: 0.1}").error_code == 0


def test_the_death_of_the_server_is_noticed():
    bench = Bench()
    try:
        process = execute(bench, SLOW)
        bench.moving(0.0009)
        bench.server.kill()
        assert bench.wait(process) == 1
        assert "the profile server has gone" in process.output()
    finally:
        bench.close()


BAD = {
    ("nosuch",): "no profile, no battery and no YAML file",
    ("stpe", "depth_mm=1"): "did you mean step",
    ("step", "depht_mm=1"): "depth_mm",
    ("nosuch.yaml",): "cannot read nosuch.yaml",
    ("{type: sin}",): "did you mean sine",
    ("demo", "depth=1"): "has no argument 'depth'",
    ("demo", "deep"): "write key=value",
    ("step", "depth_mm=1", "depth_mm=2"): "depth_mm is given twice",
    ("demo", "--max-force", "-1"): "must be a positive number of newtons",
    ("demo", "--max-force", "much"): "'much' must be a positive number of newtons",
    ("demo", "--max-force", "nan"): "'nan' must be a positive number of newtons",
    ("--describe", "sinne"): "did you mean sine",
    (): "required",
}


@pytest.mark.parametrize("arguments", BAD)
def test_bad_input_is_2_and_one_sentence(arguments):
    with Processes() as processes:
        process = processes.start("skin_motion_profiles", "execute", arguments)
        assert process.wait(30.0) == 2
        assert BAD[arguments] in process.output() and "Traceback" not in process.output()
