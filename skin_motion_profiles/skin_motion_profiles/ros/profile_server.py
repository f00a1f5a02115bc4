"""The action server `execute_profile`: moves the plunger along profiles, one goal at a time.

A goal that cannot be executed is accepted and at once aborted, because only a result carries a sentence: a second goal while one runs
ends as BUSY, a wrong profile or one beyond the driver's limits as INVALID_PROFILE, and nothing moves.
"""

import threading

from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from rclpy.task import Future
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


class ProfileServer(Node):
    """Keeps the action; every goal runs in a thread of its own, so that callbacks go on."""

    def __init__(self) -> None:
        super().__init__("profile_server")
        self.settings = Parameters(self, Settings)
        self.link = DriverLink(self)
        self.asking = Asking(self, self.settings.now)
        self.executed = self.create_publisher(String, "executed_profile", LATCHED)  # what a recording needs to be repeated
        self.running = threading.Lock()
        self.leaving = threading.Event()
        self.worker: threading.Thread | None = None
        self.action = ActionServer(self, ExecuteProfile, "execute_profile", self._execute, cancel_callback=self._on_cancel)
        self.get_logger().info("ready for goals on execute_profile")

    def _on_cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        return CancelResponse.ACCEPT

    async def _execute(self, handle: ServerGoalHandle) -> Result:
        if not self.running.acquire(blocking=False):
            handle.abort()
            return Result(error_code=Result.BUSY, error_string="another profile is running: wait for its end or cancel it")
        try:
            result = await self._in_thread(handle)
        finally:
            self.running.release()
        _conclude(handle, result)
        self.get_logger().info(f"goal ended: {result.error_string}")
        return result

    def _in_thread(self, handle: ServerGoalHandle) -> Future:
        def cancelled() -> bool:
            return handle.is_cancel_requested or self.leaving.is_set()

        goal = Run(handle.request, self.link, self.asking, self.settings.now, cancelled, handle.publish_feedback, self._announce)
        future = Future()

        def work() -> None:
            try:
                future.set_result(goal.result())
            except BaseException as error:
                future.set_exception(error)
            if self.executor is not None:
                self.executor.wake()  # nothing else resumes the waiting coroutine when the topics are silent

        self.worker = threading.Thread(target=work, name="goal", daemon=True)
        self.worker.start()
        return future

    def _announce(self, text: str) -> None:
        self.executed.publish(String(data=text))

    def destroy_node(self) -> None:
        """Let a running goal brake and retract or hold before the node goes."""
        self.leaving.set()
        if self.worker is not None:
            self.worker.join(3.0)
        super().destroy_node()


def _conclude(handle: ServerGoalHandle, result: Result) -> None:
    if result.error_code == Result.SUCCESS:
        handle.succeed()
    elif handle.is_cancel_requested:
        handle.canceled()
    else:
        handle.abort()


def main() -> None:
    """Entry point."""
    run(ProfileServer)


if __name__ == "__main__":
    main()
