"""The driver over drivers that were not made for it, each killed in turn."""

import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("skin_testbed_msgs")

from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import JointState
from skin_testbed_msgs.msg import DriverState, TaxelArray
from skin_testbed_msgs.srv import Zero
from std_srvs.srv import Trigger

from skin_models.ros.processes import Process

REMAP = {"axis_state": "joint_states", "axis_command": "axis_trajectory", "force_in": "wrench", "taxels_in": "tactile"}
PARAMETERS = {
    "rig": "topics", "joint": "z_axis", "axis_sign": -1.0, "taxels_type": "Float64MultiArray", "taxels": 2,
    "stale_after": 1.0, "max_following_error": 3e-3,  # generous: these processes share a busy machine
}  # fmt: skip


class Hardware:
    """Three foreign processes and the driver over them."""

    def __init__(self, graph, kind: str = "JointTrajectory", **parameters) -> None:
        self.graph = graph
        self.parts = {"axis": ["axis", kind], "load_cell": ["load_cell", "10000"], "taxels": ["taxels"]}
        self.running = {name: self.start(name) for name in self.parts}
        parameters = {**PARAMETERS, "command_type": kind, **parameters}
        self.driver = graph.processes.start("skin_testbed_driver", "driver_node", parameters=parameters, remap=REMAP)
        graph.states = graph.hear(DriverState, "driver_state", latched=True)
        self.axis, graph.encoder = graph.hear(JointState, "joint_states"), graph.hear(JointState, "encoder")
        self.force, self.taxels = graph.hear(WrenchStamped, "force"), graph.hear(TaxelArray, "taxels")
        graph.wait(lambda: graph.state() == DriverState.READY and self.axis, "the driver and the axis")

    def start(self, name: str) -> Process:
        script = Path(__file__).with_name("hardware.py")
        process = Process([sys.executable, str(script), *self.parts[name]], self.graph.domain.environment(), name)
        self.graph.processes.running.append(process)
        return process

    def depth(self) -> float:
        return self.depth_of(self.axis[-1])

    def depth_of(self, message: JointState) -> float:
        return -0.052 - message.position[1]

    def samples(self, count: int = 50) -> None:
        start = len(self.axis)
        self.graph.wait(lambda: len(self.axis) > start + count, "more of the axis")


@pytest.mark.parametrize("kind", ["JointTrajectory", "Float64MultiArray"])
def test_it_presses_and_measures_over_foreign_drivers(graph, kind):
    hardware = Hardware(graph, kind)
    graph.command((3.0, 1e-3, 0.0))
    graph.wait(lambda: graph.state() == DriverState.MOVING, "motion")
    graph.wait(lambda: graph.state() == DriverState.READY, "its end")
    hardware.samples()
    assert hardware.depth() == pytest.approx(1e-3, abs=1e-6)
    assert -hardware.force[-1].wrench.force.z == pytest.approx(10.0, abs=0.01)
    assert list(hardware.taxels[-1].force) == pytest.approx([8.0, 4.0])


@pytest.mark.parametrize(("victim", "words"), [("load_cell", "load cell"), ("axis", "encoder")])
def test_a_killed_sensor_stops_the_motion_until_it_is_back_and_reset(graph, victim, words):
    hardware = Hardware(graph)
    graph.command((10.0, 3e-3, 0.0))
    graph.wait(lambda: hardware.depth() > 1e-4, "contact")
    hardware.running[victim].kill()
    graph.wait(lambda: graph.state() == DriverState.STOPPED, "the stop")
    assert f"the {words} gives no fresh reading" in graph.states[-1].reason
    if victim == "load_cell":
        hardware.samples()
        rest = hardware.depth()
        hardware.samples(100)
        assert hardware.depth() == rest
        count = len(hardware.force)
        graph.wait(lambda: len(hardware.force) > count, "force")
        assert np.isnan(hardware.force[-1].wrench.force.z)
    hardware.start(victim)
    graph.wait(lambda: graph.call(Trigger, "testbed_driver/reset").success, "a reset")
    graph.wait(lambda: graph.state() == DriverState.READY, "readiness")


def test_an_axis_that_is_started_again_after_a_stop_stays_where_it_is(graph):
    hardware = Hardware(graph)
    graph.command((2.0, 5e-4, 0.0))
    graph.wait(lambda: hardware.depth() == pytest.approx(5e-4, abs=1e-6), "the depth")
    assert graph.call(Trigger, "testbed_driver/stop").success
    hardware.running["axis"].kill()
    graph.wait(lambda: hardware.force and np.isnan(graph.encoder[-1].position[0]), "silence")
    hardware.start("axis")  # it wakes 2 mm above the skin
    hardware.samples(200)
    assert {round(1e6 * hardware.depth_of(m)) for m in hardware.axis[-190:]} == {-2000}
    assert graph.call(Trigger, "testbed_driver/reset").success
    hardware.samples(100)
    assert hardware.depth() == pytest.approx(-2e-3, abs=1e-6)


def test_zero_finds_the_surface_with_a_foreign_load_cell(graph):
    hardware = Hardware(graph)
    answer = graph.call(Zero, "testbed_driver/zero")
    assert answer.success, answer.message
    assert answer.shift == pytest.approx(0.0, abs=1e-5)
    assert min(m.wrench.force.z for m in hardware.force) > -3.0


def test_killed_taxels_are_nan_with_a_status_and_stop_nothing(graph):
    hardware = Hardware(graph)
    graph.wait(lambda: hardware.taxels and np.isfinite(hardware.taxels[-1].force).all(), "taxels")
    hardware.running["taxels"].kill()
    graph.wait(lambda: np.isnan(hardware.taxels[-1].force).all(), "NaN")
    assert list(hardware.taxels[-1].status) == [TaxelArray.STALE] * 2
    assert graph.state() == DriverState.READY


def test_without_hardware_it_waits_and_says_for_what(graph):
    driver = graph.processes.start("skin_testbed_driver", "driver_node", parameters=PARAMETERS, remap=REMAP)
    graph.states = graph.hear(DriverState, "driver_state", latched=True)
    graph.wait(lambda: graph.state() == DriverState.STOPPED, "the state")
    assert "waiting for the first reading" in graph.states[-1].reason
    assert not graph.call(Trigger, "testbed_driver/reset").success
    assert driver.end(30.0) == 0


def test_a_joint_or_a_number_of_taxels_that_does_not_fit_is_said_so(graph):
    hardware = Hardware(graph, taxels=3)
    graph.wait(lambda: "taxels_in has 2 values for 3 taxels" in hardware.driver.output(), "the complaint")
    assert hardware.driver.end(30.0) == 0
    other = {**PARAMETERS, "joint": "zaxis"}
    driver = graph.processes.start("skin_testbed_driver", "driver_node", parameters=other, remap=REMAP)
    graph.wait(lambda: "axis_state tells of " in driver.output() and "set the parameter joint" in driver.output(), "the complaint")
