"""Samples as messages. The messages are made once and filled again: publishing copies them."""

import math
from array import array

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Vector3, WrenchStamped
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import DurabilityPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from skin_testbed_driver.rig import Layout
from skin_testbed_driver.ros.driver_settings import DriverSettings
from skin_testbed_driver.safety import Limits
from skin_testbed_driver.sensing import Sample
from skin_testbed_driver.testbed import Status
from skin_testbed_msgs.msg import DriverState, TaxelArray, TaxelLayout

JOINT = "indentation"

# Latched topics keep their last message for whoever comes later.
LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def stream_qos(sample_rate: float) -> QoSProfile:
    """QoS of the sensor streams: reliable, so that reliable and best-effort subscribers both match, and one second deep.

    A subscriber that stalls loses stall x rate - depth samples: with a second of depth on both sides, a stall of a second loses nothing.
    """
    return QoSProfile(depth=max(int(sample_rate), 10), reliability=ReliabilityPolicy.RELIABLE)


def overridable() -> QoSOverridingOptions:
    """Let parameters `qos_overrides.<topic>.publisher.*` change history, depth, reliability and durability."""
    kinds = (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY, QoSPolicyKind.DURABILITY)
    return QoSOverridingOptions(kinds)


class Publishing:
    """The publishers of the driver."""

    def __init__(self, node: LifecycleNode, settings: DriverSettings, layout: Layout, truth: bool) -> None:
        """Create the publishers. `truth`: also publish what only a simulation knows."""
        qos = stream_qos(settings.sample_rate)

        def stream(kind: type, topic: str):
            return node.create_lifecycle_publisher(kind, topic, qos, qos_overriding_options=overridable())

        self._publishers = [stream(JointState, "encoder"), stream(WrenchStamped, "force"), stream(TaxelArray, "taxels")]
        self._encoder, self._force, self._taxels = self._publishers
        self._truth = stream(TaxelArray, "taxels_truth") if truth else None
        self._layout = node.create_publisher(TaxelLayout, "taxel_layout", LATCHED)
        self._clock = node.create_publisher(Clock, "/clock", 10) if settings.time_scale != 1.0 else None
        self._frame = settings.skin_frame
        self._messages(settings)
        self._node, self._place = node, layout

    def _messages(self, settings: DriverSettings) -> None:
        self._encoder_message, self._force_message = JointState(name=[JOINT]), WrenchStamped()
        self._force_message.header.frame_id = settings.force_frame
        self._taxels_message, self._truth_message = TaxelArray(), TaxelArray()
        self._taxels_message.header.frame_id = self._truth_message.header.frame_id = settings.skin_frame

    def sample(self, s: Sample, stamp: Time) -> None:
        """Publish one sample; all its messages bear the same stamp."""
        if self._clock is not None:
            self._clock.publish(Clock(clock=stamp))
        message = self._encoder_message
        message.header.stamp = stamp
        message.position, message.velocity = array("d", (s.depth,)), array("d", (s.speed,))
        self._encoder.publish(message)
        message = self._force_message
        message.header.stamp = stamp
        message.wrench.force.z = -s.force  # compression pushes the load cell along its -z
        self._force.publish(message)
        message = self._taxels_message
        message.header.stamp = stamp
        message.force, message.voltage = floats(s.taxel_force), floats(s.taxel_voltage)
        message.status = array("B", s.taxel_status.tobytes())
        self._taxels.publish(message)
        if self._truth is not None:
            self._publish_truth(s, stamp)

    def _publish_truth(self, s: Sample, stamp: Time) -> None:
        message = self._truth_message
        message.header.stamp = stamp
        truth = s.taxels_truth if s.taxels_truth is not None else np.full(s.taxel_force.size, math.nan)
        message.force, message.status = floats(truth), array("B", bytes(truth.size))
        self._truth.publish(message)

    def layout(self, stamp: Time) -> None:
        """Publish where the taxels are."""
        place = self._place
        message = TaxelLayout(names=list(place.names), area=floats(place.area))
        message.header.stamp, message.header.frame_id = stamp, self._frame
        message.positions = [Point(x=x, y=y, z=z) for x, y, z in place.positions.tolist()]
        message.normals = [Vector3(x=x, y=y, z=z) for x, y, z in place.normals.tolist()]
        self._layout.publish(message)

    def destroy(self) -> None:
        """Take the publishers away."""
        for publisher in (*self._publishers, *([self._truth] if self._truth else [])):
            self._node.destroy_lifecycle_publisher(publisher)
        for publisher in (self._layout, self._clock):
            if publisher is not None:
                self._node.destroy_publisher(publisher)


def state_message(status: Status | None, limits: Limits, sample_rate: float, stamp: Time) -> DriverState:
    """What the driver is doing; None: it is not active."""
    message = DriverState(sample_rate=sample_rate, state=DriverState.INACTIVE)
    message.header.stamp = stamp
    if status is not None:
        message.state, message.reason = status.activity.value, status.reason
        message.zeroed, message.tared = status.zeroed, status.tared
    for name in ("min_depth", "max_depth", "max_speed", "max_acceleration", "max_force", "retracted_depth"):
        setattr(message, name, getattr(limits, name))
    return message


def floats(values: np.ndarray) -> array:
    """An array of numbers as rclpy takes it at once, without a look at every element."""
    return array("d", np.ascontiguousarray(values, float).tobytes())
