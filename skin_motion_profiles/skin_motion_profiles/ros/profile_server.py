"""The action server `execute_profile`: moves the plunger along profiles, one goal at a time.

A goal that cannot be executed is accepted and at once aborted, because only a result carries a sentence: a second goal while one runs
ends as BUSY, a wrong profile or one beyond the driver's limits as INVALID_PROFILE, and nothing moves.
"""

import threading
import time
from collections.abc import Callable

from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from skin_testbed_msgs.action import ExecuteProfile
from std_msgs.msg import String

from skin_models.ros.node import run
from skin_models.ros.parameters import Parameters
from skin_models.ros.qos import LATCHED
from skin_motion_profiles.ros.asking import Asking
from skin_motion_profiles.ros.driver_link import DriverLink
from skin_motion_profiles.ros.run import Run
from skin_motion_profiles.ros.settings import Settings

Result = ExecuteProfile.Result
_FAREWELL = 3.0  # s, for a goal to brake, and to retract or hold
_LAST_WORD = 0.2  # s, for its result to leave


class ThreadedActionServer(ActionServer):
    """Executes every goal in a thread of its own, so that the node's callbacks go on.

    A coroutine that waits for such a thread would do the same, but `EventsExecutor` asks it again and again, at half a processor.
    """

    def notify_execute(self, goal_handle: ServerGoalHandle, execute_callback: Callable | None) -> None:
        """Called by `goal_handle.execute()`."""
        conclude = super().notify_execute

        def work() -> None:
            result = self._execute_callback(goal_handle)
            conclude(goal_handle, lambda handle: _conclude(handle, result))

        threading.Thread(target=work, name="goal", daemon=True).start()


class ProfileServer(Node):
    """Keeps the action and what its goals need of the driver."""

    def __init__(self) -> None:
        """Declare the parameters, and be ready for goals. Raises `SkinError` for a parameter that makes no sense."""
        super().__init__("profile_server")
        self.settings = Parameters(self, Settings)
        self.link = DriverLink(self)
        self.asking = Asking(self, self.settings.now)
        self.executed = self.create_publisher(String, "executed_profile", LATCHED)  # what a recording needs to be repeated
        self.running = threading.Lock()
        self.leaving = threading.Event()
        self.action = ThreadedActionServer(self, ExecuteProfile, "execute_profile", self._execute, cancel_callback=self._on_cancel)
        self.get_logger().info("ready for goals on execute_profile")

    def _on_cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        return CancelResponse.ACCEPT

    def _execute(self, handle: ServerGoalHandle) -> Result:
        if not self.running.acquire(blocking=False):
            return Result(error_code=Result.BUSY, error_string="another profile is running: wait for its end or cancel it")

        def cancelled() -> bool:
            return handle.is_cancel_requested or self.leaving.is_set()

        try:
            goal = Run(handle.request, self.link, self.asking, self.settings.now, cancelled, handle.publish_feedback, self._announce)
            result = goal.result()
        finally:
            self.running.release()
        self.get_logger().info(f"goal ended: {result.error_string}")
        return result

    def _announce(self, text: str) -> None:
        self.executed.publish(String(data=text))

    def destroy_node(self) -> None:
        """Let a running goal brake and retract or hold before the node goes."""
        self.leaving.set()
        if self.running.locked():
            self._spin_until(lambda: not self.running.locked(), _FAREWELL)
            self._spin_until(lambda: False, _LAST_WORD)
        super().destroy_node()

    def _spin_until(self, condition: Callable[[], bool], patience: float) -> None:
        """Let the client hear how its goal ends, though the loop of the node has ended."""
        end = time.monotonic() + patience
        while not condition() and time.monotonic() < end and self.executor is not None:
            self.executor.spin_once(timeout_sec=0.02)


def _conclude(handle: ServerGoalHandle, result: Result) -> Result:
    if result.error_code == Result.SUCCESS:
        handle.succeed()
    elif handle.is_cancel_requested:
        handle.canceled()
    else:
        handle.abort()
    return result


def main() -> None:
    """Entry point."""
    run(ProfileServer, settings=Settings)


if __name__ == "__main__":
    main()
