"""Call a service of the driver from the command line, also where no `ros2` is installed.

    ros2 run skin_testbed_driver call reset                                  # after a stop, when its cause is gone
    ros2 run skin_testbed_driver call zero                                   # find the surface; also tare, reset_tare, stop, cancel
    ros2 run skin_testbed_driver call reset --ros-args -r __ns:=/left        # of a driver in a namespace

Exit status: 0 it was done, 1 it was not (the sentence says why), 2 the arguments cannot be used. Ctrl-C ends a search for the surface or a
tare that is under way, and leaves the driver ready.
"""

import argparse
import signal
import sys
import time
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from skin_testbed_msgs.srv import Tare, Zero
from std_srvs.srv import Trigger

from skin_models.errors import SkinError
from skin_models.ros.node import own_arguments

SERVICES = {
    "reset": (Trigger, "end a stop; refused while its cause is still there"),
    "zero": (Zero, "find the surface, from where depths count"),
    "tare": (Tare, "take the mean of the unloaded sensors for their zero; refused nearer than 0.1 mm to the surface"),
    "reset_tare": (Trigger, "subtract nothing any more"),
    "stop": (Trigger, "brake, and stay stopped until a reset"),
    "cancel": (Trigger, "end zero or tare, and stay ready"),
}
_LASTING = ("zero", "tare")
_PATIENCE = 10.0  # s to find the driver
_LOOK = 0.1  # s


class Caller(Node):
    """Calls one service after the other of the driver `driver`."""

    def __init__(self, driver: str) -> None:
        """`driver` is the name of its node; the namespace is that of this one."""
        super().__init__("call")
        self._driver = driver
        self._interrupted = False
        self._spinner = SingleThreadedExecutor()
        self._spinner.add_node(self)

    def interrupt(self) -> None:
        """Ask for the end of what lasts; the second time, end at once."""
        if self._interrupted:
            sys.exit(1)
        self._interrupted = True

    def call(self, name: str) -> Any:
        """Call one service, and give its response. Raises `SkinError` where nobody answers."""
        kind, _ = SERVICES[name]
        client = self.create_client(kind, f"{self._driver}/{name}")
        deadline = time.monotonic() + _PATIENCE
        service = self.resolve_service_name(client.srv_name)
        absent = f"nobody offers the service {service}: does driver_node run, in the same ROS domain and namespace?"
        self._until(lambda: client.service_is_ready() or self._interrupted, lambda: time.monotonic() > deadline, absent)
        if self._interrupted:
            raise SkinError(f"interrupted before {name} was called")
        answer = client.call_async(kind.Request())
        self._until(lambda: answer.done() or self._interrupted, lambda: not client.service_is_ready(), "the driver has gone")
        if not answer.done():
            if name in _LASTING:
                self._interrupted = False
                self.call("cancel")
            self._until(answer.done, lambda: not client.service_is_ready(), "the driver has gone")
        return answer.result()

    def close(self) -> None:
        """Let go of ROS in order: an executor that outlives its context complains."""
        self._spinner.shutdown()
        self.destroy_node()
        rclpy.try_shutdown()

    def _until(self, condition: Callable[[], bool], hopeless: Callable[[], bool], complaint: str) -> None:
        while not condition():
            if hopeless():
                raise SkinError(complaint)
            self._spinner.spin_once(timeout_sec=_LOOK)


def main() -> None:
    """Entry point."""
    sys.exit(_status(sys.argv))


def _status(argv: list[str]) -> int:
    try:
        chosen = _parser().parse_args(own_arguments(argv))
    except SkinError as error:
        return _complain(error, 2)
    rclpy.init(args=argv, signal_handler_options=SignalHandlerOptions.NO)
    caller = Caller(chosen.driver)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: caller.interrupt())
    try:
        response = caller.call(chosen.service)
    except SkinError as error:
        return _complain(error, 1)
    finally:
        caller.close()
    if not response.success:
        return _complain(f"{chosen.service}: {response.message}", 1)
    print(f"{chosen.service}: {response.message}", flush=True)
    return 0


def _parser() -> argparse.ArgumentParser:
    told = "\n".join(f"  {name:12s} {about}" for name, (_, about) in SERVICES.items())
    formatted = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="call", description=f"Call a service of the driver:\n\n{told}", formatter_class=formatted)
    parser.add_argument("service", choices=SERVICES, metavar="SERVICE", help=f"one of {', '.join(SERVICES)}")
    parser.add_argument("--driver", default="testbed_driver", metavar="NAME", help="name of the driver's node; default: testbed_driver")
    return parser


def _complain(error: Exception | str, status: int) -> int:
    print(f"call: {' '.join(str(error).split())}", file=sys.stderr, flush=True)
    return status


if __name__ == "__main__":
    main()
