"""Quality of service of the suite's topics, stated once and overridable by parameters."""

from rclpy.qos import DurabilityPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions

# Keeps its last message for whoever comes later.
LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)

# Takes what comes, from reliable and best-effort publishers alike; deep, so that a stall of the subscriber loses nothing.
LISTENING = QoSProfile(depth=200, reliability=ReliabilityPolicy.BEST_EFFORT)


def stream(rate: float) -> QoSProfile:
    """A sensor stream: reliable, so that reliable and best-effort subscribers both match, and one second deep."""
    return QoSProfile(depth=max(int(rate), 10), reliability=ReliabilityPolicy.RELIABLE)


def overridable() -> QoSOverridingOptions:
    """Let parameters `qos_overrides.<topic>.<publisher|subscription>.*` change history, depth, reliability and durability."""
    kinds = (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY, QoSPolicyKind.DURABILITY)
    return QoSOverridingOptions(kinds)
