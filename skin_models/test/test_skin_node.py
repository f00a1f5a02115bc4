"""The installed skin node over real DDS: contacts in, taxels out."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("skin_testbed_msgs")

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Point, WrenchStamped
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from sensor_msgs.msg import Image, JointState, PointCloud2
from skin_testbed_msgs.msg import Contact, ContactArray, TaxelArray, TaxelLayout
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.materials import material
from skin_models.model_file import save_model
from skin_models.ros.qos import LATCHED
from skin_models.ros.skin_node import indentation
from skin_models.signals import motion

SILICONE = material("silicone_4mm").model
WAIT = 30.0


def start(graph, **parameters):
    node = graph.processes.start("skin_models", "skin_node", parameters=parameters)
    node.wait_for_output("ready", WAIT)
    return node


def press(publisher, force, x=0.0, y=0.0, depth=math.nan):
    publisher.publish(ContactArray(contacts=[Contact(name="finger", position=Point(x=x, y=y), force=force, depth=depth)]))


def test_a_contact_is_felt_and_silence_decays(graph):
    layouts, taxels = graph.hear(TaxelLayout, "taxel_layout", LATCHED), graph.hear(TaxelArray, "taxels")
    truth = graph.hear(TaxelArray, "taxels_truth")
    start(graph, layout="grid", columns=5, rows=5, pitch=0.014, taxel_area=71.33e-6, rate=200.0, contact_timeout=0.3)
    graph.until(lambda: layouts, "the layout")
    assert len(layouts[0].positions) == 25 and layouts[0].header.frame_id == "skin" and layouts[0].names[24] == "taxel_24"
    contacts = graph.publisher(ContactArray, "contacts")
    graph.until(lambda: taxels, "taxels")
    assert np.all(np.array(taxels[-1].force) == 0.0)

    for _ in range(60):
        press(contacts, 10.0, x=0.014)
        graph.spin(0.02)
    pressed = np.array(taxels[-1].force)
    assert pressed[13] == pytest.approx(10.0 * SILICONE.dispersion.sensed_share, rel=0.01) and np.argmax(pressed) == 13
    assert list(taxels[-1].status) == [TaxelArray.OK] * 25 and truth[-1].force[13] == pytest.approx(pressed[13], rel=0.01)

    graph.until(lambda: set(taxels[-1].status) == {TaxelArray.STALE}, "the stale mark")
    graph.until(lambda: max(taxels[-1].force) < 0.02 and set(taxels[-1].status) == {TaxelArray.OK}, "the decay")
    stamps = [t.header.stamp.sec + 1e-9 * t.header.stamp.nanosec for t in taxels]
    assert np.all(np.diff(stamps) > 0)


def test_an_empty_array_lets_go_and_a_wrench_presses_at_its_centre_of_pressure(graph):
    taxels = graph.hear(TaxelArray, "taxels")
    start(graph, layout="row", columns=3, pitch=0.014)
    wrench, contacts = graph.publisher(WrenchStamped, "wrench"), graph.publisher(ContactArray, "contacts")
    message = WrenchStamped()
    message.wrench.force.z, message.wrench.torque.y = -5.0, 5.0 * 0.014  # at x = 14 mm: the torque about y is -x F_z
    for _ in range(60):
        wrench.publish(message)
        graph.spin(0.02)
    assert np.argmax(taxels[-1].force) == 2 and taxels[-1].force[2] == pytest.approx(5.0 * SILICONE.dispersion.sensed_share, rel=0.01)
    wrench.publish(WrenchStamped())
    contacts.publish(ContactArray())
    graph.until(lambda: max(taxels[-1].force) < 0.01, "release")


def test_an_encoder_drives_the_model_at_its_own_stamps(graph, tmp_path):
    """The simulated skin beside a measurement: the node gives what the model gives for the recording, sample by sample."""
    model = SILICONE.extended(StressRelaxation.typical("skin"))
    save_model(model, tmp_path / "model.yaml")
    forces, taxels = graph.hear(WrenchStamped, "force"), graph.hear(TaxelArray, "taxels")
    start(graph, drive="encoder", model=str(tmp_path / "model.yaml"))
    encoder = graph.publisher(JointState, "encoder")
    t = np.arange(150) * 0.01
    x = 0.4e-3 * (1 - np.cos(2 * np.pi * t))
    v = np.gradient(x, 0.01)

    def publish(stamp, depth, speed):
        message = JointState(name=["indentation"], position=[depth], velocity=[speed])
        message.header.stamp.sec, message.header.stamp.nanosec = int(stamp), round((stamp % 1.0) * 1e9)
        encoder.publish(message)
        graph.spin(0.003)

    for stamp in range(1, 900):  # until both ends have met
        publish(float(stamp), 0.0, 0.0)
        if taxels and forces:
            break
    graph.spin(1.0)
    forces.clear(), taxels.clear()
    for i in range(t.size):  # after so long a silence the skin starts from rest
        publish(1000.0 + t[i], x[i], v[i])
    graph.until(lambda: len(taxels) >= t.size and len(forces) >= t.size, "all samples")
    expected = model.simulate(motion(t, x, v, np.diff(v, prepend=v[0]) / 0.01))
    assert [-f.wrench.force.z for f in forces] == pytest.approx(expected.force, abs=1e-6)
    assert [m.force[0] for m in taxels] == pytest.approx(expected.taxels[0], abs=1e-6)
    assert [m.header.stamp for m in taxels] == [f.header.stamp for f in forces] and abs(forces[7].header.stamp.nanosec - 70_000_000) < 100


def test_another_model_is_loaded_without_restart(graph, tmp_path):
    path = tmp_path / "model.yaml"
    save_model(SILICONE, path)
    taxels, layouts = graph.hear(TaxelArray, "taxels"), graph.hear(TaxelLayout, "taxel_layout", LATCHED)
    start(graph, model=str(path))
    contacts = graph.publisher(ContactArray, "contacts")

    def settled():
        for _ in range(80):
            press(contacts, 10.0)
            graph.spin(0.01)
        return list(taxels[-1].force)

    assert settled() == pytest.approx([10 * 9619 / (9619 + 2766)], rel=0.01)
    save_model(material("silicone_6mm").model, path)
    answer = graph.call(Trigger, "skin_node/load_model", Trigger.Request())
    assert answer.success and "silicone 6 mm" in answer.message
    assert settled() == pytest.approx([10 * 4338 / (4338 + 5600)], rel=0.01)

    path.write_text("schema: 1\n")
    answer = graph.call(Trigger, "skin_node/load_model", Trigger.Request())
    assert not answer.success and "kept the model" in answer.message
    value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value="no_such_material")
    answer = graph.call(SetParameters, "skin_node/set_parameters", SetParameters.Request(parameters=[Parameter(name="model", value=value)]))
    assert not answer.results[0].successful and "no_such_material" in answer.results[0].reason
    value.string_value = "silicone_2mm"
    answer = graph.call(SetParameters, "skin_node/set_parameters", SetParameters.Request(parameters=[Parameter(name="model", value=value)]))
    assert answer.results[0].successful
    assert settled() == pytest.approx([10 * 25042 / (25042 + 1603)], rel=0.01) and len(layouts) >= 3

    save_model(replace(SILICONE, shares=(1.0, 0.2, 0.2)), path)  # another number of taxels: the layout says so first
    value.string_value = str(path)
    graph.call(SetParameters, "skin_node/set_parameters", SetParameters.Request(parameters=[Parameter(name="model", value=value)]))
    assert len(settled()) == 3 and len(taxels[-1].status) == 3 and len(layouts[-1].names) == 3


def test_it_can_be_looked_at_and_says_how_it_fares(graph):
    views = {kind: graph.hear(kind, topic) for kind, topic in ((MarkerArray, "markers"), (Image, "heat_map"), (PointCloud2, "points"))}
    diagnostics = graph.hear(DiagnosticArray, "/diagnostics")
    start(graph, layout="hexagonal", columns=6, rows=5, pitch=0.006)
    contacts = graph.publisher(ContactArray, "contacts")
    for _ in range(120):
        press(contacts, 8.0)
        graph.spin(0.01)
    assert all(views.values())
    marker, image, cloud = views[MarkerArray][-1].markers[0], views[Image][-1], views[PointCloud2][-1]
    assert len(marker.points) == len(marker.colors) == 30
    assert image.encoding == "rgb8" and len(image.data) == image.height * image.step
    force = np.frombuffer(bytes(cloud.data), "<f4").reshape(-1, 4)[:, 3]
    assert force.size == 30 and force.max() > 1.0
    bare, aside = Contact(force=math.nan, depth=math.nan), Contact(position=Point(x=5.0), force=1.0, depth=math.nan)
    odd = ContactArray(contacts=[bare, aside, Contact(force=math.nan, depth=1.0), Contact(depth=1e-3)])
    odd.header.frame_id = "world"
    contacts.publish(odd)
    complaints = ("1 contact with neither", "1 contact beside", "beyond 100 mm", "in mm?", "force of exactly 0", "frame world")
    for words in complaints:
        graph.until(lambda words=words: any(words in s.message for d in diagnostics for s in d.status), f"the complaint with {words}")
    diagnostics.clear()
    graph.until(lambda: any("neither" not in s.message for d in diagnostics for s in d.status), "its end")
    assert {v.key for v in diagnostics[-1].status[0].values} >= {"achieved_rate_hz", "skipped"}


@pytest.mark.parametrize(
    ("parameters", "says"),
    [
        ({"model": "/nowhere/model.yaml"}, "cannot read the model"),
        ({"layout": "file"}, "needs layout_file"),
        ({"rate": 0.0}, "rate must lie between"),
        ({"layout": "spiral"}, "must be one of"),
        ({"spread_kernel": "heavy_tail", "spread_power": 1.0}, "above 1"),
        ({"model": "rubber"}, "no material is called 'rubber'; known are frubber_4mm"),
        ({"model": "soft.yaml"}, "k1 = -9619 N/m is outside"),
        ({"layout": "file", "layout_file": "twice.csv"}, "same place"),
        ({"layout": "file", "layout_file": "nan.csv"}, "not finite"),
        ({"layout": "file", "layout_file": "empty.csv"}, "one or more"),
        ({"layout": "grid", "columns": 0}, "between 1 and 1000 (taxels along x), not 0"),
        ({"rate": 100}, "rate must be a number with a decimal point, not 100"),
    ],
)
def test_bad_parameters_end_with_one_sentence(graph, tmp_path, monkeypatch, parameters, says):
    monkeypatch.chdir(tmp_path)
    save_model(SILICONE, "good.yaml")
    Path("soft.yaml").write_text(Path("good.yaml").read_text().replace("9619", "-9619"))
    for name, rows in (("twice", "1,2\n1,2\n"), ("nan", "1,nan\n"), ("empty", "")):
        Path(f"{name}.csv").write_text(f"x_mm,y_mm\n{rows}")
    node = graph.processes.start("skin_models", "skin_node", parameters=parameters)
    assert node.wait(WAIT) == 2
    lines = node.output().strip().splitlines()
    assert len(lines) == 1 and says in lines[0], node.output()


def test_it_ends_cleanly(graph):
    assert start(graph).end() == 0


def test_of_several_joints_only_the_one_called_indentation_is_the_depth():
    assert indentation(JointState(name=["shoulder", "indentation"], position=[1.0, 2e-3], velocity=[0.0, 0.1])) == (2e-3, 0.1)
    assert indentation(JointState(name=["stage"], position=[2e-3], velocity=[0.1])) == (2e-3, 0.1)
    assert np.isnan(indentation(JointState(name=["shoulder", "elbow"], position=[1.0, 2.0], velocity=[0.0, 0.1]))).all()
