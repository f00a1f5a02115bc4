"""The recorder: everything on the graph, or the topics asked for, into a rosbag2 directory with one MCAP file.

    ros2 run skin_testbed_driver recorder --ros-args -p directory:=session_1
    ros2 run skin_testbed_driver recorder --ros-args -p "topics:=[force, encoder, taxels]"

Subscriptions take messages as they were sent, without decoding, and callbacks write them: a second thread would hold the interpreter for
whole chunks while messages wait to be taken. Topics that appear later are recorded from then on. The recording ends with SIGINT, SIGTERM or
the service `~/stop`. It says when messages of all topics that were asked for can come, and at the end which brought nothing; where none are
asked for, these are the encoder, force and taxels of a rig. Exit status 2 says that nothing at all came, and no recording is left,
or that nothing could be written any more.
"""

import datetime
import functools
import importlib
import importlib.metadata
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

from skin_models.errors import SkinError
from skin_models.ros.node import end, run
from skin_models.ros.parameters import Parameters, setting
from skin_models.words import counted
from skin_testbed_driver.bag import BagWriter, TopicInfo
from skin_testbed_driver.ros.definitions import DefinitionError, definition
from skin_testbed_driver.ros.descriptions import Descriptions
from skin_testbed_driver.ros.offered_qos import matching, offered

_LOOK = 0.2  # s, between two looks at the graph
_IS_ONE_THERE = "does a driver run, in the same ROS domain?"
_PATIENCE = 5.0  # s, after which topics that were asked for should be there
_RIG = ("encoder", "force", "taxels")  # without these, in whatever namespace, a recording says nothing of skin
_IDLE = 0.1  # s, between two looks whether messages wait for others that do not come


@dataclass(frozen=True)
class RecorderSettings:
    """Every parameter; all are fixed once the recording runs."""

    directory: str = setting("", "where to record, must not exist; empty: session_<date and time>", fixed=True)
    topics: tuple[str, ...] = setting((), "topics to record; empty: all that are not hidden", fixed=True)
    exclude: tuple[str, ...] = setting(("/rosout", "/parameter_events"), "topics to leave out when all are recorded", fixed=True)
    depth: int = setting(10000, "messages that a queue holds: at 1 kHz a stall of ten seconds", lower=1, upper=1000000, fixed=True)
    rig_file: str = setting("", "YAML about the rig that is put into the recording and beside it as rig.yaml", fixed=True)


