"""A profile server with a driver of a spring, each a process of its own, and a client that speaks to both over DDS."""

import math
import sys
import time
from pathlib import Path

import rclpy
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import JointState
from skin_testbed_msgs.action import ExecuteProfile
from std_msgs.msg import String
from trajectory_msgs.msg import JointTrajectory

from skin_models.ros.processes import Domain, Process, Processes, wait_until
from skin_models.ros.qos import LISTENING

# Quick moves, and patience with a machine that has other things to do.
QUICK = {"approach_speed": 0.02, "approach_acceleration": 0.5, "retract_speed": 0.02, "feedback_timeout": 2.0}
WAIT = 30.0  # s, for anything that ought to happen at once


class Bench:
    """Start it, give it goals, break its driver."""

    def __init__(self, scale: float = 1.0, driver: bool = True, parameters: dict | None = None) -> None:
        self.domain = Domain()
        self.processes = Processes(self.domain.environment())
        self.driver = self.start_driver(scale) if driver else None
        use_sim_time = {"use_sim_time": True} if scale != 1.0 else {}
        settings = {**QUICK, **use_sim_time, **(parameters or {})}
        self.server = self.processes.start("skin_motion_profiles", "profile_server", parameters=settings)
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=self.domain.id)
        self.node = rclpy.create_node("client", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.breaker = self.node.create_publisher(String, "break", 10)
        self.client = ActionClient(self.node, ExecuteProfile, "execute_profile")
        self.feedback: list[ExecuteProfile.Feedback] = []
        self.depths: list[tuple[float, float]] = []
        self.node.create_subscription(JointState, "encoder", self._on_encoder, LISTENING)
        self.commands: list[JointTrajectory] = []
        self.node.create_subscription(JointTrajectory, "command", self.commands.append, 50)
        self.until(self.client.server_is_ready, "the profile server")
        if driver:
            self.until(lambda: self.depths and self.breaker.get_subscription_count(), "the driver")

    def start_driver(self, scale: float = 1.0) -> Process:
        command = [sys.executable, str(Path(__file__).with_name("fake_driver.py")), "--scale", str(scale)]
        process = Process(command, self.domain.environment(), "fake driver")
        self.processes.running.append(process)
        return process

    def _on_encoder(self, message: JointState) -> None:
        stamp = message.header.stamp
        if message.name == ["indentation"] and message.position:
            self.depths.append((stamp.sec + 1e-9 * stamp.nanosec, message.position[0]))

    @property
    def depth(self) -> float:
        return self.depths[-1][1]

    def until(self, condition, what: str, timeout: float = WAIT):
        def check():
            self.executor.spin_once(timeout_sec=0.01)
            return condition()

        return wait_until(check, timeout, what, period=0.0)

    def spin(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() > end, "time to pass")

    def give(self, profile: str, max_force: float = 0.0, hold: bool = False):
        """Send a goal; returns its handle."""
        self.feedback.clear()
        goal = ExecuteProfile.Goal(profile=profile, max_force=max_force, on_stop=int(hold))
        future = self.client.send_goal_async(goal, feedback_callback=lambda m: self.feedback.append(m.feedback))
        self.until(future.done, "acceptance")
        assert future.result().accepted
        return future.result()

    def end(self, handle, timeout: float = WAIT):
        """Wait for the end of a goal; returns status and result."""
        future = handle.get_result_async()
        self.until(future.done, "the end of the goal", timeout)
        self.spin(0.05)  # the last samples are still on their way
        return future.result().status, future.result().result

    def run(self, profile: str, **more):
        """Execute a goal; returns its result."""
        return self.end(self.give(profile, **more))[1]

    def wait(self, process: Process, timeout: float = WAIT) -> int:
        """Wait for the end of a process, and keep listening: what waits in a queue meanwhile would later pass for the present."""
        self.until(lambda: process.status is not None, f"the end of {process.label}", timeout)
        return process.status

    def moving(self, depth: float = 0.0) -> None:
        """Wait until the plunger is deeper than `depth` (m)."""
        self.until(lambda: self.depths and self.depth > depth, "motion")

    def make_it(self, fault: str) -> None:
        self.breaker.publish(String(data=fault))

    def mend(self) -> None:
        """Repair the driver and go back up."""
        self.make_it("mend")
        self.spin(0.2)
        result = self.run("{type: straight_line, to_mm: -2, speed_mm_s: 20, acceleration_mm_s2: 400}")
        assert result.error_code == ExecuteProfile.Result.SUCCESS, result.error_string
        assert math.isclose(self.depth, -0.002, abs_tol=1e-5)

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)
        self.processes.end()
        self.domain.__exit__()
