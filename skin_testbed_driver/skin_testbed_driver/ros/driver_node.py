"""The driver: a lifecycle node around a rig. Topics, services and QoS are those of `publishing` and of the README.

    ros2 run skin_testbed_driver driver_node --ros-args -p model:=model.yaml -p seed:=3

`configure` opens the rig, `activate` starts to sample and obey, `deactivate` brakes and rests, `cleanup` releases the rig.
"""

import time
import traceback
from collections.abc import Callable

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from skin_models.errors import SkinError
from skin_models.ros.node import end, run
from skin_models.ros.parameters import Parameters
from skin_testbed_driver.ros.answering import create_answering_service
from skin_testbed_driver.ros.commands import trajectory_of
from skin_testbed_driver.ros.diagnosing import diagnostics
from skin_testbed_driver.ros.driver_settings import DriverSettings
from skin_testbed_driver.ros.publishing import LATCHED, Publishing, floats, overridable, state_message
from skin_testbed_driver.ros.sampling import SamplingThread
from skin_testbed_driver.statistics import LoopStatistics
from skin_testbed_driver.testbed import Status, Testbed
from skin_testbed_driver.zeroing import Outcome
from skin_testbed_msgs.msg import DriverState
from skin_testbed_msgs.srv import Tare, Zero

SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE

# Every piece of a command counts: reliable, and deeper than a commander sends in a second.
COMMANDS = QoSProfile(depth=50, reliability=ReliabilityPolicy.RELIABLE)


