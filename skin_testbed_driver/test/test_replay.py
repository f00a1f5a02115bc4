import numpy as np
import pytest

from skin_models.layout import row_from_origin
from skin_testbed_driver.bag import BagWriter, TopicInfo
from skin_testbed_driver.rig import RigError
from skin_testbed_driver.rigs.replay import Recorded, ReplayRig, Track
from skin_testbed_driver.rigs.table import read_table

TABLE = "t_s\tx_mm\tforce_n\ttaxel_0_n\n0.00\t0.0\t0.0\t0.0\n0.01\t0.1\t1.0\t0.5\n0.02\t0.2\t2.0\t1.0\n"


def table(tmp_path, text):
    path = tmp_path / "run.tsv"
    path.write_text(text)
    return read_table(path)


def test_a_table_is_played_sample_by_sample_and_then_ends(tmp_path):
    rig = ReplayRig(table(tmp_path, TABLE), row_from_origin(1))
    rig.open(100.0)
    readings = [rig.read() for _ in range(3)]
    assert [r.position for r in readings] == pytest.approx([0.0, 1e-4, 2e-4])
    assert [r.force for r in readings] == pytest.approx([0.0, 1.0, 2.0])
    assert [r.taxel_force[0] for r in readings] == pytest.approx([0.0, 0.5, 1.0])
    with pytest.raises(RigError, match="ended"):
        rig.read()


def test_another_rate_lies_on_straight_lines_between_the_samples(tmp_path):
    rig = ReplayRig(table(tmp_path, TABLE), row_from_origin(1), loop=True)
    rig.open(200.0)
    assert [rig.read().force for _ in range(6)] == pytest.approx([0.0, 0.5, 1.0, 1.5, 2.0, 0.0])


def test_recordings_without_a_common_time_are_refused():
    t = np.arange(3.0)
    rig = ReplayRig(Recorded(Track(t, t), Track(t + 10.0, t)), row_from_origin(1))
    with pytest.raises(RigError, match="in common"):
        rig.open(100.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "empty"),
        (TABLE.splitlines()[0], "no rows"),
        (TABLE.replace("x_mm", "y_mm"), "not known"),
        (TABLE.replace("x_mm", "taxel_1_n"), "no depth: add x_mm"),
        (TABLE.replace("force_n", "force_v"), "force is in volts"),
        (TABLE.replace("x_mm", "x"), "x_mm"),
        (TABLE.replace("t_s", "t"), "t_s"),
        (TABLE.replace("1.0", "one"), "no number"),
        (TABLE.replace("0.01", "0.00").replace("0.02", "0.00"), "1 usable sample"),
        (TABLE + "1\t2\n", "4 columns of the header"),
    ],
)
def test_a_table_that_cannot_be_used_is_refused_in_a_sentence(tmp_path, text, words):
    with pytest.raises(RigError, match=words):
        table(tmp_path, text)


def test_a_material_test_has_taxels_that_say_nothing(tmp_path):
    rows = [line.split("\t")[:3] for line in TABLE.splitlines()]
    rig = ReplayRig(table(tmp_path, "\n".join(map("\t".join, rows))), row_from_origin(2))
    rig.open(100.0)
    reading = rig.read()
    assert (reading.position, reading.force) == (0.0, 0.0) and np.isnan(reading.taxel_force).all() and reading.taxel_force.size == 2


def test_another_number_of_taxels_than_the_recording_has_is_refused(tmp_path):
    with pytest.raises(RigError, match="has 1 taxel, but the layout has 3"):
        ReplayRig(table(tmp_path, TABLE), row_from_origin(3)).open(100.0)


def bag_of(path, *forces_by_namespace, foreign=()):
    """A bag with rigs in namespaces, told apart by their force, and `foreign` topics of one `Float64`."""
    from geometry_msgs.msg import WrenchStamped
    from rclpy.serialization import serialize_message
    from sensor_msgs.msg import JointState
    from std_msgs.msg import Float64

    bag = BagWriter(path)
    for topic in foreign:
        bag.write(bag.add_topic(TopicInfo(topic, "std_msgs/msg/Float64", "")), serialize_message(Float64(data=5.0)), 0, 0)
    for namespace, force in forces_by_namespace:
        encoder = bag.add_topic(TopicInfo(f"{namespace}/encoder", "sensor_msgs/msg/JointState", ""))
        cell = bag.add_topic(TopicInfo(f"{namespace}/force", "geometry_msgs/msg/WrenchStamped", ""))
        for i in range(3):
            depth, wrench = JointState(name=["indentation"], position=[1e-3 * force]), WrenchStamped()
            wrench.wrench.force.z = -force
            depth.header.stamp.nanosec = wrench.header.stamp.nanosec = 10_000_000 * i
            bag.write(encoder, serialize_message(depth), i, i)
            bag.write(cell, serialize_message(wrench), i, i)
    bag.close()
    return str(path)


def test_of_a_rig_and_a_simulation_beside_it_the_rig_is_played_and_of_two_rigs_the_one_that_was_named(tmp_path):
    pytest.importorskip("skin_testbed_msgs")
    from skin_testbed_driver.ros.replayed_bag import read_bag

    beside, _ = read_bag(bag_of(tmp_path / "beside", ("/simulated", 7.0), ("", 2.0)))
    assert beside.force.values == pytest.approx([2.0] * 3) and beside.depth.values == pytest.approx([2e-3] * 3)
    assert "force is read from /force, not from /simulated/force" in beside.warnings
    two = bag_of(tmp_path / "two", ("/left", 1.0), ("/right", 2.0))
    with pytest.raises(RigError, match="could be encoder: /left/encoder, /right/encoder; name the namespace"):
        read_bag(two)
    assert read_bag(two, "right")[0].force.values == pytest.approx([2.0] * 3)
    with pytest.raises(RigError, match="no topic encoder in the namespace /middle"):
        read_bag(two, "/middle")


def test_a_topic_that_only_bears_the_name_of_one_is_passed_over_where_that_is_there(tmp_path):
    pytest.importorskip("skin_testbed_msgs")
    from skin_testbed_driver.ros.replayed_bag import read_bag

    read, _ = read_bag(bag_of(tmp_path / "both", ("/rig", 2.0), foreign=["/arm/force"]))
    said = "topic /arm/force has type std_msgs/msg/Float64, and force is replayed from geometry_msgs/msg/WrenchStamped"
    assert read.force.values == pytest.approx([2.0] * 3) and f"{said}: it was passed over" in read.warnings
    with pytest.raises(RigError, match="topic /taxels has type std_msgs/msg/Float64"):
        read_bag(bag_of(tmp_path / "alone", ("/rig", 2.0), foreign=["/taxels"]))
