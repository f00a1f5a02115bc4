"""The QoS that publishers offer: how to subscribe to all of them, and how rosbag2 writes it down."""

from typing import Any

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo


def matching(infos: list[TopicEndpointInfo], depth: int) -> QoSProfile:
    """A subscription that every publisher matches: reliable or latched only where all of them are (as rosbag2 does)."""
    profiles = [info.qos_profile for info in infos]
    reliable = profiles and all(p.reliability == ReliabilityPolicy.RELIABLE for p in profiles)
    latched = profiles and all(p.durability == DurabilityPolicy.TRANSIENT_LOCAL for p in profiles)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def offered(infos: list[TopicEndpointInfo]) -> tuple[dict[str, Any], ...]:
    """The profiles of `infos` as rosbag2's metadata has them."""
    return tuple(_mapping(info.qos_profile) for info in infos)


def _mapping(p: QoSProfile) -> dict[str, Any]:
    return {
        # A discovered endpoint does not tell its history: rosbag2 writes unknown, too.
        "history": p.history.name.lower() if p.history != HistoryPolicy.SYSTEM_DEFAULT else "unknown",
        "depth": p.depth,
        "reliability": p.reliability.name.lower(),
        "durability": p.durability.name.lower(),
        "deadline": _seconds(p.deadline),
        "lifespan": _seconds(p.lifespan),
        "liveliness": p.liveliness.name.lower(),
        "liveliness_lease_duration": _seconds(p.liveliness_lease_duration),
        "avoid_ros_namespace_conventions": p.avoid_ros_namespace_conventions,
    }


def _seconds(duration: Duration) -> dict[str, int]:
    return {"sec": duration.nanoseconds // 10**9, "nsec": duration.nanoseconds % 10**9}
