"""The files for RViz, Foxglove and PlotJuggler against the words that those viewers read. No viewer is started here.

Taken from the sources of RViz 14.3.1 (plugins_description.xml and the properties of each class), of Lichtblick 1.28.1, the open
continuation of Foxglove Studio (panels/index.ts and the config type of each panel; timeWindowMode, which it ignores, from the layouts of
the Foxglove SDK 0.30.3), and of PlotJuggler 3.17 (xmlLoadState of mainwindow.cpp, tabbedplotwidget.cpp, plotwidget.cpp and
scale_transform.cpp, restoreSplitter of plot_docker.cpp). A word that a viewer does not know it ignores without telling, so each of these
tests also fails where a word of ours is not among them. In Lichtblick and PlotJuggler the layouts were looked at, too.
"""

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
import yaml

SHARED = Path(__file__).parents[1]

QOS = {"Value", "Depth", "History Policy", "Reliability Policy", "Durability Policy"}
EVERY_DISPLAY = {"Class", "Name", "Enabled", "Value"}
DISPLAYS = {
    "Grid": {"Reference Frame", "Plane Cell Count", "Normal Cell Count", "Cell Size", "Line Style", "Color", "Alpha", "Plane", "Offset"},
    "RobotModel": {
        "Visual Enabled", "Collision Enabled", "Update Interval", "Alpha", "Description Source", "Description Topic", "TF Prefix",
    },
    "Wrench": {
        "Topic", "Accept NaN Values", "Force Color", "Torque Color", "Alpha", "Force Arrow Scale", "Torque Arrow Scale", "Arrow Width",
        "History Length",
    },
    "MarkerArray": {"Topic", "Namespaces"},
    "TF": {"Show Names", "Show Axes", "Show Arrows", "Marker Scale", "Update Interval", "Frame Timeout", "Frames", "Tree"},
}  # fmt: skip
ORBIT = {"Class", "Name", "Distance", "Yaw", "Pitch", "Focal Point", "Focal Shape Size", "Focal Shape Fixed Size", "Near Clip Distance"}
TOOLS = {"MoveCamera", "Interact", "Select", "Measure", "FocusCamera", "SetInitialPose", "SetGoal", "PublishPoint"}
RVIZ_PANELS = {"Displays", "Time", "Views", "Tool Properties", "Selection", "Help", "Transformation"}

TITLES = {"foxglovePanelTitle": str, "lichtblickPanelTitle": str}
PATH = {"value": str, "enabled": bool, "timestampMethod": str, "label": str, "color": str, "showLine": bool, "lineSize": float}
LICHTBLICK = {
    "Plot": {
        **TITLES, "paths": list, "showXAxisLabels": bool, "showYAxisLabels": bool, "showLegend": bool, "legendDisplay": str,
        "showPlotValuesInLegend": bool, "isSynced": bool, "xAxisVal": str, "followingViewWidth": (int, float), "sidebarDimension": int,
        "timeWindowMode": str,
    },
    "StateTransitions": {**TITLES, "paths": list, "isSynced": bool, "xAxisRange": float, "showPoints": bool, "timeWindowMode": str},
    "DiagnosticSummary": {
        "minLevel": int, "pinnedIds": list, "topicToRender": str, "hardwareIdFilter": str, "sortByLevel": bool, "secondsUntilStale": float,
    },
    "RawMessages": {
        "topicPath": str, "diffEnabled": bool, "diffMethod": str, "diffTopicPath": str, "showFullMessageForDiff": bool, "fontSize": int,
    },
}  # fmt: skip
CHOICES = {
    "legendDisplay": {"floating", "top", "left", "none"}, "xAxisVal": {"timestamp", "index", "custom", "currentCustom"},
    "timeWindowMode": {"automatic", "sliding", "fixed"},
}  # fmt: skip

PLOTJUGGLER = {
    "root": set(), "tabbed_widget": {"name", "parent"}, "Tab": {"tab_name", "containers"}, "Container": set(),
    "DockSplitter": {"orientation", "count", "sizes"}, "DockArea": {"name"}, "plot": {"mode", "style", "flip_x", "flip_y"},
    "curve": {"name", "color"}, "transform": {"name", "alias"},
    "options": {"time_offset", "value_offset", "value_scale"}, "currentTabIndex": {"index"}, "use_relative_time_offset": {"enabled"},
}  # fmt: skip


@pytest.fixture
def rviz() -> dict:
    return yaml.safe_load((SHARED / "rviz" / "testbed.rviz").read_text())


