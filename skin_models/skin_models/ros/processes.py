"""Start installed executables, wait for them with a bound, and end them by process id. For tests, benches and the demo.

    with Domain() as domain, Processes(domain.environment()) as processes:
        driver = processes.start("skin_testbed_driver", "driver_node", parameters={"seed": 1})
        driver.wait_for_output("ready", 20.0)

Works from the installed files alone: no `ros2` command line, and no launch but for `Launch`.
"""

import ctypes
import os
import random
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml
from ament_index_python.packages import PackageNotFoundError, get_package_prefix

from skin_models.errors import SkinError

# Above 101 the ports of a domain reach into the range from which Linux hands out ephemeral ports.
_DOMAINS = range(1, 102)
_PR_SET_PDEATHSIG = 1  # linux/prctl.h

# What `ros2 launch` does with a file and arguments such as `model:=a.yaml`.
_LAUNCH = """
import sys
from launch import LaunchDescription, LaunchService
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
source = PythonLaunchDescriptionSource(sys.argv[1])
pairs = [argument.split(":=", 1) for argument in sys.argv[2:]]
service = LaunchService()
service.include_launch_description(LaunchDescription([IncludeLaunchDescription(source, launch_arguments=pairs)]))
sys.exit(service.run())
"""


def executable(package: str, name: str) -> Path:
    """The installed file of `ros2 run package name`. Raises `SkinError` if it is not there."""
    try:
        path = Path(get_package_prefix(package)) / "lib" / package / name
    except PackageNotFoundError as error:
        raise SkinError(f"package {package} is not installed or not sourced: build the workspace and source its setup") from error
    if not path.is_file():
        raise SkinError(f"package {package} has no executable {name}: build the workspace again")
    return path


def wait_until(condition: Callable[[], Any], timeout: float, what: str, period: float = 0.02) -> Any:
    """Poll `condition` until it is true, and return what it gave. Raises `SkinError` naming `what` after `timeout` seconds."""
    deadline = time.monotonic() + timeout
    while True:
        if result := condition():
            return result
        if time.monotonic() > deadline:
            raise SkinError(f"waited {timeout:g} s in vain for {what}")
        time.sleep(period)


