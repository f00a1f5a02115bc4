"""What a rig says of itself on latched topics, for the files of a recording: the rig in the recorder's namespace, else the only one."""

from collections.abc import Callable, Iterable, Mapping

from rclpy.node import Node
from std_msgs.msg import String

from skin_models.ros.qos import LATCHED

_TEXT = "std_msgs/msg/String"
_TOPICS = ("rig_description", "calibration")  # a rig publishes both
_SETTLED = 5  # looks in a row that find the same rigs: they are discovered one after the other


class Descriptions:
    """Subscriptions of `node` to the descriptions of one rig."""

    def __init__(self, node: Node, files: Mapping[str, str], take: Callable[[str, String], None]) -> None:
        """`files` names the file of every topic that is to be kept; `take(file, message)` keeps it."""
        self._node, self._files, self._take = node, files, take
        self._own = node.get_namespace().rstrip("/")
        self._of: str | None = None  # the namespace of another rig that is listened to
        self._seen: set[str] = set()
        self._same = 0  # looks that found no others
        self._doubted = False
        for topic in files:
            self._listen(topic, node.resolve_topic_name(topic))

    def look(self, graph: Mapping[str, list[str]], recorded: Iterable[str]) -> None:
        """Listen to the only rig on the graph (types by topic) where none is in this namespace; of several, the one that is recorded."""
        rigs = {name.rpartition("/")[0] for name in graph if self._is_rig(name.rpartition("/")[0], graph)}
        self._seen, self._same = rigs, self._same + 1 if rigs == self._seen else 1
        if self._own in rigs or self._doubted or not rigs or self._same < _SETTLED:
            return
        beside = rigs & {name.rpartition("/")[0] for name in recorded}
        found = sorted(beside if len(rigs) > 1 else rigs)
        if len(found) == 1 and found[0] != self._of:
            self._of = found[0]
            for topic in self._files:
                self._listen(topic, f"{self._of}/{topic}")
            self._node.get_logger().info(f"{self._named()} will be those of the rig in {self._of or '/'}")
        elif len(found) > 1:
            self._doubted = True
            kept = f"those of {self._of or '/'} are kept" if self._of is not None else f"{self._named()} will be missing"
            how = "give rig_file, or start a recorder for each in its namespace, -r __ns:=/NAMESPACE"
            names = ", ".join(name or "/" for name in found)
            self._node.get_logger().warning(f"more than one rig describes itself ({names}): {kept}; {how}")

    def _listen(self, topic: str, name: str) -> None:
        self._node.create_subscription(String, name, lambda message: self._take(self._files[topic], message), LATCHED)

    def _is_rig(self, namespace: str, graph: Mapping[str, list[str]]) -> bool:
        names = [f"{namespace}/{topic}" for topic in _TOPICS]
        return all(_TEXT in graph.get(name, ()) and self._node.count_publishers(name) for name in names)

    def _named(self) -> str:
        return " and ".join(self._files.values())
