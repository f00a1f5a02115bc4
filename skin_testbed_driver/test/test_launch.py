"""The launch file: what it starts is installed and takes the parameters; where launch is installed, it runs."""

import ast
import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("skin_testbed_msgs")

from skin_models.ros.processes import Domain, Launch, executable
from skin_testbed_driver.ros.driver_settings import DriverSettings
from skin_testbed_driver.ros.recorder import RecorderSettings

LAUNCH = Path(__file__).parents[1] / "launch" / "testbed_launch.py"


def nodes() -> list[dict[str, ast.expr]]:
    """The keywords of every Node in the launch file."""
    calls = [n for n in ast.walk(ast.parse(LAUNCH.read_text())) if isinstance(n, ast.Call) and getattr(n.func, "id", "") == "Node"]
    return [{k.arg: k.value for k in call.keywords if k.arg} for call in calls]


def named(value: ast.expr) -> str:
    return "skin_testbed_driver" if isinstance(value, ast.Name) else ast.literal_eval(value)


def test_every_executable_of_ours_is_installed():
    ours = [(named(n["package"]), named(n["executable"])) for n in nodes() if named(n["package"]).startswith("skin_")]
    assert len(ours) == 4
    for package, name in ours:
        assert executable(package, name)


def test_every_parameter_that_it_sets_exists():
    from skin_models.ros.skin_settings import SkinSettings

    known = {"driver_node": DriverSettings, "recorder": RecorderSettings, "skin_node": SkinSettings}
    for node in nodes():
        settings = known.get(named(node["executable"]))
        keys = {k.value for d in ast.walk(node["parameters"]) if isinstance(d, ast.Dict) for k in d.keys}
        assert settings is None or keys <= set(settings.__dataclass_fields__), node


def test_rviz_is_given_the_frames_that_it_draws_in():
    condition = next(ast.unparse(n["condition"]) for n in nodes() if named(n["package"]) == "robot_state_publisher")
    assert "'describe'" in condition and "'rviz'" in condition


def test_its_parts_work_together_started_one_by_one(graph):
    """What `./skin run` does where there is no launch: the same executables, by hand."""
    from rclpy.action import ActionClient
    from skin_testbed_msgs.action import ExecuteProfile
    from skin_testbed_msgs.msg import TaxelArray

    graph.driver()
    for package, name, parameters in (
        ("skin_motion_profiles", "profile_server", {}),
        ("skin_models", "skin_node", {"model": "silicone_4mm", "drive": "encoder"}),
    ):
        remap = {"force": "simulated/force", "taxels": "simulated/taxels"} if name == "skin_node" else None
        graph.processes.start(package, name, parameters={"use_sim_time": True, **parameters}, remap=remap)
    simulated = graph.hear(TaxelArray, "simulated/taxels")
    client = ActionClient(graph.node, ExecuteProfile, "execute_profile")
    graph.wait(lambda: client.server_is_ready() and simulated, "the profile server and the simulated skin")
    sent = client.send_goal_async(ExecuteProfile.Goal(profile="{type: step, depth_mm: 0.5, hold_s: 1}"))
    graph.wait(sent.done, "the goal")
    ended = sent.result().get_result_async()
    graph.wait(ended.done, "its end")
    assert ended.result().result.error_code == ExecuteProfile.Result.SUCCESS, ended.result().result.error_string
    graph.wait(lambda: max((m.force[0] for m in simulated), default=0.0) > 3.0, "the simulated skin beside the rig")


@pytest.mark.skipif(importlib.util.find_spec("launch_ros") is None, reason="launch is not installed")
def test_the_launch_file_brings_up_and_takes_down_the_testbed(tmp_path):
    with Domain() as domain:
        arguments = [f"record:={tmp_path / 's'}", "time_scale:=5.0", "namespace:=left", "compare:=silicone_4mm"]
        launch = Launch(LAUNCH, arguments, domain.environment())
        try:
            for words in ("sampling at 100 Hz", "ready for goals", "recording to", "silicone 4 mm"):
                launch.wait_for_output(words, 90.0)
        finally:
            ended = launch.end(30.0)
    assert ended == 0 and len(re.findall("has finished cleanly", launch.output())) == 4, launch.output()
    assert list((tmp_path / "s").glob("*.mcap"))


@pytest.mark.skipif(importlib.util.find_spec("launch_ros") is None, reason="launch is not installed")
def test_it_tells_its_arguments():
    show = "from launch.launch_description_sources import get_launch_description_from_python_launch_file as g\nimport sys\n"
    show += "print(*(a.name + ': ' + a.description for a in g(sys.argv[1]).get_launch_arguments()), sep='\\n')"
    shown = subprocess.run(
        [sys.executable, "-c", show, str(LAUNCH)], capture_output=True, text=True, check=True, env=dict(os.environ)
    ).stdout
    assert "record: directory to record into" in shown and len(shown.splitlines()) == 8