class Domain:
    """A ROS domain that nobody else on this machine uses: claimed by a name that `./skin` respects too, and held while open."""

    def __init__(self) -> None:
        """Claim one. Raises `SkinError` where all are in use."""
        self._claim, self.id = _free_domain()

    def environment(self) -> dict[str, str]:
        """The variables that confine ROS to this machine and this domain."""
        return {"ROS_DOMAIN_ID": str(self.id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}

    def __enter__(self) -> "Domain":
        return self

    def __exit__(self, *_: object) -> None:
        self._claim.close()


def _free_domain() -> tuple[socket.socket, int]:
    for domain in random.SystemRandom().sample(_DOMAINS, len(_DOMAINS)):
        claim = socket.socket(socket.AF_UNIX)
        try:
            claim.bind(f"\0skin_testbed_domain_{domain}")  # abstract: no file, and gone with its holder
            return claim, domain
        except OSError:
            claim.close()
    raise SkinError("every ROS domain is in use by another test run: wait for one to end")


class Process:
    """One running executable. Its output, both streams, is kept in a file."""

    def __init__(self, command: Sequence[str], environment: Mapping[str, str], label: str) -> None:
        """Start `command` with `environment` on top of this process's; `label` is what errors call it."""
        self.label = label
        self._log = tempfile.NamedTemporaryFile(prefix="skin_", suffix=".log")  # noqa: SIM115  (closed by `end`)
        self._popen = subprocess.Popen(
            command, env={**os.environ, "PYTHONUNBUFFERED": "1", **environment}, stdin=subprocess.DEVNULL,
            stdout=self._log, stderr=subprocess.STDOUT, start_new_session=True, preexec_fn=_die_with_parent(),
        )  # fmt: skip

    @property
    def pid(self) -> int:
        """Process id."""
        return self._popen.pid

    @property
    def status(self) -> int | None:
        """Exit status, negative for a signal; None while it runs."""
        return self._popen.poll()

    def output(self) -> str:
        """Everything it has written so far."""
        return Path(self._log.name).read_text(errors="replace")

    def wait_for_output(self, pattern: str, timeout: float) -> re.Match:
        """Wait until its output matches a regular expression. Raises `SkinError` with the output if it ends or takes too long."""

        def found() -> re.Match | None:
            match = re.search(pattern, self.output())
            if match is None and self.status is not None:
                raise SkinError(f"{self.label} ended with {self.status} before {pattern!r}: {self.output()[-2000:]}")
            return match

        return wait_until(found, timeout, f"{pattern!r} from {self.label}")

    def wait(self, timeout: float) -> int:
        """Wait for its end; returns the exit status. Raises `SkinError` after `timeout` seconds."""
        wait_until(lambda: self.status is not None, timeout, f"the end of {self.label}")
        return self._popen.returncode

    def send(self, number: int) -> None:
        """Send a signal, if it still runs."""
        if self.status is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        """End it without any farewell (SIGKILL), as a crash would."""
        self.send(signal.SIGKILL)
        self._popen.wait()

    def end(self, patience: float = 5.0) -> int:
        """Ask it to end (SIGINT), after `patience` seconds kill it; returns the exit status."""
        self.send(signal.SIGINT)
        try:
            return self._popen.wait(patience)
        except subprocess.TimeoutExpired:
            self.kill()
            return self._popen.returncode


class Launch(Process):
    """A running launch file, where launch is installed. Signals reach all that it has started, too, as ctrl-c in its terminal does."""

    def __init__(self, file: Path, arguments: Sequence[str], environment: Mapping[str, str]) -> None:
        """Start `file` as `ros2 launch` does, with `arguments` such as `model:=a.yaml`."""
        super().__init__([sys.executable, "-c", _LAUNCH, str(file), *arguments], environment, file.name)

    def send(self, number: int) -> None:
        """Send a signal to it and to what it has started, if it still runs."""
        if self.status is None:
            os.killpg(self.pid, number)


def _die_with_parent() -> Callable[[], None] | None:
    """Let the kernel kill the child when this process dies, however it dies: nobody is left behind by a test that was killed.

    The kernel means the thread that starts the child, so only the main thread may ask for this.
    """
    if not sys.platform.startswith("linux") or threading.current_thread() is not threading.main_thread():
        return None
    libc = ctypes.CDLL(None)
    return lambda: libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


class Processes:
    """The processes of one test or demo; leaving the block ends them all, the last started first."""

    def __init__(self, environment: Mapping[str, str] | None = None) -> None:
        """`environment` is for all of them, on top of this process's."""
        self._environment = dict(environment or {})
        self.running: list[Process] = []

    def start(
        self,
        package: str,
        name: str,
        arguments: Sequence[str] = (),
        parameters: Mapping[str, Any] | None = None,
        remap: Mapping[str, str] | None = None,
        environment: Mapping[str, str] | None = None,
    ) -> Process:
        """Start an installed executable with ROS parameters and remappings. Raises `SkinError` if it is not installed."""
        command = [str(executable(package, name)), *arguments, *_ros_arguments(parameters or {}, remap or {})]
        process = Process(command, {**self._environment, **(environment or {})}, name)
        self.running.append(process)
        return process

    def end(self) -> None:
        """End all, the last started first."""
        while self.running:
            self.running.pop().end()

    def __enter__(self) -> "Processes":
        return self

    def __exit__(self, *_: object) -> None:
        self.end()


def _ros_arguments(parameters: Mapping[str, Any], remap: Mapping[str, str]) -> list[str]:
    if not parameters and not remap:
        return []
    values = [x for name, value in parameters.items() for x in ("-p", f"{name}:={_as_yaml(value)}")]
    return ["--ros-args", *values, *(x for a, b in remap.items() for x in ("-r", f"{a}:={b}"))]


def _as_yaml(value: Any) -> str:
    text = yaml.safe_dump(list(value) if isinstance(value, tuple) else value, default_flow_style=True, width=10**6)
    return text.removesuffix("...\n").strip()
