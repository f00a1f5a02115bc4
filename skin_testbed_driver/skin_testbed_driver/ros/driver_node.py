"""The driver: a lifecycle node around a rig. What it publishes is in `publishing`, what it obeys in `requests`.

    ros2 run skin_testbed_driver driver_node --ros-args -p model:=model.yaml -p seed:=3

`configure` opens the rig, `activate` starts to sample and obey, `deactivate` brakes and rests, `cleanup` releases the rig.
"""

import gc
import sys
import threading
import time
import traceback

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from skin_testbed_msgs.msg import DriverState

from skin_models.errors import SkinError
from skin_models.ros.node import end, run
from skin_models.ros.parameters import Parameters
from skin_models.ros.qos import LATCHED, overridable
from skin_testbed_driver.ros.diagnosing import diagnostics
from skin_testbed_driver.ros.driver_settings import DriverSettings
from skin_testbed_driver.ros.publishing import Publishing, state_message
from skin_testbed_driver.ros.requests import Requests
from skin_testbed_driver.ros.sampling import SamplingThread
from skin_testbed_driver.ros.transitions import bear_wrong_transitions
from skin_testbed_driver.safety import HOW_TO_RESET
from skin_testbed_driver.statistics import LoopStatistics
from skin_testbed_driver.testbed import Status, Testbed

# s, after which a thread that runs Python hands the interpreter to one that waits: sampling waits no longer than this for a report.
_TURN = 2e-4
SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


class DriverNode(LifecycleNode):
    """See the module's docstring."""

    def __init__(self) -> None:
        """Declare parameters, and start at once where `autostart` says so. Raises `SkinError`."""
        super().__init__("testbed_driver")
        bear_wrong_transitions(self)
        self._settings = Parameters(self, DriverSettings)
        self._testbed: Testbed | None = None
        self._thread: SamplingThread | None = None
        self._published: Status | None = None
        self._others = ""  # nodes that publish on our topics
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
        if self.get_parameter("use_sim_time").value:
            self.get_logger().warning("samples are taken in real time, whatever /clock says: leave out use_sim_time, and set time_scale")
        rig, calibration = settings.make_rig(self)
        self._testbed = Testbed(rig, calibration, settings.limits(), settings.sample_rate, settings.start_depth, settings.speed_samples)
        self._statistics = LoopStatistics(1.0 / (settings.sample_rate * settings.time_scale))
        # Only a rig that owns its time can run at another pace, and its first sample is now.
        self._epoch = self._stamp_ns = self._clock_ns()
        self._publishing = Publishing(self, settings, rig, calibration)
        self._publishing.describe(_stamp(self._epoch))
        self._sample = None
        self._requests = Requests(self, self._testbed, self._settings, self._epoch)
        # Wall time: a report that comes whether or not simulated time goes on.
        self._timer = self.create_timer(1.0, self._diagnose, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _activate(self) -> None:
        gc.unfreeze()
        gc.collect()
        gc.freeze()  # leaves the objects made so far out of later collections: going through them would take a period or more
        settings = self._settings.now
        if settings.time_scale == 1.0:  # in real time the first sample is now, however long configuring took or the node was inactive
            self._stamp_ns = max(self._stamp_ns, self._clock_ns())
        owned = self._stamp_ns if self._testbed.rig.owns_time else None
        self._thread = SamplingThread(
            self._tick, self._clock_ns, 1.0 / settings.sample_rate, self._statistics, owned, settings.time_scale,
            settings.realtime_priority, self.get_logger().warning,
        )  # fmt: skip
        self._testbed.resume()
        self._thread.start()
        self._requests.heeded = True
        self.get_logger().info(f"sampling at {settings.sample_rate:g} Hz, rig {settings.rig}")

    def _rest(self, reason: str) -> None:
        if self._thread is None:
            return
        self._requests.heeded = False
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
        try:
            self._testbed.close()
        except Exception:  # whatever it is, the rest is to be released, too
            self.get_logger().error(f"the rig could not be closed: {traceback.format_exc()}")
        self._testbed = None
        self._publishing.destroy()
        self._requests.destroy()
        self.destroy_timer(self._timer)

    # ---- the sampling thread ----

    def _tick(self, stamp_ns: int) -> None:
        try:
            self._stamp_ns, stamp = stamp_ns, divmod(stamp_ns, 10**9)
            self._sample = self._testbed.tick((stamp_ns - self._epoch) * 1e-9)
            if self._sample is not None:
                self._publishing.sample(self._sample, stamp)
            self._testbed.prepare()
            self._publishing.seldom(stamp)
            status = self._testbed.status()
            if status is not self._published:
                self._publish_state(status)
        except Exception as error:  # whatever it is, an axis that nobody watches must not go on
            if not isinstance(error, SkinError):
                self.get_logger().fatal(traceback.format_exc())
            self._thread.end()
            end(SkinError(f"sampling failed ({error}): {self._halted()}"))

    def _halted(self) -> str:
        """Halt the axis, and say whether that could be done."""
        try:
            self._testbed.rig.halt()
        except Exception as error:  # a rig that cannot even do this must not keep the node from ending
            self.get_logger().fatal(traceback.format_exc())
            return f"the axis could not be halted ({error}), see to it by hand"
        return "the axis was halted"

    def _publish_state(self, status: Status | None) -> None:
        if status is not None and status.reason and (self._published is None or status.reason != self._published.reason):
            # rclpy looks through all sources for who calls, some 50 ms the first time: the retraction cannot wait for that.
            threading.Thread(target=self._say_stopped, args=(status.reason,), name="log").start()
        self._published = status
        message = state_message(status, self._testbed.limits, self._settings.now.sample_rate, _stamp(self._stamp_ns))
        self._driver_state.publish(message)

    def _say_stopped(self, reason: str) -> None:
        self.get_logger().error(f"stopped: {reason}; to go on, {HOW_TO_RESET}")

    def _clock_ns(self) -> int:
        return self.get_clock().now().nanoseconds

    def _diagnose(self) -> None:
        if self._thread is None:
            return
        settings, others = self._settings.now, self._publishing.others()
        if others and others != self._others:
            self.get_logger().error(f"{others} publishes the same topics: whoever listens gets both; remap one, or end it")
        self._others = others
        wanted = settings.sample_rate * settings.time_scale
        report, offsets = self._statistics.report(), self._testbed.offsets()
        name, status = self.get_fully_qualified_name(), self._testbed.status()
        message = diagnostics(name, report, wanted, status, self._sample, offsets, others)
        message.header.stamp = _stamp(self._stamp_ns)
        self._diagnostics.publish(message)


def _stamp(nanoseconds: int) -> Time:
    return Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


def main() -> None:
    """Run the node until a signal."""
    sys.setswitchinterval(_TURN)
    run(DriverNode, settings=DriverSettings)
