"""The launch file: what it starts is installed and takes the parameters; where launch is installed, it runs."""

import ast
import importlib.util
from pathlib import Path

import pytest

pytest.importorskip("skin_testbed_msgs")

from ament_index_python.packages import get_package_prefix
from skin_testbed_msgs.msg import TaxelArray, TaxelLayout

from skin_models.ros.processes import Launch, executable
from skin_models.ros.qos import LATCHED
from skin_models.ros.skin_settings import SkinSettings

LAUNCH = Path(__file__).parents[1] / "launch" / "skin_launch.py"


def calls(name: str) -> list[ast.Call]:
    """All calls of a name in the launch file."""
    return [n for n in ast.walk(ast.parse(LAUNCH.read_text())) if isinstance(n, ast.Call) and getattr(n.func, "id", "") == name]


def test_its_node_and_parameters_are_installed_and_the_node_has_those_that_it_sets():
    ((node,), (config,)) = calls("Node"), calls("PathJoinSubstitution")
    given = {k.arg: k.value for k in node.keywords}
    package = ast.literal_eval(given["package"])
    assert executable(package, ast.literal_eval(given["executable"]))
    keys = {key.value for each in ast.walk(given["parameters"]) if isinstance(each, ast.Dict) for key in each.keys}
    assert keys and keys <= set(SkinSettings.__dataclass_fields__)
    share = Path(get_package_prefix(package)) / "share" / package
    assert share.joinpath(*map(ast.literal_eval, config.args[0].elts[1:])).is_file() and (share / "launch" / LAUNCH.name).is_file()


@pytest.mark.skipif(importlib.util.find_spec("launch_ros") is None, reason="launch is not installed")
def test_it_brings_up_a_patch_of_skin_and_takes_it_down(graph):
    layouts, taxels = graph.hear(TaxelLayout, "hand/taxel_layout", LATCHED), graph.hear(TaxelArray, "hand/taxels")
    launch = Launch(LAUNCH, ["namespace:=hand", "model:=silicone_2mm"], graph.environment)
    try:
        launch.wait_for_output("silicone 2 mm", 90.0)
        graph.until(lambda: layouts and taxels, "skin")
        assert len(layouts[0].positions) == len(taxels[0].force) == 81
    finally:
        ended = launch.end(30.0)
    assert ended == 0 and "has finished cleanly" in launch.output(), launch.output()
