"""One goal from its first check to its result. Every way out passes `Run.result`, so a goal always ends.

What can end a goal early, in the order in which it is looked for: cancel, over-force, a stop of the driver, silence of encoder or
load cell, a stage that does not follow. Then the plunger brakes as hard as the rig allows and retracts or holds, as the goal said.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from rclpy.time import Time

from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.plan import Motion, Travel, motion, stop
from skin_motion_profiles.profile import Profile
from skin_motion_profiles.profile_file import profile_from_text
from skin_motion_profiles.ros.driver_link import KNOT_PERIOD, DriverLink
from skin_motion_profiles.ros.settings import Settings
from skin_testbed_msgs.action import ExecuteProfile
from skin_testbed_msgs.msg import DriverState

Result = ExecuteProfile.Result
_LOOK = 0.02  # s between two looks at the driver; messages wake it earlier
_RENEW = 0.1  # s between two pieces of trajectory
_LOOKAHEAD = 0.5  # s of motion that the driver has in hand
_HEAD_START = 0.1  # s from a decision to the first moment of motion
_REACT = 0.02  # s from a reason to stop to the moment from which the motion is replaced
_CLOCK_SLACK = 1.0  # s by which the clocks of driver and server may differ


class Ended(Exception):
    """The goal cannot go on: a code of the action's result and a sentence."""

    def __init__(self, code: int, sentence: str) -> None:
        super().__init__(sentence)
        self.code = code


@dataclass
class Under:
    """The motion under way and the node time (ns) at which it began."""

    motion: Motion
    base: int
    off_since: int | None = None  # stamp of the first sample of the present stretch that is not where it should be


