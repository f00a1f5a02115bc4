"""Actions between two motions: what is asked of the driver's services, of the x-y stage, or of the person who turns its screws.

`begin` starts an action and returns a function to poll, which gives None until the outcome is known.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from geometry_msgs.msg import PointStamped
from rclpy.node import Node
from skin_testbed_msgs.srv import Tare as TareService
from skin_testbed_msgs.srv import Zero as ZeroService
from std_srvs.srv import Trigger

from skin_models.ros.qos import LATCHED, LISTENING
from skin_motion_profiles.entry import Action
from skin_motion_profiles.profile import MM
from skin_motion_profiles.profiles.place import Place
from skin_motion_profiles.profiles.tare import Tare
from skin_motion_profiles.profiles.zero import Zero
from skin_motion_profiles.ros.settings import Settings


@dataclass(frozen=True)
class Answer:
    """How an action went, and a sentence."""

    success: bool
    sentence: str


Poll = Callable[[], Answer | None]


class Asking:
    """The clients, topics and services that actions need.

    `stage_target` (PointStamped, frame of the skin, latched) says which point of the skin is to be under the plunger. A motorised stage
    goes there and reports on `stage_position`; with a manual one somebody calls `~/proceed` when it is there.
    """

    def __init__(self, node: Node, settings: Settings) -> None:
        """Make them on `node`; the driver's services are those under `driver_name`."""
        self.zero = node.create_client(ZeroService, f"{settings.driver_name}/zero")
        self.tare = node.create_client(TareService, f"{settings.driver_name}/tare")
        self.cancelling = node.create_client(Trigger, f"{settings.driver_name}/cancel")
        self.halt = node.create_client(Trigger, f"{settings.driver_name}/stop")
        self.target = node.create_publisher(PointStamped, "stage_target", LATCHED)
        self.position: PointStamped | None = None
        self.proceeded = False
        node.create_subscription(PointStamped, "stage_position", self._on_position, LISTENING)
        node.create_service(Trigger, "~/proceed", self._on_proceed)
        self._clock, self._frame, self._tolerance = node.get_clock(), settings.skin_frame, settings.stage_tolerance

    def begin(self, action: Action) -> Poll:
        """Start an action."""
        match action:
            case Zero():
                return self._call(self.zero, ZeroService.Request(threshold=action.threshold_v, samples=action.samples))
            case Tare():
                return self._call(self.tare, TareService.Request(duration=action.duration_s))
            case Place():
                return self._move(action.x_mm * MM, action.y_mm * MM)
        return lambda: Answer(False, f"nobody knows how to do {action.label}")

    def hint(self, action: Action) -> str:
        """What a person should know or do while it lasts."""
        if isinstance(action, Place):
            return f"{action.label}: bring x = {action.x_mm:g} mm, y = {action.y_mm:g} mm under the plunger, then call ~/proceed"
        return action.label

    def end(self) -> Poll:
        """End what the driver does on its own. `cancel` leaves it ready; a driver without that service is stopped, and needs a reset."""
        return self._call(self.cancelling if self.cancelling.service_is_ready() else self.halt, Trigger.Request())

    def _call(self, client: Any, request: Any) -> Poll:
        future = None
        patience = time.monotonic() + 5.0

        def poll() -> Answer | None:
            nonlocal future
            if future is None and client.service_is_ready():
                future = client.call_async(request)
            if future is None:
                missing = Answer(False, f"the driver offers no service {client.srv_name}: check the parameter driver_name")
                return missing if time.monotonic() > patience else None
            return Answer(future.result().success, future.result().message) if future.done() else None

        return poll

    def _move(self, x: float, y: float) -> Poll:
        self.proceeded, self.position = False, None
        message = PointStamped()
        message.header.stamp, message.header.frame_id = self._clock.now().to_msg(), self._frame
        message.point.x, message.point.y = x, y
        self.target.publish(message)

        def poll() -> Answer | None:
            there = self.position is not None and math.hypot(self.position.point.x - x, self.position.point.y - y) <= self._tolerance
            return Answer(True, "there") if there or self.proceeded else None

        return poll

    def _on_position(self, message: PointStamped) -> None:
        self.position = message

    def _on_proceed(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self.proceeded = True
        response.success, response.message = True, "going on"
        return response
