"""What ends a goal before its time, each with its code and a sentence."""

from collections.abc import Callable

from skin_testbed_msgs.action import ExecuteProfile
from skin_testbed_msgs.msg import DriverState

from skin_motion_profiles.control import Controlled
from skin_motion_profiles.entry import Action
from skin_motion_profiles.profiles.place import Place
from skin_motion_profiles.ros.driver_link import DriverLink
from skin_motion_profiles.ros.settings import Settings
from skin_motion_profiles.ros.steering import Steering
from skin_motion_profiles.ros.streaming import Stream

Result = ExecuteProfile.Result
_CLOCK_SLACK = 1.0  # s by which the clocks of driver and server may differ
_HOW_TO_RESET = "to go on, call its service reset (run skin_testbed_driver call reset)"


class Ended(Exception):
    """The goal cannot go on: a code of the action's result and a sentence."""

    def __init__(self, code: int, sentence: str) -> None:
        """`code` is one of `ExecuteProfile.Result`."""
        super().__init__(sentence)
        self.code = code


class Watch:
    """Looks at driver and client on behalf of one goal. Everything but `met`, `arrived` and `alive` raises `Ended` or does nothing."""

    def __init__(self, link: DriverLink, settings: Settings, max_force: float, cancelled: Callable[[], bool]) -> None:
        """`max_force` (N) is that of the goal; `cancelled()` tells whether the client wants the end."""
        self.link, self.settings, self.max_force, self.cancelled = link, settings, max_force, cancelled

    def met(self) -> bool:
        """Whether everything of the driver has been discovered, and its clock timed."""
        link = self.link
        return link.state is not None and link.heeded and link.timed and not link.silent(self.settings.feedback_timeout)

    def before_moving(self) -> None:
        """Is the driver there, ready, and on the same clock?"""
        if self.link.state is None:
            raise Ended(Result.DRIVER_FAULT, "no driver has announced itself on the topic driver_state: start driver_node")
        self._driver()
        self._samples()
        if not self.link.heeded:
            raise Ended(Result.DRIVER_FAULT, "nobody listens on the topic command: check the names and namespaces of driver and server")
        ahead = (self.link.depth.stamp - self.link.now()) * 1e-9
        if abs(ahead) > _CLOCK_SLACK * self.link.rate:
            raise Ended(
                Result.NO_FEEDBACK,
                f"the stamps of encoder differ by {ahead:+.1f} s from this node's clock: set use_sim_time as the driver does",
            )

    def may_ask(self, action: Action) -> None:
        """May the x-y stage move now? Whether the sensors may be zeroed or tared is for the driver to say."""
        if isinstance(action, Place) and self.link.depth.value > 0.0:
            where = f"{self.link.depth.value * 1e3:.3f} mm in the skin"
            raise Ended(Result.INVALID_PROFILE, f"{action.label} needs the plunger in the air, but it is {where}: put free_air before it")

    def is_quick_enough(self, controlled: Controlled, delay: float) -> None:
        """Is a force answered soon enough for this control?"""
        if delay > controlled.slowest_sampling():
            raise Ended(
                Result.INVALID_PROFILE,
                f"{controlled.label}: a force is answered after {delay * 1e3:.0f} ms, but this control needs it within "
                f"{controlled.slowest_sampling() * 1e3:.0f} ms: lower its bandwidth, or the time_scale of the rig",
            )

    def finds_contact(self, steering: Steering) -> None:
        """Is there anything to press against?"""
        if steering.lost:
            c = steering.controlled
            raise Ended(Result.DEPTH_ERROR, f"{c.label}: no contact of {c.contact_n:g} N down to deepest_mm = {c.deepest_mm:g}")

    def check(self, stream: Stream | None) -> None:
        """May the goal go on? `stream` is the motion under way, if there is one."""
        if self.cancelled():
            raise Ended(Result.CANCELLED, "cancelled")
        if self.link.peak_load > self.max_force:
            raise Ended(Result.OVER_FORCE, f"the force reached {self.link.peak_load:.2f} N, more than the allowed {self.max_force:g} N")
        self._driver()
        self._samples()
        if stream is not None:
            self._depth(stream)

    def arrived(self, stream: Stream) -> bool:
        """Whether the stage rests where the motion ends."""
        trajectory, depth = stream.motion.trajectory, self.link.depth
        t = (depth.stamp - stream.base) * 1e-9
        if t < trajectory.duration:
            return False
        if abs(depth.value - trajectory.end) <= self.settings.depth_tolerance:
            return True
        if t > trajectory.duration + self.settings.settle_time:
            where = f"{depth.value * 1e3:.3f} mm instead of {trajectory.end * 1e3:.3f} mm"
            raise Ended(Result.DEPTH_ERROR, f"the stage rests at {where}, {self.settings.settle_time:g} s after the end of the motion")
        return False

    def alive(self) -> bool:
        """Whether the driver still reports and has not stopped."""
        return self.link.state.state != DriverState.STOPPED and not self.link.silent(2.0 * self.settings.feedback_timeout)

    def cause_of(self, end: Ended) -> Ended:
        """What really ended the goal: a stage does not follow a driver that has stopped, whose word may come later than its samples."""
        may_be_its_stop = end.code in (Result.DEPTH_ERROR, Result.NO_FEEDBACK) and self.link.state is not None
        return (self._stop() if may_be_its_stop else None) or end

    def _stop(self) -> Ended | None:
        state = self.link.state
        if state.state != DriverState.STOPPED:
            return None
        return Ended(Result.DRIVER_FAULT, f"the driver has stopped: {state.reason or 'it gives no reason'}; {_HOW_TO_RESET}")

    def _driver(self) -> None:
        state = self.link.state
        if stop := self._stop():
            raise stop
        if state.state == DriverState.INACTIVE:
            raise Ended(Result.DRIVER_FAULT, "the driver is not active: activate it")

    def _samples(self) -> None:
        if silent := self.link.silent(self.settings.feedback_timeout):
            raise Ended(Result.NO_FEEDBACK, f"no valid sample on {' and '.join(silent)} for {self.settings.feedback_timeout:g} s")

    def _depth(self, stream: Stream) -> None:
        depth = self.link.depth
        planned = stream.planned(depth.stamp)
        if abs(depth.value - planned) <= self.settings.depth_tolerance:
            stream.off_since = None
            return
        stream.off_since = stream.off_since or depth.stamp
        if (depth.stamp - stream.off_since) * 1e-9 > self.settings.depth_patience:
            where = f"{depth.value * 1e3:.3f} mm where {planned * 1e3:.3f} mm were asked for"
            raise Ended(Result.DEPTH_ERROR, f"the stage does not follow: it is at {where}")
