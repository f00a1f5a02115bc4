"""What the profile server knows of the driver: its latest samples, its state and limits, how fresh they are, and its command topic."""

import math
import threading
import time
from collections import deque
from dataclasses import dataclass

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.time import Time
from sensor_msgs.msg import JointState
from skin_testbed_msgs.msg import DriverState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from skin_models.ros.qos import LATCHED, LISTENING, overridable
from skin_motion_profiles.limits import Limits
from skin_motion_profiles.trajectory import Trajectory

JOINT = "indentation"
_REST_ERROR = 2e-5  # m, by how much a resting stage may miss its target
_TIMING = 0.2  # s of samples that are enough to determine the rate of the node's clock
# Every piece counts: a driver that stalls for a second must find them all, also those of force control at 100 Hz.
_COMMANDS = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)


@dataclass(frozen=True)
class Heard:
    """One value, the node time of its stamp (ns) and when it arrived (s, monotonic)."""

    value: float
    stamp: int
    arrival: float


class DriverLink:
    """Latest values are single attributes, replaced whole: other threads may read them at any time. `news` is set by every message."""

    def __init__(self, node: Node) -> None:
        """Subscribe and advertise on `node`."""
        self.news = threading.Event()
        self.depth: Heard | None = None
        self.force: Heard | None = None
        self.state: DriverState | None = None
        self.told: float | None = None  # m, last point of the last command
        self.forget_peaks()
        self._clock = node.get_clock()
        self._recent: deque[Heard] = deque(maxlen=1000)
        policies = overridable()
        subscribe = node.create_subscription
        subscribe(JointState, "encoder", self._on_encoder, LISTENING, qos_overriding_options=policies)
        subscribe(WrenchStamped, "force", self._on_force, LISTENING, qos_overriding_options=policies)
        subscribe(DriverState, "driver_state", self._on_state, LATCHED)
        self._commands = node.create_publisher(JointTrajectory, "command", _COMMANDS, qos_overriding_options=policies)

    def now(self) -> int:
        """Node time, ns."""
        return self._clock.now().nanoseconds

    @property
    def limits(self) -> Limits:
        """What the driver allows."""
        s = self.state
        return Limits(s.min_depth, s.max_depth, s.max_speed, s.max_acceleration)

    @property
    def rate(self) -> float:
        """Seconds of node time per second, from the stamps of the last encoder samples; at least 1."""
        first, last = self._recent[0], self._recent[-1]
        passed = last.arrival - first.arrival
        return max((last.stamp - first.stamp) * 1e-9 / passed, 1.0) if passed > 0.0 else 1.0

    @property
    def timed(self) -> bool:
        """Whether enough samples came to determine `rate`."""
        return len(self._recent) > 1 and self._recent[-1].arrival - self._recent[0].arrival >= _TIMING

    def silent(self, patience: float) -> list[str]:
        """The topics on which no number came for `patience` seconds."""
        late = time.monotonic() - patience
        return [name for name, heard in (("encoder", self.depth), ("force", self.force)) if heard is None or heard.arrival < late]

    @property
    def heeded(self) -> bool:
        """Whether a driver listens to commands: a piece sent before it does is lost."""
        return self._commands.get_subscription_count() > 0

    @property
    def standing(self) -> float:
        """Where the next motion begins, m: where the last one was told to end, if the plunger rests there; else where it is measured.

        The driver goes on from what it was told, and a stage rests a few micrometres beside that.
        """
        near = self.told is not None and abs(self.told - self.depth.value) < _REST_ERROR
        return self.told if near else self.depth.value

    def mark(self) -> int:
        """A node time (ns) later than the stamp of any sample taken before this moment, even where /clock comes a sample late."""
        period = 1e9 / (self.state.sample_rate if self.state.sample_rate > 0.0 else 100.0)
        return max(self.now(), self.depth.stamp, self.force.stamp) + int(1.5 * period)

    def heard_since(self, mark: int) -> bool:
        """Whether encoder and load cell are known as they were after a `mark`."""
        return min(self.depth.stamp, self.force.stamp) > mark

    def forget_peaks(self) -> None:
        """Begin to look for the greatest compression (N), load of either sign (N) and depth (m) anew."""
        self.peak_force = self.peak_depth = -math.inf
        self.peak_load = 0.0

    def send(self, base: int, trajectory: Trajectory, times: np.ndarray) -> None:
        """Publish the states at `times` (s) of a trajectory that starts at node time `base` (ns)."""
        s = trajectory.sample(times)
        message = JointTrajectory(joint_names=[JOINT])
        message.header.stamp = Time(nanoseconds=base).to_msg()
        message.points = [_point(*knot) for knot in zip(times.tolist(), s.x.tolist(), s.v.tolist(), s.a.tolist(), strict=True)]
        self._commands.publish(message)
        self.told = float(s.x[-1])

    def _on_encoder(self, message: JointState) -> None:
        value = dict(zip(message.name, message.position, strict=False)).get(JOINT)
        if value is None:  # a message may name joints and hold no positions
            return
        if math.isfinite(value):  # NaN is how the driver says that it does not know
            self.depth = Heard(value, _nanoseconds(message), time.monotonic())
            self.peak_depth = max(self.peak_depth, value)
            self._recent.append(self.depth)
        self.news.set()

    def _on_force(self, message: WrenchStamped) -> None:
        value = -message.wrench.force.z
        if math.isfinite(value):
            self.force = Heard(value, _nanoseconds(message), time.monotonic())
            self.peak_force, self.peak_load = max(self.peak_force, value), max(self.peak_load, abs(value))
        self.news.set()

    def _on_state(self, message: DriverState) -> None:
        self.state = message
        self.news.set()


def _nanoseconds(message: JointState | WrenchStamped) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def _point(t: float, x: float, v: float, a: float) -> JointTrajectoryPoint:
    ns = round(t * 1e9)
    when = Duration(sec=ns // 10**9, nanosec=ns % 10**9)
    return JointTrajectoryPoint(positions=[x], velocities=[v], accelerations=[a], time_from_start=when)
