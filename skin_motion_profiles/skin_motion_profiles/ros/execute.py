"""Execute one profile or battery from the command line.

    ros2 run skin_motion_profiles execute full depth_mm=0.8 seed=3
    ros2 run skin_motion_profiles execute '{type: sine, amplitude_mm: 0.3, frequency_hz: 0.5}' --max-force 20 --hold
    ros2 run skin_motion_profiles execute my_profile.yaml
    ros2 run skin_motion_profiles execute --list

Exit status: 0 the profile was executed, 1 it was not (the sentence says why), 2 the input cannot be used. Ctrl-C cancels the goal and
waits for the plunger to retract or hold.
"""

import argparse
import contextlib
import signal
import sys
import time
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from skin_testbed_msgs.action import ExecuteProfile

from skin_models.errors import SkinError
from skin_models.ros.node import own_arguments
from skin_motion_profiles.describe import description, overview
from skin_motion_profiles.profile_file import entry_from_words, entry_to_text
from skin_motion_profiles.ros.progress import ProgressLine

_PATIENCE = 10.0  # s to find the server
_SILENCE = 3.0  # s without feedback after which a server that is no longer there is given up


class Client(Node):
    """One goal and its end."""

    def __init__(self, show: ProgressLine, interrupt: "Interrupt") -> None:
        """`show` gets the feedback, `interrupt` tells whether the user wants the end."""
        super().__init__("execute")
        self.client = ActionClient(self, ExecuteProfile, "execute_profile")
        self.show, self.interrupt, self.heard = show, interrupt, time.monotonic()
        self.spinner = SingleThreadedExecutor()
        self.spinner.add_node(self)

    def execute(self, goal: ExecuteProfile.Goal) -> ExecuteProfile.Result:
        """Send the goal and wait for its result. Raises `SkinError` where there is no server, or no longer."""
        ready = self.client.server_is_ready
        self._until(lambda: ready() or self.interrupt.wanted, "there is no server of the action execute_profile: start profile_server")
        if self.interrupt.wanted:
            raise SkinError("interrupted before the goal was sent")
        sent = self.client.send_goal_async(goal, feedback_callback=self._on_feedback)
        # Once sent, only its handle can take a goal back: an interruption waits for that, or the plunger moves with nobody there.
        self._until(sent.done, "the profile server does not answer")
        handle = sent.result()
        if not handle.accepted:
            raise SkinError("the profile server did not accept the goal")
        result, cancelling = handle.get_result_async(), False
        while not result.done():
            self.spinner.spin_once(timeout_sec=0.1)
            if self.interrupt.wanted and not cancelling:
                cancelling = True
                handle.cancel_goal_async()
            self._still_there()
        return result.result().result

    def close(self) -> None:
        """Let go of ROS in order: an executor that outlives its context complains."""
        self.spinner.shutdown()
        self.destroy_node()
        rclpy.try_shutdown()

    def _until(self, condition: Callable[[], Any], complaint: str) -> None:
        end = time.monotonic() + _PATIENCE
        while not condition():
            if time.monotonic() > end:
                raise SkinError(complaint)
            self.spinner.spin_once(timeout_sec=0.1)
        self.heard = time.monotonic()

    def _still_there(self) -> None:
        if time.monotonic() - self.heard > _SILENCE and not self.client.server_is_ready():
            raise SkinError("the profile server has gone: the driver stops the plunger by itself")

    def _on_feedback(self, message: Any) -> None:
        self.heard = time.monotonic()
        self.show.update(message.feedback)


class Interrupt:
    """Ctrl-C, or SIGTERM: the first asks for the end of the goal, the second does not wait for it."""

    def __init__(self) -> None:
        """From now on, for this process."""
        self.wanted = False
        signal.signal(signal.SIGINT, self._on_signal)
        signal.signal(signal.SIGTERM, self._on_signal)

    def _on_signal(self, *_: object) -> None:
        if self.wanted:
            sys.exit(1)
        self.wanted = True


def main() -> None:
    """Entry point."""
    sys.exit(_status(sys.argv))


def _status(argv: list[str]) -> int:
    try:
        options = _options(own_arguments(argv))
        goal = ExecuteProfile.Goal(
            profile=entry_to_text(entry_from_words(options.profile, options.settings)),
            max_force=options.max_force,
            on_stop=ExecuteProfile.Goal.HOLD if options.hold else ExecuteProfile.Goal.RETRACT,
        )
    except SkinError as error:
        return _complain(error, 2)
    interrupt = Interrupt()
    rclpy.init(args=argv, signal_handler_options=SignalHandlerOptions.NO)
    show = ProgressLine(sys.stdout)
    client = Client(show, interrupt)
    try:
        result = client.execute(goal)
    except SkinError as error:
        show.close()
        return _complain(error, 1)
    finally:
        client.close()
    show.close()
    return _report(result)


def _options(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="execute", description="Execute a profile or a battery on the testbed.")
    parser.add_argument("--list", action=Show, nargs=0, show=lambda _: overview(), help="list profiles and batteries")
    parser.add_argument("--describe", action=Show, show=description, metavar="TYPE", help="tell the parameters of a profile")
    parser.add_argument("profile", help="the name of a battery or a profile, a YAML file, or YAML text such as '{type: step, depth_mm: 1}'")
    parser.add_argument("settings", nargs="*", default=[], metavar="key=value", help="arguments of a battery, parameters of a profile")
    parser.add_argument("--max-force", type=_force, default=0.0, metavar="N", help="end the goal above this; default: the server's limit")
    parser.add_argument("--hold", action="store_true", help="on cancel, over-force or a fault stay where you are; default: retract")
    return parser.parse_args(arguments)


class Show(argparse.Action):
    """An option that prints something and ends, as --help does."""

    def __init__(self, *words: Any, show: Callable[[Any], str], **more: Any) -> None:
        """`show(value)` gives what to print; the rest is argparse's."""
        super().__init__(*words, **more)
        self._show = show

    def __call__(self, parser: argparse.ArgumentParser, namespace: Any, value: Any, option: Any = None) -> None:
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # `execute --list | head` is no accident
        try:
            print(self._show(value))
        except SkinError as error:
            parser.exit(_complain(error, 2))
        parser.exit(0)


def _force(word: str) -> float:
    with contextlib.suppress(ValueError):  # of which argparse would make a message that names this function
        if 0.0 < (value := float(word)) < float("inf"):
            return value
    raise argparse.ArgumentTypeError(f"{word!r} must be a positive number of newtons, such as 20")


def _report(result: ExecuteProfile.Result) -> int:
    numbers = f"{result.duration:.1f} s, peak force {result.peak_force:.2f} N, greatest depth {result.peak_depth * 1e3:.3f} mm"
    if result.error_code == ExecuteProfile.Result.SUCCESS:
        print(f"{result.error_string}: {numbers}", flush=True)
        return 0
    name = next(n for n in _CODES if getattr(ExecuteProfile.Result, n) == result.error_code)
    print(f"execute: {name}: {result.error_string}" + (f" ({numbers})" if result.duration > 0.0 else ""), file=sys.stderr, flush=True)
    return 2 if result.error_code == ExecuteProfile.Result.INVALID_PROFILE else 1


_CODES = ("INVALID_PROFILE", "BUSY", "CANCELLED", "OVER_FORCE", "NO_FEEDBACK", "DRIVER_FAULT", "DEPTH_ERROR")


def _complain(error: Exception, status: int) -> int:
    print(f"execute: {' '.join(str(error).split())}", file=sys.stderr, flush=True)
    return status


if __name__ == "__main__":
    main()