def own(name: str, package: str = "rviz_default_plugins") -> str:
    assert name.startswith(package + "/")
    return name.removeprefix(package + "/")


def test_rviz_knows_every_display_and_every_property_of_it(rviz):
    for display in rviz["Visualization Manager"]["Displays"]:
        assert set(display) <= EVERY_DISPLAY | DISPLAYS[own(display["Class"])], display["Name"]
        for topic in (display[key] for key in ("Topic", "Description Topic") if key in display):
            assert set(topic) <= QOS
            assert topic.get("Reliability Policy", "Reliable") in ("Reliable", "Best Effort", "System Default")
            assert topic.get("Durability Policy", "Volatile") in ("Volatile", "Transient Local", "System Default")


def test_rviz_shows_the_force(rviz):
    """It hides an arrow that is shorter than its width, and one inside the plunger, whose axis is the force's, behind an opaque face."""
    displays = {own(display["Class"]): display for display in rviz["Visualization Manager"]["Displays"]}
    assert displays["Wrench"]["Arrow Width"] <= 2.0 * displays["Wrench"]["Force Arrow Scale"]  # from 2 N on
    assert displays["RobotModel"]["Alpha"] < 1.0


def test_rviz_knows_panels_tools_view_and_global_options(rviz):
    manager = rviz["Visualization Manager"]
    assert {own(panel["Class"], "rviz_common") for panel in rviz["Panels"]} <= RVIZ_PANELS
    assert {own(tool["Class"]) for tool in manager["Tools"]} <= TOOLS
    assert set(manager["Global Options"]) <= {"Background Color", "Fixed Frame", "Frame Rate"}
    view = manager["Views"]["Current"]
    assert own(view["Class"]) == "Orbit" and set(view) <= ORBIT and set(view["Focal Point"]) == {"X", "Y", "Z"}


def test_foxglove_and_lichtblick_know_every_panel_and_every_setting_of_it():
    content = json.loads((SHARED / "foxglove" / "testbed.json").read_text())
    assert set(content) == {"configById", "globalVariables", "userNodes", "playbackConfig", "layout"}
    for name, panel in content["configById"].items():
        kinds = LICHTBLICK[name.partition("!")[0]]
        for key, value in panel.items():
            assert isinstance(value, kinds[key]), f"{name}.{key}"
            assert value in CHOICES.get(key, {value} if not isinstance(value, list) else [value])
        for path in panel.get("paths", []):
            assert all(isinstance(value, PATH[key]) for key, value in path.items())
            assert path["timestampMethod"] in ("receiveTime", "headerStamp") and path["value"].startswith("/")
            assert ".@" not in path["value"]  # Lichtblick ignores @negative over time
        assert panel.get("foxglovePanelTitle") == panel.get("lichtblickPanelTitle")  # each reads its own


def test_the_panels_of_foxglove_are_laid_out_as_a_tree_of_halves():
    def check(node) -> None:
        if isinstance(node, dict):
            assert set(node) <= {"direction", "first", "second", "splitPercentage"} and node["direction"] in ("row", "column")
            assert 0 < node.get("splitPercentage", 50) < 100
            check(node["first"])
            check(node["second"])

    check(json.loads((SHARED / "foxglove" / "testbed.json").read_text())["layout"])


def test_plotjuggler_knows_every_element_and_attribute():
    root = ET.parse(SHARED / "config" / "plotjuggler.xml").getroot()
    assert root.tag == "root" and root.find("tabbed_widget").get("name") == "Main Window"  # the one tabbed widget that it has
    for element in root.iter():
        assert set(element.attrib) <= PLOTJUGGLER[element.tag], element.tag
    for splitter in root.iter("DockSplitter"):
        sizes = [float(size) for size in splitter.get("sizes").split(";")]
        assert splitter.get("orientation") in ("-", "|") and len(sizes) == int(splitter.get("count")) == len(splitter)
        assert sum(sizes) == pytest.approx(1.0)
    for transform in root.iter("transform"):
        assert transform.get("name") == "Scale/Offset" and len(transform) == 1
        assert set(transform[0].attrib) == PLOTJUGGLER["options"]
        assert all(float(value) != 0.0 for key, value in transform[0].attrib.items() if key == "value_scale")
    for plot in root.iter("plot"):
        assert plot.get("mode") == "TimeSeries" and plot.get("style") in ("Lines", "LinesAndDots", "Dots", "Sticks", "Steps")
