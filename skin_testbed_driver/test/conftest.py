"""A graph of real processes in a domain of its own, and a node of the test in it."""

import os
import time
from collections.abc import Callable
from typing import Any

import pytest

# Without ROS the tests of the core run all the same.
rclpy = pytest.importorskip("rclpy") if os.environ.get("AMENT_PREFIX_PATH") else None

LOADED = 60.0  # s, what a busy machine may need to start a process


class Graph:
    """The test's node, and what it hears."""

    def __init__(self) -> None:
        from rclpy.context import Context
        from rclpy.executors import SingleThreadedExecutor

        from skin_models.ros.processes import Domain, Processes

        self.domain = Domain()
        os.environ.update(self.domain.environment())
        self.processes = Processes(self.domain.environment())
        self._context = Context()
        rclpy.init(context=self._context, domain_id=self.domain.id)
        self.node = rclpy.create_node("test", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)

    def driver(self, **parameters: Any):
        """Start a driver that runs ten times as fast as real, and wait until it is ready."""
        from skin_testbed_msgs.msg import DriverState

        process = self.processes.start("skin_testbed_driver", "driver_node", parameters={"time_scale": 10.0, **parameters})
        self.states = self.hear(DriverState, "driver_state", latched=True)
        self.wait(lambda: self.states or process.status is not None, "the driver")
        assert process.status is None, process.output()
        return process

    def hear(self, kind: type, topic: str, latched: bool = False) -> list:
        """All messages of a topic from now on."""
        from rclpy.qos import DurabilityPolicy, QoSProfile

        qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL) if latched else QoSProfile(depth=5000)
        heard: list = []
        self.node.create_subscription(kind, topic, heard.append, qos)
        return heard

    def wait(self, condition: Callable[[], Any], what: str, timeout: float = LOADED) -> Any:
        """Spin until `condition()`; fails after `timeout` s."""
        deadline = time.monotonic() + timeout
        while not (result := condition()):
            assert time.monotonic() < deadline, f"waited {timeout} s in vain for {what}"
            self._executor.spin_once(timeout_sec=0.05)
        return result

    def call(self, kind: type, name: str, request: Any = None) -> Any:
        """Call a service, and give its response."""
        client = self.node.create_client(kind, name)
        self.wait(client.service_is_ready, f"the service {name}")
        future = client.call_async(request or kind.Request())
        self.wait(future.done, f"an answer of {name}")
        return future.result()

    def command(self, *points: tuple[float, float, float], stamp: int = 0) -> None:
        """Command (time from now, or from `stamp` in s, depth, speed)."""
        from builtin_interfaces.msg import Duration
        from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

        if not hasattr(self, "_commands"):
            self._commands = self.node.create_publisher(JointTrajectory, "command", 10)
        self.wait(self._commands.get_subscription_count, "a driver that listens")
        message = JointTrajectory(joint_names=["indentation"])
        message.header.stamp.sec = stamp
        for t, x, v in points:
            when = Duration(sec=int(t), nanosec=int(1e9 * (t % 1.0)))
            message.points.append(JointTrajectoryPoint(positions=[x], velocities=[v], time_from_start=when))
        self._commands.publish(message)

    def state(self) -> int | None:
        """The driver's last state."""
        return self.states[-1].state if self.states else None

    def close(self) -> None:
        """End everything."""
        self.processes.end()
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self._context)
        self.domain.__exit__()


@pytest.fixture
def graph():
    if rclpy is None:
        pytest.skip("needs ROS")
    graph = Graph()
    yield graph
    graph.close()
