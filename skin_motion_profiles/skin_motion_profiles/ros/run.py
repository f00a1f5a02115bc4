"""One goal from its first check to its result. Every way out passes `Run.result`, so a goal always ends.

What can end a goal early, in the order in which it is looked for: cancel, over-force, a stop of the driver, silence of encoder or
load cell, a stage that does not follow. Then the plunger brakes as hard as the rig allows and retracts or holds, as the goal said.
"""

import time
import traceback
from collections.abc import Callable

from rclpy.time import Time
from skin_testbed_msgs.action import ExecuteProfile
from skin_testbed_msgs.msg import DriverState

from skin_motion_profiles.control import Controlled
from skin_motion_profiles.entry import Action, Entry
from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.moves import hold
from skin_motion_profiles.plan import Motion, Stage, Travel, rehearse, stages, stop
from skin_motion_profiles.profile_file import entry_from_text, entry_to_text
from skin_motion_profiles.profiles.place import Place
from skin_motion_profiles.ros.asking import Asking
from skin_motion_profiles.ros.driver_link import DriverLink
from skin_motion_profiles.ros.settings import Settings
from skin_motion_profiles.ros.steering import Steering
from skin_motion_profiles.ros.streaming import HEAD_START, REACTION, Stream
from skin_motion_profiles.ros.watching import Ended, Watch
from skin_motion_profiles.trajectory import Trajectory

Result = ExecuteProfile.Result
_AT_REST = 1e-9  # m/s
_CLEAR = 2e-3  # m, least retreat after an over-force: what was hit may lie above what is taken for the surface
_LOOK = 0.02  # s between two looks at the driver; messages wake it earlier
_HELD_UP = 0.5  # s; a look later than this means that this process itself stood still, longer than the driver has motion in hand
_CATCH_UP = 0.3  # s at least, after that, to receive the messages that came meanwhile

_MEETING = 5.0  # s