class DriverNode(LifecycleNode):
    """See the module's docstring."""

    def __init__(self) -> None:
        """Declare parameters, and start at once where `autostart` says so. Raises `SkinError`."""
        super().__init__("testbed_driver")
        self._settings = Parameters(self, DriverSettings)
        self._testbed: Testbed | None = None
        self._thread: SamplingThread | None = None
        self._published: Status | None = None
        self._driver_state = self.create_publisher(DriverState, "driver_state", LATCHED, qos_overriding_options=overridable())
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        if self._settings.now.autostart:
            self._configure()
            self._transition(self.trigger_configure)
            self._transition(self.trigger_activate)

    def _transition(self, trigger) -> None:
        if trigger() != SUCCESS:
            raise SkinError("the driver could not start: see its log")

    # ---- lifecycle ----

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Open the rig."""
        return self._guarded(self._configure) if self._testbed is None else SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Sample and obey from now on."""
        super().on_activate(state)
        return self._guarded(self._activate)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Brake, rest, and stop sampling."""
        self._rest("the driver was deactivated")
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Release the rig."""
        self._release()
        return SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Brake, and release the rig."""
        self._rest("the driver was shut down")
        self._release()
        return SUCCESS

    def destroy_node(self) -> None:
        """The farewell of a node that ends: as `on_shutdown`."""
        self._rest("the driver was ended")
        self._release()
        super().destroy_node()

    def _guarded(self, action) -> TransitionCallbackReturn:
        try:
            action()
        except SkinError as error:
            self.get_logger().error(str(error))
            return FAILURE
        return SUCCESS

    def _configure(self) -> None:
        settings = self._settings.now
        rig, calibration = settings.make_rig()
        self._testbed = Testbed(
            rig, calibration, settings.limits(), settings.sample_rate, settings.start_depth, settings.speed_samples
        )
        self._statistics = LoopStatistics(1.0 / (settings.sample_rate * settings.time_scale))
        # Only a rig that owns its time can run at another pace, and its first sample is now.
        self._epoch = self._stamp_ns = self._clock_ns()
        self._publishing = Publishing(self, settings, rig.layout, truth=rig.owns_time)
        self._publishing.layout(_stamp(self._epoch))
        self._sample = None
        self._endpoints = [
            self.create_subscription(JointTrajectory, "command", self._on_command, COMMANDS, qos_overriding_options=overridable()),
            create_answering_service(self, Zero, "~/zero", self._on_zero),
            create_answering_service(self, Tare, "~/tare", self._on_tare),
            self.create_service(Trigger, "~/reset_tare", self._on_reset_tare),
            self.create_service(Trigger, "~/stop", self._on_stop),
            self.create_service(Trigger, "~/reset", self._on_reset),
            # Wall time: a report that comes whether or not simulated time goes on.
            self.create_timer(1.0, self._diagnose, clock=Clock(clock_type=ClockType.STEADY_TIME)),
        ]

    def _activate(self) -> None:
        settings = self._settings.now
        owned = self._stamp_ns if self._testbed.rig.owns_time else None
        self._thread = SamplingThread(
            self._tick, self._clock_ns, 1.0 / settings.sample_rate, self._statistics, owned, settings.time_scale
        )
        self._thread.start()
        self.get_logger().info(f"sampling at {settings.sample_rate:g} Hz, rig {settings.rig}")

    def _rest(self, reason: str) -> None:
        if self._thread is None:
            return
        if not self._testbed.at_rest():
            self._testbed.stop(reason)
            braking = self._testbed.limits.max_speed / self._testbed.limits.max_acceleration / self._settings.now.time_scale
            time.sleep(braking + 3.0 * self._testbed.period)
        self._thread.end()
        self._thread = None
        self._publish_state(None)

    def _release(self) -> None:
        if self._testbed is None:
            return
        self._testbed.close()
        self._testbed = None
        self._publishing.destroy()
        subscription, *services, timer = self._endpoints
        self.destroy_subscription(subscription)
        self.destroy_timer(timer)
        for service in services:
            self.destroy_service(service)

    # ---- the sampling thread ----

    def _tick(self, stamp_ns: int) -> None:
        try:
            self._stamp_ns = stamp_ns
            self._sample = self._testbed.tick((stamp_ns - self._epoch) * 1e-9)
            self._publishing.sample(self._sample, _stamp(stamp_ns))
            status = self._testbed.status()
            if status != self._published:
                self._publish_state(status)
        except Exception as error:  # whatever it is, an axis that nobody watches must not go on
            self.get_logger().fatal(traceback.format_exc())
            self._thread.end()
            self._testbed.rig.halt()
            end(SkinError(f"sampling failed ({error}): the axis was halted; the log has the details"))

    def _publish_state(self, status: Status | None) -> None:
        if status is not None and status.reason and (self._published is None or status.reason != self._published.reason):
            self.get_logger().error(f"stopped: {status.reason}")
        self._published = status
        message = state_message(status, self._testbed.limits, self._settings.now.sample_rate, _stamp(self._stamp_ns))
        self._driver_state.publish(message)

    def _clock_ns(self) -> int:
        return self.get_clock().now().nanoseconds

    # ---- topics and services ----

    def _on_command(self, message: JointTrajectory) -> None:
        if self._thread is None:
            return
        try:
            self._testbed.follow(lambda now: trajectory_of(message, self._epoch, now))
        except SkinError as error:
            self.get_logger().warning(str(error), throttle_duration_sec=1.0)

    def _on_zero(self, request: Zero.Request, answer: Callable[[Zero.Response], None]) -> None:
        def done(outcome: Outcome) -> None:
            found = outcome.value is not None
            answer(Zero.Response(success=found, message=outcome.message, shift=outcome.value if found else 0.0))

        zero = self._settings.now.zeroing(request.threshold, request.samples)
        self._begin(lambda: self._testbed.zero(zero, done), done)

    def _on_tare(self, request: Tare.Request, answer: Callable[[Tare.Response], None]) -> None:
        def done(outcome: Outcome) -> None:
            response = Tare.Response(success=outcome.value is not None, message=outcome.message)
            if outcome.value is not None:
                response.force_offset, response.taxel_offset = outcome.value.force, floats(outcome.value.taxels)
            answer(response)

        duration = request.duration or self._settings.now.tare_duration
        self._begin(lambda: self._testbed.tare(duration, done), done)

    def _begin(self, begin: Callable[[], None], done: Callable[[Outcome], None]) -> None:
        if self._thread is None:
            return done(Outcome("the driver is not active: activate it first"))
        try:
            begin()
        except SkinError as error:
            done(Outcome(str(error)))

    def _on_reset_tare(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._testbed.reset_tare()
        response.success, response.message = True, "nothing is subtracted any more"
        return response

    def _on_stop(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._testbed.stop("the service stop was called")
        response.success, response.message = True, "stopped: call reset to go on"
        return response

    def _on_reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            self._testbed.reset()
            response.success, response.message = True, "ready"
        except SkinError as error:
            response.success, response.message = False, str(error)
        return response

    def _diagnose(self) -> None:
        if self._thread is None:
            return
        settings = self._settings.now
        wanted = settings.sample_rate * settings.time_scale
        report, offsets = self._statistics.report(), self._testbed.offsets()
        message = diagnostics(self.get_fully_qualified_name(), report, wanted, self._testbed.status(), self._sample, offsets)
        message.header.stamp = _stamp(self._stamp_ns)
        self._diagnostics.publish(message)


def _stamp(nanoseconds: int) -> Time:
    return Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


def main() -> None:
    """Run the node until a signal."""
    run(DriverNode)
