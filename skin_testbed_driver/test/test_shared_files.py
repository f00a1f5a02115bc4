import json
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
import yaml

SHARED = Path(__file__).parents[1]
TOPICS = {"/force", "/taxels", "/taxels_truth", "/simulated/taxels", "/encoder", "/driver_state", "/diagnostics"}


@pytest.mark.parametrize("path", sorted((SHARED / "config").glob("*.yaml")), ids=lambda p: p.name)
def test_every_configured_parameter_exists_and_is_accepted(path):
    settings = pytest.importorskip("skin_testbed_driver.ros.driver_settings").DriverSettings
    entries = yaml.safe_load(path.read_text())["/**"]["testbed_driver"]["ros__parameters"]
    settings(**entries)


def test_the_frames_are_those_of_the_driver():
    robot = ET.parse(SHARED / "urdf" / "testbed.urdf").getroot()
    assert {link.get("name") for link in robot.iter("link")} == {"skin", "load_cell"}
    assert [joint.get("name") for joint in robot.iter("joint")] == ["indentation"]


def test_layouts_show_topics_that_exist():
    content = json.loads((SHARED / "foxglove" / "testbed.json").read_text())
    panels = content["configById"]
    shown = {path["value"].split(".")[0] for panel in panels.values() for path in panel.get("paths", [])}
    assert shown and shown <= TOPICS
    ET.parse(SHARED / "config" / "plotjuggler.xml")
    rviz = yaml.safe_load((SHARED / "rviz" / "testbed.rviz").read_text())
    assert rviz["Visualization Manager"]["Global Options"]["Fixed Frame"] == "skin"
