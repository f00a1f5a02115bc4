"""The layouts for RViz, Foxglove and PlotJuggler against a running testbed: every topic is there, of the right type, with that field."""

import importlib
import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
import yaml

pytest.importorskip("skin_testbed_msgs")

SHARED = Path(__file__).parents[1]
# The displays' own message types: rviz_default_plugins of Jazzy.
RVIZ_TYPES = {
    "rviz_default_plugins/Wrench": "geometry_msgs/msg/WrenchStamped",
    "rviz_default_plugins/MarkerArray": "visualization_msgs/msg/MarkerArray",
}


def foxglove_paths() -> set[str]:
    """Every message path of the layout: /topic.field[index]."""
    panels = json.loads((SHARED / "foxglove" / "testbed.json").read_text())["configById"]
    paths = {path["value"] for panel in panels.values() for path in panel.get("paths", [])}
    return paths | {panel[key] for panel in panels.values() for key in ("topicPath", "topicToRender") if key in panel}


def plotjuggler_curves() -> set[str]:
    """Every curve: /topic/field[index], but for joint states /topic/joint/position."""
    return {curve.get("name") for curve in ET.parse(SHARED / "config" / "plotjuggler.xml").iter("curve")}


def rviz_displays() -> list[dict]:
    return yaml.safe_load((SHARED / "rviz" / "testbed.rviz").read_text())["Visualization Manager"]["Displays"]


def get_message(type_name: str) -> type:
    package, kind, name = type_name.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), name)


def holds(type_name: str, fields: list[str]) -> bool:
    """Whether a message has that chain of fields; an index needs a sequence."""
    for field in fields:
        name, index = re.fullmatch(r"(\w+)(\[\d+\])?", field).groups()
        kind = get_message(type_name).get_fields_and_field_types().get(name)
        if kind is None or bool(index) != kind.startswith("sequence"):
            return False
        type_name = kind
        if "/" in kind:
            package, message = kind.split("/")
            type_name = f"{package}/msg/{message}"
    return True


@pytest.fixture
def published(graph) -> dict[str, str]:
    """Topics and types of the driver with a simulated skin beside it, as the launch file starts them with compare:=…."""
    graph.driver()
    names = ("force", "taxels", "taxels_truth", "taxel_layout", "markers", "heat_map", "points")
    remap = {name: f"simulated/{name}" for name in names}
    graph.processes.start("skin_models", "skin_node", parameters={"model": "silicone_4mm", "drive": "encoder"}, remap=remap)

    def topics() -> dict[str, str]:
        found = dict(graph.node.get_topic_names_and_types())
        return {name: types[0] for name, types in found.items() if graph.node.count_publishers(name)}

    graph.wait(lambda: "/simulated/markers" in topics() and "/diagnostics" in topics(), "all topics")
    return topics()


def test_every_viewer_shows_what_is_published(published):
    for path in foxglove_paths():
        topic, *fields = path.split(".")
        assert topic in published, path
        assert holds(published[topic], fields), path
    for curve in plotjuggler_curves():
        topic = max((name for name in published if curve.startswith(name + "/")), key=len, default=None)
        assert topic, curve
        fields = curve.removeprefix(topic + "/").split("/")
        if published[topic] == "sensor_msgs/msg/JointState":
            assert fields[0] == "indentation" and fields[1] in ("position", "velocity"), curve
        else:
            assert holds(published[topic], fields), curve
    for display in rviz_displays():
        topic = display.get("Topic", {}).get("Value")
        if topic:
            assert published[f"/{topic.lstrip('/')}"] == RVIZ_TYPES[display["Class"]], display["Name"]


def test_the_foxglove_layout_has_a_place_for_every_panel():
    content = json.loads((SHARED / "foxglove" / "testbed.json").read_text())

    def panels(node) -> list[str]:
        return [node] if isinstance(node, str) else panels(node["first"]) + panels(node["second"])

    assert sorted(panels(content["layout"])) == sorted(content["configById"])


def test_the_plotjuggler_layout_is_built_as_plotjuggler_builds_it():
    root = ET.parse(SHARED / "config" / "plotjuggler.xml").getroot()
    splitter = root.find("tabbed_widget/Tab/Container/DockSplitter")
    assert int(splitter.get("count")) == len(splitter.findall("DockArea/plot")) == len(splitter.get("sizes").split(";"))
    assert all(curve.get("color").startswith("#") for curve in root.iter("curve"))


def test_rviz_subscribes_as_its_topics_offer():
    """A reliable subscription does not match a best-effort publisher; the frames are those of the driver."""
    reliable = [d for d in rviz_displays() if d.get("Topic", {}).get("Reliability Policy") == "Reliable"]
    assert {d["Topic"]["Value"] for d in reliable} <= {"simulated/markers"}  # published reliably
