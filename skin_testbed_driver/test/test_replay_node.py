"""A recorded session, played again by the driver and recorded once more, is the same session."""

import pytest

pytest.importorskip("skin_testbed_msgs")

from rosbags.highlevel import AnyReader
from sensor_msgs.msg import JointState
from skin_testbed_msgs.msg import DriverState, TaxelArray


def record(graph, directory, count):
    parameters = {"directory": str(directory), "topics": ["encoder", "force", "taxels"]}
    recorder = graph.processes.start("skin_testbed_driver", "recorder", parameters=parameters)
    recorder.wait_for_output("every topic", 60.0)
    taxels = graph.hear(TaxelArray, "taxels")
    graph.wait(lambda: len(taxels) > count, "samples")
    return recorder


def values(directory, topic, get):
    with AnyReader([directory]) as reader:
        connections = [c for c in reader.connections if c.topic == topic]
        return [get(reader.deserialize(data, c.msgtype)) for c, _, data in reader.messages(connections)]


def test_replay(graph, tmp_path):
    driver = graph.driver(taxels=2)
    graph.command((2.0, 1e-3, 0.0))
    assert record(graph, tmp_path / "a", 400).end(30.0) == 0
    driver.end(30.0)
    states = graph.hear(DriverState, "driver_state", latched=True)
    encoder = graph.hear(JointState, "encoder")
    replay = {"rig": "replay", "recording": str(tmp_path / "a")}  # in real time: ten times as fast it may be over before it is heard
    graph.processes.start("skin_testbed_driver", "driver_node", parameters=replay)
    graph.wait(lambda: any("has ended" in s.reason for s in states), "the end of the recording")
    recorded = values(tmp_path / "a", "/encoder", lambda m: m.position[0])
    played = [m.position[0] for m in encoder if m.position[0] == m.position[0]]  # without NaN: nothing comes after the end
    assert len(played) > 100
    ends = [recorded[len(recorded) - len(played) - i : len(recorded) - i] for i in range(3)]  # force may have ended a sample earlier
    assert any(played == pytest.approx(end, abs=1e-12) for end in ends)