class Recorder(Node):
    """See the module's docstring."""

    def __init__(self) -> None:
        """Begin to record. Raises `SkinError` when the directory exists or the rig file cannot be read."""
        super().__init__("recorder")
        self._settings = Parameters(self, RecorderSettings).now
        self._wanted = {self.resolve_topic_name(name) for name in self._settings.topics}
        self._left_out = {self.resolve_topic_name(name) for name in self._settings.exclude}
        rig = _read_rig(self._settings.rig_file)
        self._bag = BagWriter(self._settings.directory or datetime.datetime.now().strftime("session_%Y-%m-%d_%H-%M-%S"))
        self._known: set[str] = set()
        self._complete = False  # every topic asked for was seen, by default those of a rig
        self._describe(rig)
        self._failed = False
        self._look()
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(_LOOK, functools.partial(self._try, self._look), clock=steady)
        self.create_timer(_IDLE, functools.partial(self._try, self._bag.flush_if_due), clock=steady)
        self._patience = self.create_timer(_PATIENCE, self._complain_of_missing, clock=steady)
        self.create_service(Trigger, "~/stop", self._on_stop)
        self.get_logger().info(f"recording to {self._bag.directory}")

    def destroy_node(self) -> None:
        """End the recording, whole. Raises `SkinError` where it is empty, and leaves nothing of it."""
        try:
            self._bag.close()
            if not self._failed:
                self._complain_of_silence()
            messages, topics = counted(sum(self._bag.counts), "message"), counted(len(self._bag.counts), "topic")
            self.get_logger().info(f"{messages} of {topics} in {self._bag.directory}")
        finally:
            super().destroy_node()

    def _complain_of_missing(self) -> None:
        """Once, early enough to do something about it."""
        self._patience.cancel()
        for name in sorted(self._wanted - self._known):
            self.get_logger().warning(f"{name} has no publisher yet")
        absent = self._absent(self._known)
        if absent:
            self.get_logger().warning(f"nobody publishes {absent} yet: {_IS_ONE_THERE}")

    def _complain_of_silence(self) -> None:
        """At the end. Raises `SkinError` where nothing was recorded."""
        heard = self._bag.heard()
        for name in sorted(self._wanted - heard):
            why = "no message came" if name in self._known else "nobody published it"
            self.get_logger().warning(f"{name} was never recorded: {why}")
        absent = self._absent(heard)
        if absent:
            self.get_logger().warning(f"nothing was recorded of {absent}: {_IS_ONE_THERE}")
        if not heard:
            self._bag.remove()
            raise SkinError(f"not one message came, so no recording is kept: {_IS_ONE_THERE}")

    def _absent(self, there: Iterable[str]) -> str:
        """What of a rig is not among the topics `there`, in words; empty where topics were asked for by name."""
        names = set(map(_last, there))
        return "" if self._wanted else ", ".join(name for name in _RIG if name not in names)

    def _describe(self, rig: bytes | None) -> None:
        now = self.get_clock().now().nanoseconds
        self._bag.note("skin_testbed", {"software": "skin_testbed_driver " + importlib.metadata.version("skin-testbed-driver")})
        if rig is not None:
            self._bag.attach("rig.yaml", "application/yaml", rig, now)
        # What the driver says of itself, unless the user knows better.
        files = {"calibration": "calibration.yaml", **({} if rig else {"rig_description": "rig.yaml"})}
        self._descriptions = Descriptions(self, files, functools.partial(self._try, self._on_text))

    def _look(self) -> None:
        """Subscribe to what is new on the graph."""
        graph = dict(self.get_topic_names_and_types())
        for name, types in graph.items():
            if name not in self._known and self._is_wanted(name) and self.count_publishers(name):
                self._known.add(name)
                self._subscribe(name, types[0])
        self._descriptions.look(graph, self._known)
        if not self._complete and self._has_all(self._coming()):
            self._complete = True
            what = "every topic asked for is" if self._wanted else f"{', '.join(_RIG[:-1])} and {_RIG[-1]} are"
            self.get_logger().info(f"{what} being recorded")

    def _has_all(self, there: set[str]) -> bool:
        """Whether the topics `there` hold what was asked for, by default those of a rig."""
        return self._wanted <= there and not self._absent(there)

    def _coming(self) -> set[str]:
        """The topics that have a publisher and, for a rig's streams, a message: a publisher finds a subscription later than it is found."""
        heard = self._bag.heard()
        there = (s.topic_name for s in self.subscriptions if s.get_publisher_count())
        return {name for name in there if name in heard or _last(name) not in _RIG}

    def _is_wanted(self, name: str) -> bool:
        if self._settings.topics:
            return name in self._wanted
        return name not in self._left_out and not any(part.startswith("_") for part in name.split("/"))

    def _subscribe(self, name: str, type_name: str) -> None:
        infos = self.get_publishers_info_by_topic(name)
        try:
            message_class, text = _message_class(type_name), definition(type_name)
        except (DefinitionError, ImportError, AttributeError) as error:
            self.get_logger().warning(f"{name} is not recorded: {error}")
            return
        type_hash = str(infos[0].topic_type_hash) if infos and hasattr(infos[0], "topic_type_hash") else ""
        index = self._bag.add_topic(TopicInfo(name, type_name, text, offered(infos), type_hash))
        callback = functools.partial(self._try, self._on_message, index)
        self.create_subscription(message_class, name, callback, matching(infos, self._settings.depth), raw=True)

    def _try(self, action: Callable, *args: Any) -> None:
        """Call `action`. If the file cannot be written any more, end the node with that sentence: an executor would print a traceback."""
        if self._failed:
            return
        try:
            action(*args)
        except SkinError as error:
            self._failed = True
            end(error)

    def _on_message(self, index: int, data: bytes) -> None:
        # The time of publication would come with the message, but the events executor of Jazzy cannot pass it on.
        now = self.get_clock().now().nanoseconds
        self._bag.write(index, data, now, now)

    def _on_text(self, file_name: str, message: String) -> None:
        """A latched description: also kept as a file, inside the recording and beside it."""
        data = message.data.encode()
        self._bag.attach(file_name, "application/yaml", data, self.get_clock().now().nanoseconds)

    def _on_stop(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success, response.message = True, f"{counted(sum(self._bag.counts), 'message')} in {self._bag.directory}"
        end()
        return response


def _last(topic: str) -> str:
    """The name of a topic without its namespace."""
    return topic.rpartition("/")[2]


def _message_class(type_name: str) -> type:
    package, kind, name = type_name.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), name)


def _read_rig(path: str) -> bytes | None:
    if not path:
        return None
    try:
        content = Path(path).read_bytes()
        yaml.safe_load(content)
        return content
    except (OSError, yaml.YAMLError) as error:
        raise SkinError(f"the rig file {path} cannot be used: {' '.join(str(error).split())}") from error


def main() -> None:
    """Run the node until a signal."""
    run(Recorder, settings=RecorderSettings)
