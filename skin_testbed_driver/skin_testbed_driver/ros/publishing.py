"""Samples as messages, which are serialised once and filled again."""

import numpy as np
import yaml
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PointStamped, WrenchStamped
from rclpy.lifecycle import LifecycleNode
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from skin_testbed_msgs.msg import DriverState, TaxelArray, TaxelLayout
from std_msgs.msg import String

from skin_models.ros.qos import LATCHED, overridable, stream
from skin_models.ros.taxel_output import layout_message
from skin_testbed_driver.calibration import Calibration
from skin_testbed_driver.rig import Rig
from skin_testbed_driver.ros import JOINT
from skin_testbed_driver.ros.driver_settings import DriverSettings
from skin_testbed_driver.ros.packed import Packed
from skin_testbed_driver.safety import Limits
from skin_testbed_driver.sensing import Sample
from skin_testbed_driver.testbed import Status

_KEPT = 5.0  # s of real time
_MOST = 20000  # samples
_SELDOM = 0.1  # s, between two messages on stage_position
_LOOKS = 5  # as many of those between two looks for a subscriber to the truth: each asks the whole graph


class Publishing:
    """The publishers of the driver."""

    def __init__(self, node: LifecycleNode, settings: DriverSettings, rig: Rig, calibration: Calibration) -> None:
        """Create the publishers; a simulation also tells the truth."""
        # What is not yet acknowledged is kept for five seconds: so long may the receiving threads of a busy machine stall.
        qos = stream(min(_KEPT * settings.sample_rate * settings.time_scale, _MOST))

        def publisher(kind: type, topic: str):
            return node.create_lifecycle_publisher(kind, topic, qos, qos_overriding_options=overridable())

        self._streams = [publisher(JointState, "encoder"), publisher(WrenchStamped, "force"), publisher(TaxelArray, "taxels")]
        self._truth = publisher(TaxelArray, "taxels_truth") if rig.owns_time and rig.moves else None
        # What `publish` does with bytes, without its checks of type and lifecycle: there are samples only while the node is active.
        self._send = [p.handle.publish_raw for p in self._streams]
        self._send_truth = self._truth.handle.publish_raw if self._truth else None
        self._truth_heard = False
        self._layout = node.create_publisher(TaxelLayout, "taxel_layout", LATCHED)
        self._texts = {name: node.create_publisher(String, name, LATCHED) for name in ("rig_description", "calibration")}
        self._stage = node.create_publisher(PointStamped, "stage_position", 10) if rig.placed() else None
        self._clock = node.create_publisher(Clock, "/clock", 10) if settings.time_scale != 1.0 else None
        self._node, self._rig, self._calibration, self._settings = node, rig, calibration, settings
        self._seldom, self._ticks = max(round(settings.sample_rate * _SELDOM), 1), 0
        self._messages(settings)

    def _messages(self, settings: DriverSettings) -> None:
        count = len(self._rig.layout)
        zeros = {"force": [0.0] * count, "status": [0] * count}
        encoder, force = JointState(name=[JOINT], position=[0.0], velocity=[0.0]), WrenchStamped()
        volts, plain = TaxelArray(**zeros, voltage=[0.0] * count), TaxelArray(**zeros)
        force.header.frame_id = settings.force_frame
        volts.header.frame_id = plain.header.frame_id = settings.skin_frame
        self._encoder_bytes = Packed(encoder, "position", "velocity", behind=4)  # the length of no efforts
        self._force_bytes = Packed(force, "wrench.force.z", behind=24)  # the torque
        # By the number of voltages: a rig that measures force has none.
        self._taxels_bytes = {0: Packed(plain, "force", "voltage", "status"), count: Packed(volts, "force", "voltage", "status")}
        stage = PointStamped()
        stage.header.frame_id = settings.skin_frame
        self._stage_bytes = Packed(stage, "point.x", "point.y", behind=8)  # the height
        self._truth_bytes, self._unknown = Packed(plain, "force", "status"), np.full(count, np.nan)

    def sample(self, s: Sample, stamp: tuple[int, int]) -> None:
        """Publish one sample; all its messages bear the same stamp (s, ns)."""
        if self._clock is not None:
            self._clock.publish(Clock(clock=Time(sec=stamp[0], nanosec=stamp[1])))
        send_encoder, send_force, send_taxels = self._send
        send_encoder(self._encoder_bytes.with_stamp(stamp).set_number("position", s.depth).set_number("velocity", s.speed).data())
        # Compression pushes the load cell along its -z.
        send_force(self._force_bytes.with_stamp(stamp).set_number("wrench.force.z", -s.force).data())
        taxels = self._taxels_bytes[s.taxel_voltage.size].with_stamp(stamp).set("force", s.taxel_force)
        send_taxels(taxels.set("voltage", s.taxel_voltage).set("status", s.taxel_status).data())
        if self._truth_heard:
            truth = s.taxels_truth if s.taxels_truth is not None else self._unknown
            self._send_truth(self._truth_bytes.with_stamp(stamp).set("force", truth).data())

    def seldom(self, stamp: tuple[int, int]) -> None:
        """Ten times a second: publish which point of the skin is under the plunger, if known, and now and then see whether anybody hears
        the truth."""
        self._ticks += 1
        if self._ticks % self._seldom:
            return
        if self._truth is not None and self._ticks // self._seldom % _LOOKS == 0:
            self._truth_heard = self._truth.get_subscription_count() > 0
        if self._stage is not None:
            x, y = self._rig.placed()
            self._stage.publish(self._stage_bytes.with_stamp(stamp).set_number("point.x", x).set_number("point.y", y).data())

    def describe(self, stamp: Time) -> None:
        """Publish once what does not change: where the taxels are, the rig's facts, the calibration in use."""
        place, settings = self._rig.layout, self._settings
        self._layout.publish(layout_message(place, settings.skin_frame, stamp))
        positions = (1e3 * place.positions[:, :2]).round(6).tolist()
        facts = {"sample_rate_hz": settings.sample_rate, **self._rig.facts(), "taxel_positions_mm": positions}
        for name, content in (("rig_description", facts), ("calibration", self._calibration.as_dict(place.names))):
            self._texts[name].publish(String(data=yaml.safe_dump(content, sort_keys=False)))

    def others(self) -> str:
        """The names of other nodes that publish on the topic of the encoder, or on /clock where this one does; empty without any."""
        topics = [self._streams[0].topic_name, *([self._clock.topic_name] if self._clock else [])]
        return ", ".join(sorted({name for topic in topics for name in self._others_on(topic)}))

    def _others_on(self, topic: str) -> list[str]:
        if self._node.count_publishers(topic) < 2:
            return []
        infos = self._node.get_publishers_info_by_topic(topic)
        names = [f"{info.node_namespace.rstrip('/')}/{info.node_name}" for info in infos]
        mine = self._node.get_fully_qualified_name()
        if mine in names:
            names.remove(mine)
        return names

    def destroy(self) -> None:
        """Take the publishers away."""
        for publisher in (*self._streams, *([self._truth] if self._truth else [])):
            self._node.destroy_lifecycle_publisher(publisher)
        for publisher in (self._layout, self._stage, self._clock, *self._texts.values()):
            if publisher is not None:
                self._node.destroy_publisher(publisher)


def state_message(status: Status | None, limits: Limits, sample_rate: float, stamp: Time) -> DriverState:
    """What the driver is doing; None: it is not active."""
    message = DriverState(sample_rate=sample_rate, state=DriverState.INACTIVE)
    message.header.stamp = stamp
    if status is not None:
        message.state, message.reason = status.activity.value, status.reason
        message.zeroed, message.tared = status.zeroed, status.tared
        message.zero_count, message.tare_count = status.zero_count, status.tare_count
    for name in ("min_depth", "max_depth", "max_speed", "max_acceleration", "max_force", "retracted_depth"):
        setattr(message, name, getattr(limits, name))
    return message