class Run:
    """Executes one goal in a thread of its own."""

    def __init__(
        self, goal: ExecuteProfile.Goal, link: DriverLink, asking: Asking, settings: Settings,
        cancelled: Callable[[], bool], publish: Callable[[ExecuteProfile.Feedback], None], announce: Callable[[str], None],
    ) -> None:  # fmt: skip
        """`cancelled()` tells whether the client wants the end; `publish` takes feedback, `announce` what is executed, as YAML."""
        self.goal, self.link, self.asking, self.settings = goal, link, asking, settings
        self.publish, self.announce = publish, announce
        self.watch = Watch(link, settings, goal.max_force or settings.max_force, cancelled)
        self.stream: Stream | None = None
        self.started: int | None = None
        self.done = self.whole = 0.0  # s of motion: finished stages, and the whole goal
        self.fed_back = 0.0
        self.looked = time.monotonic()

    def result(self) -> Result:
        """Execute the goal and say how it went."""
        self.link.forget_peaks()
        try:
            self.execute()
            return self.summary(Result.SUCCESS, "executed to its end")
        except ProfileError as error:
            return self.summary(Result.INVALID_PROFILE, str(error))
        except Ended as end:
            self.come_to_rest(end.code)
            why = self.watch.cause_of(end)
            return self.summary(why.code, str(why))
        except Exception as error:  # whatever it is: the plunger must not go on, and the client must hear of it
            traceback.print_exc()
            self.come_to_rest(Result.CANCELLED)
            return self.summary(Result.DRIVER_FAULT, f"the profile server itself failed ({error!r}): its log says more")

    def execute(self) -> None:
        """The goal itself. Raises `ProfileError` before anything moves, `Ended` when it cannot go on."""
        entry = self.checked_entry()
        self.meet_driver()
        self.watch.before_moving()
        self.hear()
        plan = stages(entry)
        durations = rehearse(plan, self.link.standing, self.travel(), self.link.limits)
        self.whole = sum(durations)
        self.announce(entry_to_text(entry))
        for stage, duration in zip(plan, durations, strict=True):
            match stage.entries[0]:
                case Action():
                    self.perform(stage)
                case Controlled():
                    self.steer(stage)
                case _:
                    self.follow(stage.motion(self.link.standing, self.travel()))
            self.done += duration

    def meet_driver(self) -> None:
        """Give a driver that has just been started a moment to be heard."""
        patience = time.monotonic() + _MEETING
        while not self.watch.met() and time.monotonic() < patience and not self.watch.cancelled():
            self.wait()

    def checked_entry(self) -> Entry:
        """What the goal asks for. Raises `ProfileError` where that makes no sense."""
        if not self.goal.max_force >= 0.0:
            raise ProfileError(f"max_force = {self.goal.max_force:g} N must be positive, or 0 for the server's own limit")
        if self.goal.on_stop not in (ExecuteProfile.Goal.RETRACT, ExecuteProfile.Goal.HOLD):
            raise ProfileError(f"on_stop must be 0 (RETRACT) or 1 (HOLD), not {self.goal.on_stop}")
        return entry_from_text(self.goal.profile)

    def travel(self) -> Travel:
        """How to move where no profile says how."""
        return Travel(self.settings.approach_speed, self.settings.approach_acceleration).within(self.link.limits)

    def follow(self, motion: Motion) -> None:
        """Hand a motion to the driver, piece by piece, until the stage rests at its end. Raises `Ended`."""
        self.stream = Stream(self.link, motion, self.link.now() + int(HEAD_START * self.link.rate * 1e9))
        self.started = self.started or self.stream.base
        while not self.watch.arrived(self.stream):
            self.watch.check(self.stream)
            self.stream.hand_over()
            self.feed_back(motion.name_at(self.stream.time()), self.stream.time())
            self.wait()

    def steer(self, stage: Stage) -> None:
        """Control the force until its time is over. Raises `Ended`."""
        steering = Steering(self.link, stage.entries[0], stage.names[0])
        self.started = self.started or steering.begin
        self.watch.is_quick_enough(stage.entries[0], steering.delay)
        while not (steering.over() and self.watch.arrived(steering.stream)):
            self.stream = steering.stream
            self.watch.check(self.stream)
            self.watch.finds_contact(steering)
            steering.answer()
            self.feed_back(stage.names[0], steering.time())
            self.wait()

    def perform(self, stage: Stage) -> None:
        """Do what is not a motion of ours. Raises `Ended`."""
        action: Action = stage.entries[0]
        self.watch.may_ask(action)
        poll, patience = self.asking.begin(action), time.monotonic() + self.settings.action_timeout
        self.stream = None
        try:
            while (answer := poll()) is None:
                self.watch.check(None)
                if time.monotonic() > patience:
                    raise Ended(Result.DRIVER_FAULT, f"{action.label} did not end within {self.settings.action_timeout:g} s")
                self.feed_back(stage.names[0].replace(action.label, self.asking.hint(action)), 0.0)
                self.wait()
        except Ended:
            self.interrupt(action)
            raise
        self.link.told = None  # zero has moved the plunger, and the zero of its depth
        if not answer.success:
            raise Ended(Result.DRIVER_FAULT, f"{action.label}: {answer.sentence}")
        self.hear()  # a depth that was measured before the answer still counts from the old zero

    def hear(self) -> None:
        """Wait for samples taken after this moment. Raises `Ended`."""
        mark, patience = self.link.mark(), time.monotonic() + _MEETING
        while not self.link.heard_since(mark):
            self.watch.check(None)
            if time.monotonic() > patience:
                raise Ended(Result.NO_FEEDBACK, f"no newer samples of encoder and force came within {_MEETING:g} s")
            self.wait()

    def interrupt(self, action: Action) -> None:
        """End what the driver does for `action`, and get ready to retract from there."""
        if isinstance(action, Place):
            return  # the plunger rests
        poll, patience = self.asking.end(), time.monotonic() + _MEETING
        while (answer := poll()) is None and time.monotonic() < patience and self.watch.alive():
            self.wait()
        if answer is None or not answer.success or not self.settled():
            return
        here, limits = self.link.depth.value, self.link.limits
        # Only backwards: who does not know the surface yet does not advance. Beyond the limits the driver would refuse to move.
        if self.link.state.retracted_depth < here <= limits.max_depth:
            self.stream = Stream(self.link, Motion(Trajectory(hold(here, 0.1)), ("stop",), (0.0,)), self.link.now())

    def settled(self) -> bool:
        """Whether the driver is ready again, and its samples are from after that."""
        patience = time.monotonic() + _MEETING
        while self.link.state.state != DriverState.READY:
            if time.monotonic() > patience or not self.watch.alive():
                return False
            self.wait()
        mark, self.link.told = self.link.mark(), None
        while not self.link.heard_since(mark):
            if time.monotonic() > patience or not self.watch.alive():
                return False
            self.wait()
        return True

    def wait(self) -> None:
        """Wait for news of the driver, for `_LOOK` at most. If this process itself was held up since the last look, it first receives what
        came meanwhile, so that it does not call the driver silent."""
        self.link.news.wait(_LOOK)
        if time.monotonic() - self.looked > _HELD_UP:
            self.catch_up()
        self.link.news.clear()
        self.looked = time.monotonic()

    def catch_up(self) -> None:
        """Receive what came while this process stood still, until encoder and load cell are heard again, or the driver is silent indeed."""
        resumed = time.monotonic()
        time.sleep(_CATCH_UP)
        while self.link.silent(passed := time.monotonic() - resumed) and passed < self.watch.settings.feedback_timeout:
            time.sleep(_LOOK)

    def come_to_rest(self, code: int) -> None:
        """Brake, then retract or hold. A driver that has stopped sees to that itself; where nothing of ours moves nothing is done."""
        if self.stream is None or code == Result.DRIVER_FAULT:
            return
        begin = self.stream.soon()
        back = self.link.state.retracted_depth if self.goal.on_stop == ExecuteProfile.Goal.RETRACT else None
        limits = self.link.limits
        travel = Travel(self.settings.retract_speed, limits.max_acceleration).within(limits)
        state = self.stream.motion.trajectory.sample((begin - self.stream.base) * 1e-9)
        rest = stop(state, limits, back, travel, _CLEAR if code == Result.OVER_FORCE else 0.0)
        if rest is not None:
            if abs(state.v) < _AT_REST:  # nothing to brake: begin like every other motion, so that a message may come late
                rest = Trajectory((*hold(float(state.x), (HEAD_START - REACTION) * self.link.rate), *rest.pieces))
            last = Stream(self.link, Motion(rest, ("stop",), (0.0,)), begin)
            last.hand_over(everything=True)
            self.see_out(last)

    def see_out(self, last: Stream) -> None:
        """Wait for the end of the last motion, but not for a clock that stands or a driver that gave up."""
        length = last.motion.trajectory.duration
        patience = time.monotonic() + length / self.link.rate + 2.0
        # The encoder's word counts, not the clock's: the next goal begins where it says.
        while (self.link.depth.stamp - last.base) * 1e-9 < length and time.monotonic() < patience and self.watch.alive():
            self.feed_back("stop", 0.0)
            self.wait()

    def feed_back(self, segment: str, t: float) -> None:
        """Tell the client where things stand, ten times a second: `t` (s) of the present stage."""
        if time.monotonic() - self.fed_back < 0.1:
            return
        self.fed_back = time.monotonic()
        done = self.done + max(t, 0.0)
        self.publish(
            ExecuteProfile.Feedback(
                progress=min(done / self.whole, 1.0) if self.whole else 0.0,
                segment=segment,
                depth=self.link.depth.value,
                force=self.link.force.value,
                peak_force=max(self.link.peak_force, self.link.force.value),
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
