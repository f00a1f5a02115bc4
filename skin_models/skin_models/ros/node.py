"""How every executable of the suite runs its node: one executor loop, clean exits, errors as one line.

    def main() -> None:
        run(DriverNode, settings=DriverSettings)

With `--help` it prints what the node is, and its parameters, and starts nothing.

Exit status: 0 after SIGINT, SIGTERM or `end()`, 2 for anything a user can mend (`SkinError`, arguments that nobody knows or that ROS cannot
parse).
A second signal ends the process at once.
"""

import os
import signal
import socket
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import rclpy
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from skin_models.errors import SkinError
from skin_models.ros.usage import usage

try:
    from rclpy.experimental import EventsExecutor
except ImportError:  # older distributions
    EventsExecutor = None

_ENDING = (signal.SIGINT, signal.SIGTERM)


class _Run:
    """What the loop, the signal thread and `end` share."""

    def __init__(self) -> None:
        self.ended, self.error, self.wake = False, None, lambda: None

    def end(self, error: SkinError | None = None) -> None:
        """End the loop; the first error is the one that is reported."""
        self.error = self.error or error
        self.ended = True
        self.wake()


_runs: list[_Run] = []


def end(error: SkinError | None = None) -> None:
    """Ask `run` to end, from any thread: with status 0, or with the error's sentence and status 2."""
    for running in _runs:
        running.end(error)


def run(
    make_node: Callable[[], Node],
    args: list[str] | None = None,
    make_executor: Callable[[], Executor] | None = None,
    settings: type | None = None,
) -> None:
    """Run the node that `make_node` gives until a signal, then exit the process. Never returns.

    `settings` is the dataclass of the node's parameters, for its help; what the help says of the node is its module's docstring.
    `make_executor` replaces the default (`quickest_executor`), for nodes that need several threads. The node's `destroy_node` is
    called while the ROS context is still alive, so that it can publish a last word.
    """
    args = sys.argv if args is None else args
    name = Path(args[0]).name if args else "node"
    try:
        own = own_arguments(args)
    except SkinError as error:
        sys.exit(_complain(name, str(error)))
    if {"-h", "--help"} & set(own):
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # `--help | head` is no accident
        print(usage(name, sys.modules[make_node.__module__].__doc__, settings))
        sys.exit(0)
    if own:
        known = "a node takes --help, and after --ros-args what ROS knows, such as -p parameter:=value"
        sys.exit(_complain(name, f"unknown argument {own[0]}: {known}"))
    sys.exit(_status(name, make_node, args, make_executor or quickest_executor))


def own_arguments(args: list[str]) -> list[str]:
    """Those that are not for ROS, without the program's name. Raises `SkinError` for what ROS cannot parse or read."""
    try:
        return remove_ros_args(args)[1:]
    except Exception as error:  # rcl's own classes
        raise SkinError(_unusable(error)) from error


def quickest_executor() -> Executor:
    """The executor with the least latency that this rclpy has."""
    return EventsExecutor() if EventsExecutor is not None else SingleThreadedExecutor()


def _status(name: str, make_node: Callable[[], Node], args: list[str], make_executor: Callable[[], Executor]) -> int:
    try:
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rcl's own classes for what it finds only now
        return _complain(name, _unusable(error))
    try:
        _spin(make_node, make_executor)
    except SkinError as error:
        return _complain(name, str(error))
    finally:
        rclpy.try_shutdown()
    return 0


def _spin(make_node: Callable[[], Node], make_executor: Callable[[], Executor]) -> None:
    running, executor = _Run(), make_executor()
    _runs.append(running)
    _end_on_signals(running)
    node = make_node()
    # `EventsExecutor.wake` does not end its `spin_once`: a task does, in every executor.
    running.wake = lambda: executor.create_task(lambda: None)
    try:
        executor.add_node(node)
        # `spin_once` in a loop, because `EventsExecutor.spin` of the Jazzy wheels dispatches nothing.
        while not running.ended and rclpy.ok():
            executor.spin_once(timeout_sec=1000.0)
    finally:
        _runs.remove(running)
        node.destroy_node()
    if running.error is not None:
        raise running.error


def _end_on_signals(running: _Run) -> None:
    """End on the first signal, exit at once on the second.

    Python runs a handler only between two bytecodes of the main thread, which may sit in the executor for long. The wake-up file
    descriptor is written at once, whatever thread receives the signal, and a thread waits for it.
    """
    wake, written = socket.socketpair()
    written.setblocking(False)
    for number in _ENDING:
        signal.signal(number, lambda *_: None)
    signal.set_wakeup_fd(written.fileno(), warn_on_full_buffer=False)

    def wait() -> None:
        with wake, written:
            wake.recv(1)
            running.end()
            os._exit(128 + wake.recv(1)[0])  # the node does not come back from its callback or its farewell

    threading.Thread(target=wait, daemon=True).start()


def _complain(name: str, sentence: str) -> int:
    print(f"{name}: {' '.join(sentence.split())}", file=sys.stderr, flush=True)
    return 2


def _unusable(error: Exception) -> str:
    return f"ROS arguments cannot be used: {str(error).split(', at ')[0]}"
