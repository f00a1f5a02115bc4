"""A rig reached over existing ROS drivers: any axis that reports JointState and takes JointTrajectory or Float64MultiArray (ros2_control
and others), any WrenchStamped sensor, any taxels. Names are remapped as usual:

    axis_state    sensor_msgs/JointState            in
    axis_command  trajectory_msgs/JointTrajectory   out, or std_msgs/Float64MultiArray
    force_in      geometry_msgs/WrenchStamped       in
    taxels_in     skin_testbed_msgs/TaxelArray, or std_msgs/Float64MultiArray (N)   in

A signal that has been silent for `stale_after` is NaN: the driver then stops. Time is that of arrival, because the clocks of others are
not ours.

A JointTrajectory has one point, one sample ahead, and no speed: joint_trajectory_controller of Jazzy refuses a trajectory that ends with
speed (allow_nonzero_velocity_at_trajectory_end is false by default), and goes in a straight line to a point without speed. Where the
controller allows speed there, set `axis_speeds`. When the driver falls silent the axis stays at its last point.
"""

import math
import time
from array import array
from dataclasses import dataclass

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from skin_testbed_msgs.msg import TaxelArray
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from skin_models.layout import Layout
from skin_models.words import counted
from skin_testbed_driver.rig import Reading, Rig

# Only the newest matters, from reliable and best-effort publishers alike.
_NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


@dataclass(frozen=True)
class TopicsSettings:
    """Which joint, which way it counts (+1: towards the skin), the sign that makes compression positive, which message types."""

    joint: str
    axis_sign: float
    force_sign: float
    stale_after: float  # s
    command_type: str
    taxels_type: str
    speeds: bool = False  # say with what speed to be there


class TopicsRig(Rig):
    """See the module's docstring. Callbacks replace whole attributes; the sampling thread reads them."""

    travel = (-math.inf, math.inf)

    def __init__(self, node: Node, settings: TopicsSettings, layout: Layout) -> None:
        """Subscribe and advertise on `node`."""
        self.layout, self._node, self._settings = layout, node, settings
        self._position = self._force = self._taxels = (math.nan, -math.inf)  # value, arrival (monotonic s)
        taxels = TaxelArray if settings.taxels_type == "TaxelArray" else Float64MultiArray
        command = JointTrajectory if settings.command_type == "JointTrajectory" else Float64MultiArray
        self._endpoints = [
            node.create_subscription(JointState, "axis_state", self._on_state, _NEWEST),
            node.create_subscription(WrenchStamped, "force_in", self._on_force, _NEWEST),
            node.create_subscription(taxels, "taxels_in", self._on_taxels, _NEWEST),
        ]
        self._commands = node.create_publisher(command, "axis_command", QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE))

    def open(self, sample_rate: float) -> None:
        """`sample_rate` (Hz) says when each commanded position is to be reached."""
        period = round(1e9 / sample_rate)
        self._period = Duration(sec=period // 10**9, nanosec=period % 10**9)
        self._halted = False

    def read(self) -> Reading:
        """The newest message of each topic, m and N with our signs; NaN for one older than `stale_after`."""
        late = time.monotonic() - self._settings.stale_after
        count = len(self.layout)
        taxels = self._fresh(self._taxels, late, np.full(count, math.nan))
        return Reading(
            position=self._fresh(self._position, late, math.nan),
            force=self._fresh(self._force, late, math.nan),
            taxel_force=taxels if np.size(taxels) == count else np.full(count, math.nan),
        )

    def command(self, position: float, velocity: float) -> None:
        """Publish one point: `position` (m) and, if asked for, `velocity` (m/s), one period from now."""
        self._halted = False
        sign = self._settings.axis_sign
        if self._settings.command_type == "JointTrajectory":
            speeds = [sign * velocity] if self._settings.speeds else []
            point = JointTrajectoryPoint(positions=[sign * position], velocities=speeds, time_from_start=self._period)
            self._commands.publish(JointTrajectory(joint_names=[self._settings.joint], points=[point]))
        else:
            self._commands.publish(Float64MultiArray(data=array("d", (sign * position,))))

    def halt(self) -> None:
        """Say nothing more; controllers from before Jazzy are also told to hold, by an empty trajectory, which newer ones discard."""
        if not self._halted and self._settings.command_type == "JointTrajectory":
            self._commands.publish(JointTrajectory(joint_names=[self._settings.joint]))
        self._halted = True

    def close(self) -> None:
        """Take the topics away."""
        for subscription in self._endpoints:
            self._node.destroy_subscription(subscription)
        self._node.destroy_publisher(self._commands)

    @staticmethod
    def _fresh(heard: tuple, late: float, otherwise):
        value, arrival = heard
        return value if arrival > late else otherwise

    def _on_state(self, message: JointState) -> None:
        if self._settings.joint in message.name:
            position = message.position[message.name.index(self._settings.joint)]
            self._position = (self._settings.axis_sign * position, time.monotonic())
        elif self._position[1] == -math.inf:  # others may publish other joints on the same topic
            there = ", ".join(message.name) or "no joint"
            self._wonder(f"axis_state tells of {there}, not of {self._settings.joint}: set the parameter joint")

    def _on_force(self, message: WrenchStamped) -> None:
        self._force = (self._settings.force_sign * message.wrench.force.z, time.monotonic())

    def _on_taxels(self, message: TaxelArray | Float64MultiArray) -> None:
        values = message.force if isinstance(message, TaxelArray) else message.data
        self._taxels = (np.array(values), time.monotonic())
        if len(values) != len(self.layout):
            there, wanted = counted(len(values), "value"), counted(len(self.layout), "taxel")
            self._wonder(f"taxels_in has {there} for {wanted}: set the parameter taxels, or layout_file")

    def _wonder(self, sentence: str) -> None:
        self._node.get_logger().warning(sentence, throttle_duration_sec=10.0)
