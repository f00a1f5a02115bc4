"""Taxels to look at: markers for RViz, a heat map for any image view, a point cloud. Made only while someone subscribes.

Colour: dark blue is nothing, over green to yellow for `full` (N) and more; a reading that is NaN is grey.
"""

from array import array
from dataclasses import dataclass

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import Image, PointCloud2, PointField
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from skin_models.layout import Layout

_STOPS = np.array([[0.07, 0.09, 0.25], [0.13, 0.35, 0.55], [0.13, 0.57, 0.55], [0.37, 0.79, 0.38], [0.99, 0.91, 0.15]])
_GREY = np.array([0.5, 0.5, 0.5])
_SIDE = 128  # pixels along the longer side of the heat map
_CLOUD = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("force", "<f4")])


def colours(force: np.ndarray, full: float) -> np.ndarray:
    """RGB in [0, 1], shape (..., 3), of forces (N)."""
    level = np.clip(np.nan_to_num(force / full), 0.0, 1.0)
    rgb = np.stack([np.interp(level, np.linspace(0, 1, len(_STOPS)), channel) for channel in _STOPS.T], axis=-1)
    return np.where(np.isnan(force)[..., None], _GREY, rgb)


@dataclass(frozen=True, eq=False)
class HeatMap:
    """Which taxel every pixel shows, (H, W), seen against the mean normal; -1 for pixels farther than a pitch from any taxel."""

    taxel: np.ndarray

    def rgb(self, force: np.ndarray, full: float) -> np.ndarray:
        """The picture, (H, W, 3) of uint8; background white."""
        picture = np.where(self.taxel[..., None] >= 0, colours(force, full)[self.taxel], 1.0)
        return (255.0 * picture + 0.5).astype(np.uint8)


def heat_map(layout: Layout) -> HeatMap:
    """Nearest-taxel picture of a layout, projected onto the plane across its mean normal, x to the right, y up."""
    from scipy.spatial import cKDTree

    from skin_models.spread.field import tangent

    mean = layout.normals.mean(axis=0)
    u, v = tangent(mean / np.linalg.norm(mean) if np.linalg.norm(mean) > 1e-6 else np.array([0.0, 0.0, 1.0]))
    flat = np.column_stack([layout.positions @ u, layout.positions @ v])
    margin = 0.7 * (layout.pitch if np.isfinite(layout.pitch) else 2.0 * np.sqrt(layout.area[0] / np.pi))
    low, high = flat.min(axis=0) - margin, flat.max(axis=0) + margin
    step = (high - low).max() / _SIDE
    x, y = (np.arange(low[i] + step / 2, high[i], step) for i in (0, 1))
    grid = np.stack(np.meshgrid(x, y[::-1]), axis=-1)
    distance, taxel = cKDTree(flat).query(grid)
    return HeatMap(np.where(distance <= margin * 1.05, taxel, -1))


class Viewing:
    """Publishes `markers`, `heat_map` and `points`."""

    def __init__(self, node: Node, layout: Layout, frame: str) -> None:
        """Advertise on `node`; all that is published is given in `frame`."""
        qos = QoSProfile(depth=1)
        self._markers = node.create_publisher(MarkerArray, "markers", qos)
        self._image = node.create_publisher(Image, "heat_map", qos)
        self._cloud = node.create_publisher(PointCloud2, "points", qos)
        self._frame = frame
        self.show(layout)

    def show(self, layout: Layout) -> None:
        """Draw another layout from now on."""
        self._layout, self._map, self._marker = layout, heat_map(layout), self._spheres(layout)

    def publish(self, stamp: Time, force: np.ndarray, full: float) -> None:
        """Show forces (T,), N."""
        if self._markers.get_subscription_count():
            self._publish_markers(stamp, force, full)
        if self._image.get_subscription_count():
            self._image.publish(self._picture(stamp, force, full))
        if self._cloud.get_subscription_count():
            self._cloud.publish(self._points(stamp, force))

    def _spheres(self, layout: Layout) -> Marker:
        """One sphere list for all taxels: a marker per taxel would be thousands of messages."""
        marker = Marker(ns="taxels", type=Marker.SPHERE_LIST, action=Marker.ADD)
        marker.header.frame_id = self._frame
        marker.pose.orientation.w = 1.0
        size = float(np.sqrt(np.median(layout.area) * 4.0 / np.pi)) * 0.9
        marker.scale.x = marker.scale.y = marker.scale.z = size
        marker.points = [Point(x=x, y=y, z=z) for x, y, z in layout.positions.tolist()]
        return marker

    def _publish_markers(self, stamp: Time, force: np.ndarray, full: float) -> None:
        self._marker.header.stamp = stamp
        self._marker.colors = [ColorRGBA(r=r, g=g, b=b, a=1.0) for r, g, b in colours(force, full).tolist()]
        self._markers.publish(MarkerArray(markers=[self._marker]))

    def _picture(self, stamp: Time, force: np.ndarray, full: float) -> Image:
        rgb = self._map.rgb(force, full)
        image = Image(height=rgb.shape[0], width=rgb.shape[1], encoding="rgb8", step=3 * rgb.shape[1])
        image.header.stamp, image.header.frame_id = stamp, self._frame
        image.data = array("B", rgb.tobytes())
        return image

    def _points(self, stamp: Time, force: np.ndarray) -> PointCloud2:
        table = np.empty(len(self._layout), _CLOUD)
        table["x"], table["y"], table["z"] = self._layout.positions.T
        table["force"] = force
        cloud = PointCloud2(height=1, width=len(table), point_step=16, row_step=16 * len(table), is_dense=True)
        cloud.header.stamp, cloud.header.frame_id = stamp, self._frame
        cloud.fields = [PointField(name=n, offset=4 * i, datatype=PointField.FLOAT32, count=1) for i, n in enumerate(_CLOUD.names)]
        cloud.data = array("B", table.tobytes())
        return cloud
