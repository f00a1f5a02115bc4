import numpy as np
import pytest

pytest.importorskip("skin_testbed_msgs")

from geometry_msgs.msg import WrenchStamped
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState
from skin_testbed_msgs.msg import TaxelArray

from skin_testbed_driver.ros.packed import Packed


@pytest.mark.parametrize("frame", ["", "a", "load_cell", "a_longer_frame"])
def test_numbers_written_into_the_bytes_are_those_that_are_read(frame):
    message = WrenchStamped()
    message.header.frame_id = frame
    packed = Packed(message, "wrench.force.z", behind=24).with_stamp((1700000000, 123456789)).set_number("wrench.force.z", -1.25)
    read = deserialize_message(packed.data(), WrenchStamped)
    message.header.stamp.sec, message.header.stamp.nanosec, message.wrench.force.z = 1700000000, 123456789, -1.25
    assert read == message


@pytest.mark.parametrize("count", [0, 1, 2, 3, 4, 64])
@pytest.mark.parametrize("frame", ["skin", "left_palm"])
def test_arrays_of_any_length_find_their_place(count, frame):
    message = TaxelArray(force=[0.0] * count, voltage=[0.0] * count, status=[0] * count)
    message.header.frame_id = frame
    rng = np.random.default_rng(count)
    force, voltage, status = rng.normal(size=count), rng.normal(size=count), rng.integers(0, 6, count).astype(np.uint8)
    packed = Packed(message, "force", "voltage", "status").with_stamp((3, 4))
    read = deserialize_message(packed.set("force", force).set("voltage", voltage).set("status", status).data(), TaxelArray)
    assert read.header.frame_id == frame and (read.header.stamp.sec, read.header.stamp.nanosec) == (3, 4)
    assert list(read.force) == list(force) and list(read.voltage) == list(voltage) and list(read.status) == list(status)


def test_strict_readers_find_no_byte_too_many():
    rosbags = pytest.importorskip("rosbags.typesys")
    store = rosbags.get_typestore(rosbags.Stores.ROS2_JAZZY)
    packed = Packed(JointState(name=["indentation"], position=[0.0], velocity=[0.0]), "position", "velocity", behind=4)
    read = store.deserialize_cdr(packed.set_number("position", 1.5).data(), "sensor_msgs/msg/JointState")
    assert read.name == ["indentation"] and list(read.position) == [1.5]


def test_what_does_not_fit_is_refused():
    packed = Packed(TaxelArray(force=[0.0] * 3), "force", behind=8)
    with pytest.raises(ValueError, match="room for 24 bytes"):
        packed.set("force", np.zeros(4))
