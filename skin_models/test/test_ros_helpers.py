"""How nodes run, declare parameters and are started: a small node of the test, as a real process."""

import signal
import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from skin_models.errors import SkinError
from skin_models.ros.processes import Domain, Process, executable, wait_until

NODE = """
import os
from dataclasses import dataclass
from rclpy.node import Node
from rclpy.parameter import Parameter
from skin_models.errors import SkinError
from skin_models.ros.node import end, run
from skin_models.ros.parameters import Parameters, setting

@dataclass(frozen=True)
class Settings:
    rate: float = setting(100.0, "Hz, how often", lower=1.0, upper=1000.0)
    kind: str = setting("a", "which", choices=("a", "b"))
    ports: tuple[float, ...] = setting((), "some numbers")
    fast: float = setting(200.0, "Hz, at least rate", lower=1.0, upper=1000.0)

    def __post_init__(self):
        if self.fast < self.rate:
            raise SkinError(f"fast ({self.fast}) must be at least rate ({self.rate})")

class Small(Node):
    def __init__(self):
        super().__init__("small")
        self.parameters = Parameters(self, Settings)
        for name, value in (("rate", 50.0), ("rate", 5000.0), ("rate", 300.0), ("kind", "c"), ("rate", float("nan"))):
            result = self.set_parameters([Parameter(name, value=value)])[0]
            print(name, value, result.successful, result.reason)
        print("ready", self.parameters.now, flush=True)
        if os.environ.get("SMALL") == "fails":
            end(SkinError("the disk is full: free some room"))
        if os.environ.get("SMALL") == "ends":
            end()

    def destroy_node(self):
        print("farewell", flush=True)
        super().destroy_node()

run(Small)
"""


@pytest.fixture(scope="module")
def domain():
    with Domain() as domain:
        yield domain


@pytest.fixture
def start(domain, tmp_path):
    started = []

    def start(*arguments, story=""):
        script = tmp_path / "small.py"
        script.write_text(NODE)
        environment = {**domain.environment(), "SMALL": story}
        started.append(Process([sys.executable, str(script), *arguments], environment, "small"))
        return started[-1]

    yield start
    for process in started:
        process.kill()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_end_an_idle_node_with_its_farewell_and_status_0(start, number):
    process = start()
    process.wait_for_output("ready", 60.0)
    process.send(number)
    assert process.wait(30.0) == 0
    assert process.output().rstrip().endswith("farewell")


def test_a_node_ends_by_itself(start):
    assert start(story="ends").wait(60.0) == 0


def test_a_skin_error_is_one_line_and_status_2(start):
    process = start(story="fails")
    assert process.wait(60.0) == 2
    assert process.output().rstrip().endswith("small.py: the disk is full: free some room")
    assert "Traceback" not in process.output()


def test_parameters_are_checked_on_set_one_by_one_and_together(start):
    process = start(story="ends")
    assert process.wait(60.0) == 0
    lines = [line.split(" ", 3) for line in process.output().splitlines() if line.startswith(("rate", "kind"))]
    assert [line[2] for line in lines] == ["True", "False", "False", "False", "False"]
    assert "fast" in lines[2][3] and "a, b" in lines[3][3]
    assert "rate=50.0" in process.output()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["-p", "rate:=5"], "decimal point"),
        (["-p", "rate:=5000.0"], "between 1.0 and 1000.0"),
        (["-p", "kind:=c"], "one of a, b"),
        (["-p", "ports:=[a]"], "list"),
        (["-p", "rate:=300.0"], "fast (200.0) must be at least rate (300.0)"),
    ],
)
def test_a_start_with_values_that_cannot_be_used_is_one_line_and_status_2(start, arguments, words):
    process = start("--ros-args", *arguments)
    assert process.wait(60.0) == 2
    assert words in process.output() and len(process.output().splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(["--params-file", "no_such.yaml"], "'--params-file no_such.yaml'. Error: Error opening YAML file"), (["-p", "rate"], "'-p rate'")],
)
def test_what_ros_cannot_parse_is_one_line_and_status_2(start, arguments, words):
    process = start("--ros-args", *arguments)
    assert process.wait(60.0) == 2
    assert words in process.output() and process.output().startswith("small.py: ROS arguments cannot be used: ")
    assert len(process.output().splitlines()) == 1


@pytest.mark.parametrize("arguments", [["--frob"], ["--frob", "--ros-args", "-p", "rate:=20.0"], ["--ros-args", "--", "--frob"]])
def test_an_argument_that_nobody_knows_is_one_line_and_status_2(start, arguments):
    process = start(*arguments)
    assert process.wait(60.0) == 2
    assert process.output().startswith("small.py: unknown argument --frob: ") and len(process.output().splitlines()) == 1


def test_a_slip_in_a_name_is_warned_of(start):
    process = start("--ros-args", "-p", "rtae:=5.0", "-p", "rate:=20.0", "-p", "use_sim_time:=false", story="ends")
    assert process.wait(60.0) == 0
    warnings = [line for line in process.output().splitlines() if "WARN" in line]
    assert len(warnings) == 1 and "parameter rtae is not known here" in warnings[0] and "mean rate" in warnings[0]


def test_what_is_not_installed_is_named():
    with pytest.raises(SkinError, match="no_such_package is not installed"):
        executable("no_such_package", "node")
    with pytest.raises(SkinError, match="no executable nothing"):
        executable("skin_models", "nothing")


def test_waiting_is_bounded_and_says_for_what():
    with pytest.raises(SkinError, match="for rain"):
        wait_until(lambda: False, 0.05, "rain")


def test_two_domains_differ():
    with Domain() as a, Domain() as b:
        assert a.id != b.id


def test_no_process_outlives_a_parent_that_is_killed(domain, tmp_path):
    script = tmp_path / "parent.py"
    script.write_text(
        "import sys, time\nfrom skin_models.ros.processes import Process\n"
        "print(Process([sys.executable, '-c', 'import time; time.sleep(600)'], {}, 'child').pid, flush=True)\ntime.sleep(600)\n"
    )
    parent = Process([sys.executable, str(script)], domain.environment(), "parent")
    child = int(parent.wait_for_output(r"\d+", 60.0)[0])
    parent.kill()
    wait_until(lambda: not _runs(child), 30.0, "the end of the child")


def _runs(pid: int) -> bool:
    stat = Path(f"/proc/{pid}/stat")
    return stat.is_file() and stat.read_text().rsplit(")", 1)[1].split()[0] != "Z"


NODES = {
    ("skin_models", "skin_node"): "spread_width:=0.0",
    ("skin_models", "mujoco_finger"): "skin_frame:=skin",
    ("skin_motion_profiles", "profile_server"): "max_force:=",
    ("skin_testbed_driver", "driver_node"): "sample_rate:=100.0\n      Hz, synchronous samples per second; from 1 to 1000; cannot",
    ("skin_testbed_driver", "recorder"): "exclude:=[/rosout, /parameter_events]",
    ("skin_ident", "ident_node"): "window:=30.0",
}


@pytest.mark.parametrize(("package", "name"), NODES)
def test_help_tells_the_parameters_and_starts_nothing(domain, package, name):
    process = Process([str(executable(package, name)), "--help"], domain.environment(), name)
    assert process.wait(30.0) == 0
    said = process.output()
    assert said.startswith(f"usage: {name} [--ros-args") and NODES[package, name] in said and "Traceback" not in said
    assert "[INFO]" not in said and all(len(line) <= 141 for line in said.splitlines())
