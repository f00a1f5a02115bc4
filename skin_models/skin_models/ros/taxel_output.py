"""Taxels as messages. Arrays are handed over as `array.array`, which rclpy copies whole: no Python object per taxel."""

from array import array

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Vector3, WrenchStamped
from rclpy.node import Node
from skin_testbed_msgs.msg import TaxelArray, TaxelLayout

from skin_models.layout import Layout, arbitrary
from skin_models.ros.qos import LATCHED, overridable, stream


class TaxelOutput:
    """Publishes `taxels`, `taxels_truth`, `taxel_layout`, and `force` for a skin that is driven by an encoder."""

    def __init__(self, node: Node, rate: float, skin_frame: str, force_frame: str = "") -> None:
        """`force_frame`: publish `force`, in that frame."""

        def publisher(kind: type, topic: str):
            return node.create_publisher(kind, topic, stream(rate), qos_overriding_options=overridable())

        self._taxels, self._truth = publisher(TaxelArray, "taxels"), publisher(TaxelArray, "taxels_truth")
        self._layout = node.create_publisher(TaxelLayout, "taxel_layout", LATCHED)
        self._force = publisher(WrenchStamped, "force") if force_frame else None
        self._message, self._force_message, self._frame = TaxelArray(), WrenchStamped(), skin_frame
        self._message.header.frame_id, self._force_message.header.frame_id = skin_frame, force_frame

    def sample(self, stamp: Time, taxels: np.ndarray, truth: np.ndarray, stale: bool = False) -> None:
        """Readings and truth, N, of one instant. A reading that is NaN, and all while contacts are stale, are marked so."""
        message = self._message
        message.header.stamp = stamp
        status = np.where(np.isfinite(taxels) & (not stale), TaxelArray.OK, TaxelArray.STALE).astype(np.uint8)
        message.force, message.status = floats(taxels), array("B", status.tobytes())
        self._taxels.publish(message)
        message.force = floats(truth)
        self._truth.publish(message)

    def force(self, stamp: Time, force: float) -> None:
        """The applied force, N, compression positive; published as force.z = -compression."""
        self._force_message.header.stamp = stamp
        self._force_message.wrench.force.z = -float(force)
        self._force.publish(self._force_message)

    def layout(self, layout: Layout, stamp: Time) -> None:
        """Where the taxels are."""
        self._layout.publish(layout_message(layout, self._frame, stamp))


def layout_message(layout: Layout, frame: str, stamp: Time) -> TaxelLayout:
    """Where the taxels are, as a message."""
    message = TaxelLayout(names=list(layout.names), area=floats(layout.area))
    message.header.stamp, message.header.frame_id = stamp, frame
    message.positions = [Point(x=x, y=y, z=z) for x, y, z in layout.positions.tolist()]
    message.normals = [Vector3(x=x, y=y, z=z) for x, y, z in layout.normals.tolist()]
    return message


def layout_of(message: TaxelLayout) -> Layout:
    """The layout in a message. Raises `LayoutError` for one that cannot be used."""
    positions, normals = ([(p.x, p.y, p.z) for p in points] for points in (message.positions, message.normals))
    return arbitrary(np.array(positions), np.array(normals), np.array(message.area), tuple(message.names))


def floats(values: np.ndarray) -> array:
    """A float64[] field from an array."""
    return array("d", np.ascontiguousarray(values, np.float64).tobytes())
