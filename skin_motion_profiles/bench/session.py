"""The installed driver and profile server as processes, and a client that executes goals and keeps what the sensors said."""

import os
import time
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import PointStamped, WrenchStamped
from rclpy.action import ActionClient
from rclpy.experimental import EventsExecutor
from sensor_msgs.msg import JointState
from skin_testbed_msgs.action import ExecuteProfile

from skin_models.ros.processes import Domain, Processes, wait_until
from skin_models.ros.qos import stream

_KEPT = stream(20000.0)  # reliable, and deep: what a busy machine hands over late is still all there


class Session:
    """A simulated rig, ready for goals. Use as a context."""

    def __init__(self, driver: dict[str, Any] | None = None, server: dict[str, Any] | None = None) -> None:
        self.domain = Domain()
        self.processes = Processes(self.domain.environment())
        self.processes.start("skin_testbed_driver", "driver_node", parameters=driver)
        self.server = self.processes.start("skin_motion_profiles", "profile_server", parameters=server)
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=self.domain.id)
        self.node = rclpy.create_node("client", context=self.context)
        self.executor = EventsExecutor(context=self.context)  # in order of arrival, and three times as fast as the default
        self.executor.add_node(self.node)
        self.client = ActionClient(self.node, ExecuteProfile, "execute_profile")
        self.encoder: list[tuple[float, float]] = []
        self.force: list[tuple[float, float]] = []
        self.feedback: list[tuple[float, ExecuteProfile.Feedback]] = []  # with the time (s) of its arrival
        self.place: list[tuple[float, float]] = []  # x of the point under the plunger (m)
        self.node.create_subscription(PointStamped, "stage_position", lambda m: self.place.append((_time(m), m.point.x)), 10)
        self.node.create_subscription(JointState, "encoder", lambda m: self.encoder.append((_time(m), m.position[0])), _KEPT)
        self.node.create_subscription(WrenchStamped, "force", lambda m: self.force.append((_time(m), -m.wrench.force.z)), _KEPT)
        self.until(lambda: self.client.server_is_ready() and self.encoder, "driver and server")

    def execute(self, profile: str, **goal: Any) -> tuple[ExecuteProfile.Result, np.ndarray, np.ndarray]:
        """Execute a profile; returns the result, and (N, 2) times (s) with depths (m), and with forces (N)."""
        result = self.end(self.begin(profile, **goal))
        return result, np.array(self.encoder), np.array(self.force)

    def begin(self, profile: str, **goal: Any) -> Any:
        """Give a goal; returns its handle."""
        self.encoder.clear()
        self.force.clear()
        self.feedback.clear()
        sent = self.client.send_goal_async(ExecuteProfile.Goal(profile=profile, **goal), feedback_callback=self._on_feedback)
        self.until(sent.done, "acceptance")
        self.until(lambda: self.encoder and self.force, "samples")
        return sent.result()

    def cancel(self, goal: Any) -> ExecuteProfile.Result:
        """Cancel a goal and wait for its end."""
        goal.cancel_goal_async()
        return self.end(goal)

    def end(self, goal: Any) -> ExecuteProfile.Result:
        """Wait for the end of a goal."""
        ended = goal.get_result_async()
        self.until(ended.done, "the end of the goal", 300.0)
        result = ended.result().result
        over, soon = seconds(result.started) + result.duration, time.monotonic() + 0.1  # the last samples are still on their way
        self.until(lambda: time.monotonic() > soon and min(self.encoder[-1][0], self.force[-1][0]) > over, "samples")
        return result

    def server_cpu(self) -> float:
        """Processor time that the profile server has used, s."""
        user, system = Path(f"/proc/{self.server.pid}/stat").read_text().rpartition(")")[2].split()[11:13]
        return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")

    def _on_feedback(self, message: Any) -> None:
        self.feedback.append((time.time(), message.feedback))

    def until(self, condition: Any, what: str, timeout: float = 30.0) -> None:
        """Spin until it is true. Raises `SkinError` after `timeout` s."""

        def check() -> bool:
            self.executor.spin_once(timeout_sec=0.02)
            return bool(condition())

        wait_until(check, timeout, what, period=0.0)

    def __enter__(self) -> "Session":
        return self

    def __exit__(self, *_: object) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)
        self.processes.end()
        self.domain.__exit__()


def seconds(stamp: Any) -> float:
    """A stamp in s."""
    return stamp.sec + 1e-9 * stamp.nanosec


def _time(message: Any) -> float:
    return seconds(message.header.stamp)
