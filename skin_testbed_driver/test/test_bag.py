import random
import struct
import subprocess
import sys
import time

import pytest
import yaml
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader

from skin_testbed_driver.bag import BagError, BagWriter, TopicInfo

CLOCK = TopicInfo("/clock", "builtin_interfaces/msg/Time", "int32 sec\nuint32 nanosec\n")
MESSAGE = b"\x00\x01\x00\x00" + bytes(8)


def fill(bag: BagWriter, n: int) -> None:
    topic = bag.add_topic(CLOCK)
    for i in range(n):
        bag.write(topic, MESSAGE, 1000 + i, 1000 + i)


def test_a_closed_bag_is_whole(tmp_path):
    bag = BagWriter(tmp_path / "b")
    fill(bag, 10)
    bag.attach("rig.yaml", "application/yaml", b"x: 1\n", 5)
    bag.close()
    with (tmp_path / "b" / "b_0.mcap").open("rb") as file:
        reader = make_reader(file)
        assert [m.log_time for _, _, m in reader.iter_messages()] == list(range(1000, 1010))
        assert next(reader.iter_attachments()).data == b"x: 1\n"
        assert reader.get_summary().schemas[1].encoding == "ros2msg"
    information = yaml.safe_load((tmp_path / "b" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["message_count"] == 10
    assert information["duration"]["nanoseconds"] == 9


def test_what_was_flushed_survives_without_a_close(tmp_path):
    bag = BagWriter(tmp_path / "b")
    fill(bag, 10)
    bag.flush()
    bag.write(0, MESSAGE, 2000, 2000)  # not flushed
    found = []
    with (tmp_path / "b" / "b_0.mcap").open("rb") as file, pytest.raises(McapError):
        for record in StreamReader(file).records:
            found.append(type(record).__name__)
    assert found.count("Message") == 10
    assert yaml.safe_load((tmp_path / "b" / "metadata.yaml").read_text())


def test_an_existing_directory_is_refused_and_left_alone(tmp_path):
    (tmp_path / "b").mkdir()
    with pytest.raises(BagError, match="exists already"):
        BagWriter(tmp_path / "b")
    assert not list((tmp_path / "b").iterdir())


def test_nothing_is_left_of_a_removed_recording(tmp_path):
    bag = BagWriter(tmp_path / "b")
    bag.attach("rig.yaml", "application/yaml", b"x: 1\n", 5)
    bag.close()
    bag.remove()
    assert not list(tmp_path.iterdir())


def test_a_vanished_file_is_noticed(tmp_path):
    bag = BagWriter(tmp_path / "b")
    fill(bag, 1)
    (tmp_path / "b" / "b_0.mcap").unlink()
    with pytest.raises(BagError, match="deleted"):
        bag.flush()


# A process of its own: a message every millisecond that holds the time at which it was written; the file named last tells the last one's.
WRITER = """
import mmap, struct, sys, time
from skin_testbed_driver.bag import BagWriter, TopicInfo

bag, file = BagWriter(sys.argv[1]), open(sys.argv[2], "r+b")
given = mmap.mmap(file.fileno(), 8)
topic = bag.add_topic(TopicInfo("/clock", "builtin_interfaces/msg/Time", "int32 sec\\nuint32 nanosec\\n"))
while True:
    now = time.monotonic_ns()
    bag.write(topic, struct.pack("<IQ", 0x100, now), now, now)
    given[:] = struct.pack("<Q", now)
    time.sleep(1e-3)
"""


def messages_before_the_tear(path) -> list[int]:
    """The times of all messages that can be read from a file without an end."""
    found = []
    with path.open("rb") as file, pytest.raises(McapError):
        for record in StreamReader(file).records:
            if type(record).__name__ == "Message":
                found.append(record.log_time)
    return found


def test_whenever_a_writer_is_killed_all_but_the_last_half_second_reads_back(tmp_path):
    """By construction no more than `HELD` of what was given is missing, however late the machine lets the writer run."""
    for i in range(12):
        given = tmp_path / f"given_{i}"
        given.write_bytes(bytes(8))
        writer = subprocess.Popen([sys.executable, "-c", WRITER, str(tmp_path / str(i)), str(given)])
        patience = time.monotonic() + 30.0
        while not any(given.read_bytes()):
            assert writer.poll() is None and time.monotonic() < patience, "the writer wrote nothing"
            time.sleep(0.01)
        time.sleep(0.3 + 0.4 * random.random())
        writer.kill()
        writer.wait(10.0)
        times = messages_before_the_tear(tmp_path / str(i) / f"{i}_0.mcap")
        assert times == sorted(times) and len(times) > 10
        (last,) = struct.unpack("<Q", given.read_bytes())
        assert 1e-9 * (last - times[-1]) < 0.5
