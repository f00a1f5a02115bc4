"""What the driver obeys: commands on a topic, services, and places for the x-y stage."""

from collections.abc import Callable

from geometry_msgs.msg import PointStamped
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import QoSProfile, ReliabilityPolicy
from skin_testbed_msgs.srv import Tare, Zero
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from skin_models.errors import SkinError
from skin_models.ros.parameters import Parameters
from skin_models.ros.qos import LATCHED, overridable
from skin_models.ros.taxel_output import floats
from skin_testbed_driver.ros.answering import create_answering_service
from skin_testbed_driver.ros.commands import trajectory_of
from skin_testbed_driver.ros.driver_settings import DriverSettings
from skin_testbed_driver.safety import HOW_TO_RESET
from skin_testbed_driver.testbed import Testbed
from skin_testbed_driver.zeroing import Outcome

NOT_ACTIVE = "the driver is not active: activate it first"

# Every piece of a command counts: reliable, and deeper than a commander sends in a second.
COMMANDS = QoSProfile(depth=50, reliability=ReliabilityPolicy.RELIABLE)


class Requests:
    """The driver's subscriptions and services. Nothing is done unless `heeded`: the node is active."""

    def __init__(self, node: LifecycleNode, testbed: Testbed, settings: Parameters[DriverSettings], epoch: int) -> None:
        """`epoch` (ns) is the node time at which the testbed's clock read zero."""
        self._node, self._testbed, self._settings, self._epoch = node, testbed, settings, epoch
        self.heeded = False
        self._subscriptions = [
            node.create_subscription(JointTrajectory, "command", self._on_command, COMMANDS, qos_overriding_options=overridable()),
            node.create_subscription(PointStamped, "stage_target", self._on_stage_target, LATCHED),
        ]
        self._services = [
            create_answering_service(node, Zero, "~/zero", self._on_zero),
            create_answering_service(node, Tare, "~/tare", self._on_tare),
            node.create_service(Trigger, "~/reset_tare", self._on_reset_tare),
            node.create_service(Trigger, "~/cancel", self._on_cancel),
            node.create_service(Trigger, "~/stop", self._on_stop),
            node.create_service(Trigger, "~/reset", self._on_reset),
        ]

    def destroy(self) -> None:
        """Take them away."""
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)
        for service in self._services:
            self._node.destroy_service(service)

    def _on_stage_target(self, message: PointStamped) -> None:
        if not self.heeded:
            return
        try:
            self._testbed.place(message.point.x, message.point.y)
        except SkinError as error:
            self._node.get_logger().warning(f"the x-y stage stays where it is: {error}")

    def _on_command(self, message: JointTrajectory) -> None:
        if not self.heeded:
            return
        try:
            self._testbed.follow(lambda now: trajectory_of(message, self._epoch, now))
        except SkinError as error:
            self._node.get_logger().warning(str(error), throttle_duration_sec=1.0)

    def _on_zero(self, request: Zero.Request, answer: Callable[[Zero.Response], None]) -> None:
        def done(outcome: Outcome) -> None:
            found = outcome.value is not None
            answer(Zero.Response(success=found, message=outcome.message, shift=outcome.value if found else 0.0))

        wanted = {"zero_threshold": request.threshold, "zero_samples": request.samples}
        self._begin(lambda: self._testbed.zero(self._now_with(wanted).zeroing(), done), done)

    def _on_tare(self, request: Tare.Request, answer: Callable[[Tare.Response], None]) -> None:
        def done(outcome: Outcome) -> None:
            response = Tare.Response(success=outcome.value is not None, message=outcome.message)
            if outcome.value is not None:
                response.force_offset, response.taxel_offset = outcome.value.force, floats(outcome.value.taxels)
            answer(response)

        wanted = {"tare_duration": request.duration}
        self._begin(lambda: self._testbed.tare(self._now_with(wanted).tare_duration, done), done)

    def _now_with(self, wanted: dict[str, float]) -> DriverSettings:
        """The parameters with what a request asks for; 0 asks for nothing. Raises `SkinError` beyond a parameter's range."""
        return self._settings.now_with(**{name: value for name, value in wanted.items() if value})

    def _begin(self, begin: Callable[[], None], done: Callable[[Outcome], None]) -> None:
        if not self.heeded:
            return done(Outcome(NOT_ACTIVE))
        try:
            begin()
        except SkinError as error:
            done(Outcome(str(error)))

    def _on_reset_tare(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return self._answer(response, self._testbed.reset_tare, "nothing is subtracted any more")

    def _on_stop(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return self._answer(response, lambda: self._testbed.stop("the service stop was called"), f"stopped: to go on, {HOW_TO_RESET}")

    def _on_cancel(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return self._answer(response, self._testbed.cancel, "cancelled")

    def _on_reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return self._answer(response, self._testbed.reset, "ready")

    def _answer(self, response: Trigger.Response, action: Callable[[], None], done: str) -> Trigger.Response:
        response.success, response.message = False, NOT_ACTIVE
        if self.heeded:
            try:
                action()
                response.success, response.message = True, done
            except SkinError as error:
                response.message = str(error)
        return response
