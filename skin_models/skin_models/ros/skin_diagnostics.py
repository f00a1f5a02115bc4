"""What the skin node says on /diagnostics."""

from collections import Counter

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from skin_models.ros.contact_input import ContactInput
from skin_models.ros.ticking import TickReport
from skin_models.words import counted

_RATE_TOLERANCE = 0.02  # of the wanted rate


class SkinDiagnostics:
    """Counts between reports, and publishes them."""

    def __init__(self, node: Node) -> None:
        """Advertise on `node`."""
        self._node, self._publisher = node, node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._outside = self._stale = self._refused = 0
        self._unusable: Counter[str] = Counter()
        self._doubtful: Counter[str] = Counter()
        self._foreign = ""

    def frame(self, frame: str, skin_frame: str) -> None:
        """Note the frame in which contacts come."""
        if frame not in ("", skin_frame):
            self._foreign = f"contacts in the frame {frame} are taken as if in {skin_frame}"

    def sample(self, outside: int, stale: bool) -> None:
        """Note one sample: contacts that no taxel is near, and whether contacts were stale."""
        self._outside, self._stale = max(self._outside, outside), self._stale + stale

    def contacts(self, about: str, ticks: TickReport, wanted: float, heard: ContactInput) -> None:
        """Report on a skin that contacts press on; `heard` counts contacts since the start, a complaint those since the last report."""
        unusable, doubtful = heard.unusable.copy(), heard.doubtful.copy()
        left_out, kept = unusable - self._unusable, doubtful - self._doubtful
        self._unusable, self._doubtful = unusable, doubtful
        complaints = [
            text
            for bad, text in (
                (ticks.rate < wanted * (1.0 - _RATE_TOLERANCE) or ticks.skipped, f"{ticks.rate:.1f} of {wanted:g} Hz"),
                (ticks.stands, "/clock stands still"),
                (self._outside, f"{counted(self._outside, 'contact')} beside the skin"),
                (self._stale, "contacts fell silent"),
                *((count, f"left out {counted(count, 'contact')} {fault}") for fault, count in left_out.items()),
                *((count, f"{counted(count, 'contact')} {fault}") for fault, count in kept.items()),
                (self._foreign, self._foreign),
            )
            if bad
        ]
        values = {"achieved_rate_hz": f"{ticks.rate:.2f}", "skipped": ticks.skipped, "late_p99_us": f"{1e6 * ticks.late_p99:.0f}"}
        self._publish(about, complaints, {**values, "unusable_contacts": unusable.total(), "stale_samples": self._stale})
        self._outside = self._stale = 0
        self._foreign = ""

    def encoder(self, about: str, refused: int, restarts: int) -> None:
        """Report on a skin that an encoder drives; counts as for contacts."""
        left_out, self._refused = max(refused - self._refused, 0), refused  # another model counts anew
        words = f"left out {counted(left_out, 'encoder sample')} with no depth of up to 100 mm (in m, not in mm) or no newer stamp"
        complaints = [words] if left_out else []
        self._publish(about, complaints, {"refused_samples": refused, "restarts": restarts})

    def _publish(self, about: str, complaints: list[str], values: dict) -> None:
        status = DiagnosticStatus(
            name=f"{self._node.get_fully_qualified_name()}: skin",
            level=DiagnosticStatus.WARN if complaints else DiagnosticStatus.OK,
            message="; ".join(complaints) or about,
            hardware_id="simulated_skin",
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)