class Run:
    """Executes one goal in a thread of its own."""

    def __init__(
        self, goal: ExecuteProfile.Goal, link: DriverLink, settings: Settings,
        cancelled: Callable[[], bool], publish: Callable[[ExecuteProfile.Feedback], None],
    ) -> None:  # fmt: skip
        self.goal, self.link, self.settings = goal, link, settings
        self.cancelled, self.publish = cancelled, publish
        self.max_force = goal.max_force or settings.max_force
        self.under: Under | None = None
        self.started: int | None = None
        self.done_before = self.whole = 0.0  # s of motion: finished stretches, and the whole goal
        self.fed_back = 0.0

    def result(self) -> Result:
        """Execute the goal and say how it went."""
        self.link.forget_peaks()
        try:
            self.execute()
            return self.summary(Result.SUCCESS, "the profile was executed to its end")
        except ProfileError as error:
            return self.summary(Result.INVALID_PROFILE, str(error))
        except Ended as end:
            self.come_to_rest(end.code)
            return self.summary(end.code, str(end))

    def execute(self) -> None:
        """The goal itself. Raises `ProfileError` before anything moves, `Ended` when it cannot go on."""
        profile = self.checked_profile()
        self.look_before_moving()
        plan = motion([profile], self.link.depth.value, self.travel())
        self.link.limits.check(plan.trajectory, profile.kind)
        self.whole = plan.trajectory.duration
        self.follow(plan)

    def checked_profile(self) -> Profile:
        """The goal's profile. Raises `ProfileError` where the goal makes no sense."""
        if not self.goal.max_force >= 0.0:
            raise ProfileError(f"max_force = {self.goal.max_force:g} N must be positive, or 0 for the server's own limit")
        if self.goal.on_stop not in (ExecuteProfile.Goal.RETRACT, ExecuteProfile.Goal.HOLD):
            raise ProfileError(f"on_stop must be 0 (RETRACT) or 1 (HOLD), not {self.goal.on_stop}")
        return profile_from_text(self.goal.profile)

    def look_before_moving(self) -> None:
        """Raise `Ended` unless the driver is there, ready, and on the same clock."""
        if self.link.state is None:
            raise Ended(Result.DRIVER_FAULT, "no driver has announced itself on the topic driver_state: start driver_node")
        self.check_driver()
        self.check_feedback()
        ahead = (self.link.depth.stamp - self.link.now()) * 1e-9
        if abs(ahead) > _CLOCK_SLACK * self.link.rate:
            raise Ended(
                Result.NO_FEEDBACK,
                f"the stamps of encoder differ by {ahead:+.1f} s from this node's clock: set use_sim_time as the driver does",
            )

    def travel(self) -> Travel:
        """How to move where no profile says how."""
        return Travel(self.settings.approach_speed, self.settings.approach_acceleration).within(self.link.limits)

    def follow(self, plan: Motion) -> None:
        """Hand a motion to the driver, piece by piece, until its end has been reached. Raises `Ended`."""
        base = self.link.now() + int(_HEAD_START * self.link.rate * 1e9)
        self.started = self.started or base
        self.under = Under(plan, base)
        knots, sent, length = plan.trajectory.knots(KNOT_PERIOD), 0, plan.trajectory.duration
        while (t := self.time()) < length or not self.arrived(t):
            self.check()
            sent = self.hand_over(knots, sent, max(t, 0.0))
            self.feed_back(t)
            self.wait()
        self.done_before += length

    def hand_over(self, knots: np.ndarray, sent: int, t: float) -> int:
        """Send what the driver needs next; `sent` is the knot up to which it has been sent. Returns the new one."""
        last = knots.size - 1
        until = min(int(np.searchsorted(knots, t + _LOOKAHEAD * self.link.rate)), last)
        if sent == last or (until < last and knots[until] - knots[sent] < _RENEW * self.link.rate):
            return sent
        self.link.send(self.under.base, self.under.motion.trajectory, knots[sent : until + 1])
        return until

    def time(self) -> float:
        """Seconds since the present motion began."""
        return (self.link.now() - self.under.base) * 1e-9

    def wait(self) -> None:
        """Until there is news of the driver, but not long."""
        self.link.news.wait(_LOOK)
        self.link.news.clear()

    def arrived(self, t: float) -> bool:
        """Whether the stage rests where the motion ends. Raises `Ended` if that takes too long."""
        end = self.under.motion.trajectory.end
        if abs(self.link.depth.value - end) <= self.settings.depth_tolerance and self.link.depth.stamp >= self.under.base:
            return True
        if t > self.under.motion.trajectory.duration + self.settings.settle_time:
            where = f"{self.link.depth.value * 1e3:.3f} mm instead of {end * 1e3:.3f} mm"
            raise Ended(Result.DEPTH_ERROR, f"the stage rests at {where}, {self.settings.settle_time:g} s after the end of the motion")
        return False

    def check(self) -> None:
        """Raise `Ended` for whatever stops a goal."""
        if self.cancelled():
            raise Ended(Result.CANCELLED, "cancelled")
        if self.link.peak_load > self.max_force:
            raise Ended(Result.OVER_FORCE, f"the force reached {self.link.peak_load:.2f} N, more than the allowed {self.max_force:g} N")
        self.check_driver()
        self.check_feedback()
        self.check_depth()

    def check_driver(self) -> None:
        state = self.link.state
        if state.state == DriverState.STOPPED:
            raise Ended(Result.DRIVER_FAULT, f"the driver has stopped: {state.reason or 'it gives no reason'}; call its service reset")
        if state.state == DriverState.INACTIVE:
            raise Ended(Result.DRIVER_FAULT, "the driver is not active: activate it")

    def check_feedback(self) -> None:
        if silent := self.link.silent(self.settings.feedback_timeout):
            raise Ended(Result.NO_FEEDBACK, f"no valid sample on {' and '.join(silent)} for {self.settings.feedback_timeout:g} s")

    def check_depth(self) -> None:
        depth, under = self.link.depth, self.under
        planned = float(under.motion.trajectory.sample((depth.stamp - under.base) * 1e-9).x)
        if abs(depth.value - planned) <= self.settings.depth_tolerance:
            under.off_since = None
            return
        under.off_since = under.off_since or depth.stamp
        if (depth.stamp - under.off_since) * 1e-9 > self.settings.depth_patience:
            where = f"{depth.value * 1e3:.3f} mm where {planned * 1e3:.3f} mm were asked for"
            raise Ended(Result.DEPTH_ERROR, f"the stage does not follow: it is at {where}")

    def come_to_rest(self, code: int) -> None:
        """Brake, then retract or hold. The driver sees to that itself when it has stopped; nothing moves where nothing has moved."""
        if self.under is None or code == Result.DRIVER_FAULT:
            return
        t = self.time() + _REACT * self.link.rate
        back = self.link.state.retracted_depth if self.goal.on_stop == ExecuteProfile.Goal.RETRACT else None
        travel = Travel(self.settings.retract_speed, self.link.limits.max_acceleration).within(self.link.limits)
        rest = stop(self.under.motion.trajectory.sample(t), self.link.limits, back, travel)
        if rest is not None:
            base = self.under.base + int(t * 1e9)
            self.link.send(base, rest, rest.knots(KNOT_PERIOD))
            self.see_out(base, rest.duration)

    def see_out(self, base: int, length: float) -> None:
        """Wait until a last motion of `length` s has ended, but not for a clock that stands or a driver that gave up."""
        patience = time.monotonic() + length / self.link.rate + 2.0
        while (t := (self.link.now() - base) * 1e-9) < length and time.monotonic() < patience:
            if self.link.state.state == DriverState.STOPPED or self.link.silent(2.0 * self.settings.feedback_timeout):
                return
            self.feed_back(self.time() if t < 0 else None)
            self.wait()

    def feed_back(self, t: float | None) -> None:
        """Tell the client where things stand, ten times a second; `t` (s) of the present motion, None while coming to rest."""
        if time.monotonic() - self.fed_back < 0.1:
            return
        self.fed_back = time.monotonic()
        done = self.done_before + min(max(t or 0.0, 0.0), self.under.motion.trajectory.duration)
        self.publish(
            ExecuteProfile.Feedback(
                progress=min(done / self.whole, 1.0) if self.whole else 0.0,
                segment="stop" if t is None else self.under.motion.name_at(t),
                depth=self.link.depth.value,
                force=self.link.force.value,
                peak_force=self.link.peak_force,
            )
        )

    def summary(self, code: int, sentence: str) -> Result:
        """The action's result."""
        out = Result(error_code=code, error_string=sentence)
        out.peak_force, out.peak_depth = (p if p > float("-inf") else float("nan") for p in (self.link.peak_force, self.link.peak_depth))
        if self.started is not None:
            out.started = Time(nanoseconds=self.started).to_msg()
            out.duration = max((self.link.now() - self.started) * 1e-9, 0.0)
        return out
