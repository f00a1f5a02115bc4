"""The installed recorder beside a running driver."""

import itertools
import shutil
import signal
import time
from pathlib import Path

import pytest
import yaml

pytest.importorskip("skin_testbed_msgs")

from geometry_msgs.msg import WrenchStamped
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from rosbags.highlevel import AnyReader
from sensor_msgs.msg import JointState
from skin_testbed_msgs.msg import TaxelArray
from std_srvs.srv import Trigger

STREAMS = {"/encoder", "/force", "/taxels"}


def stamp_ns(message) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def record(graph, directory: Path, **parameters):
    process = graph.processes.start("skin_testbed_driver", "recorder", parameters={"directory": str(directory), **parameters})
    process.wait_for_output("recording to", 60.0)
    return process


def mcap_of(directory: Path) -> Path:
    return next(directory.glob("*.mcap"))


def test_a_session_reads_back_as_it_was_heard_by_both_libraries(graph, tmp_path):
    graph.driver()
    recorder = record(graph, tmp_path / "s", topics=["encoder", "force", "taxels", "driver_state", "taxel_layout"])
    recorder.wait_for_output("every topic", 60.0)
    heard = {"/encoder": graph.hear(JointState, "encoder"), "/force": graph.hear(WrenchStamped, "force")}
    heard["/taxels"] = graph.hear(TaxelArray, "taxels")
    graph.wait(lambda: min(map(len, heard.values())) > 300, "300 samples")
    assert recorder.end(30.0) == 0
    with AnyReader([tmp_path / "s"]) as reader:
        assert {c.topic for c in reader.connections} == {*STREAMS, "/driver_state", "/taxel_layout"}
        read = {topic: {} for topic in {c.topic for c in reader.connections}}
        raw = {topic: [] for topic in read}
        for connection, _, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            read[connection.topic][stamp_ns(message)] = message
            raw[connection.topic].append(bytes(data))
    for message in heard["/force"][100:300]:
        assert read["/force"][stamp_ns(message)].wrench.force.z == message.wrench.force.z
    for message in heard["/taxels"][100:300]:
        assert list(read["/taxels"][stamp_ns(message)].voltage) == list(message.voltage)
    assert len(read["/driver_state"]) >= 1 and len(read["/taxel_layout"]) == 1  # latched: published before the recording
    with mcap_of(tmp_path / "s").open("rb") as file:
        again = {topic: [] for topic in raw}
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema.encoding == "ros2msg" and channel.message_encoding == "cdr"
            again[channel.topic].append(message.data)
    assert again == raw


def test_what_begins_once_a_rig_is_said_to_be_recorded_is_recorded_whole(graph, tmp_path):
    graph.driver(time_scale=1.0)
    recorder = record(graph, tmp_path / "s")
    recorder.wait_for_output("encoder, force and taxels are being recorded", 60.0)
    said = time.time_ns()
    time.sleep(1.0)
    assert recorder.end(30.0) == 0
    with AnyReader([tmp_path / "s"]) as reader:
        for topic in STREAMS:
            connections = [c for c in reader.connections if c.topic == topic]
            first = next(stamp_ns(reader.deserialize(data, c.msgtype)) for c, _, data in reader.messages(connections))
            assert first <= said, topic


def test_no_sample_is_missing_between_the_first_and_the_last(graph, tmp_path):
    graph.driver(sample_rate=1000.0, time_scale=1.0)
    recorder = record(graph, tmp_path / "s", topics=["encoder", "force", "taxels"])
    recorder.wait_for_output("every topic", 60.0)
    encoder = graph.hear(JointState, "encoder")
    graph.wait(lambda: len(encoder) > 2000, "2000 samples")
    assert recorder.end(30.0) == 0
    with AnyReader([tmp_path / "s"]) as reader:
        stamps = {topic: [] for topic in STREAMS}
        for connection, _, data in reader.messages():
            stamps[connection.topic].append(stamp_ns(reader.deserialize(data, connection.msgtype)))
    for times in stamps.values():
        assert {b - a for a, b in itertools.pairwise(times)} == {10**6}
        assert len(times) > 1500


def encoder_times(path) -> list[int]:
    """When the encoders' messages came that can be read from a recording, whole or torn."""
    topics, times = {}, []
    with path.open("rb") as file:
        try:
            for found in StreamReader(file).records:
                if type(found).__name__ == "Channel":
                    topics[found.id] = found.topic
                elif type(found).__name__ == "Message" and topics[found.channel_id].endswith("/encoder"):
                    times.append(found.log_time)
        except McapError:
            pass  # the end is missing: that is what was asked for
    return times


def wait_for_samples(graph, directory: Path) -> None:
    """Wait until a recording is no longer empty: topics are found one after the other."""
    graph.wait(lambda: encoder_times(mcap_of(directory)), f"what is recorded in {directory.name}")


def test_after_kill_all_but_the_last_second_reads_back(graph, tmp_path):
    graph.driver(time_scale=1.0)
    recorder = record(graph, tmp_path / "s")
    encoder = graph.hear(JointState, "encoder")
    graph.wait(lambda: encoder_times(mcap_of(tmp_path / "s")), "what is recorded")  # late where a process of the same domain was killed
    start = len(encoder)
    graph.wait(lambda: len(encoder) > start + 300, "three seconds")
    recorder.kill()
    last_before = stamp_ns(encoder[-1])
    times = encoder_times(mcap_of(tmp_path / "s"))
    assert times and last_before - times[-1] < 10**9
    assert (tmp_path / "s" / "metadata.yaml").is_file()


def test_a_topic_that_nobody_publishes_is_missed_aloud(graph, tmp_path):
    graph.driver()
    recorder = record(graph, tmp_path / "s", topics=["force", "nothing"])
    recorder.wait_for_output("/nothing has no publisher yet", 60.0)
    assert recorder.end(30.0) == 0
    assert "/nothing was never recorded" in recorder.output() and "/force" not in recorder.output()
    assert " messages of 1 topic in " in recorder.output()


def test_a_graph_without_a_rig_is_complained_of_and_an_empty_recording_is_no_success_and_not_kept(graph, tmp_path):
    recorder = record(graph, tmp_path / "s")
    recorder.wait_for_output("nobody publishes encoder, force, taxels yet: does a driver run", 60.0)
    assert recorder.end(30.0) == 2
    assert "nothing was recorded of encoder, force, taxels" in recorder.output() and "Traceback" not in recorder.output()
    sentence = "recorder: not one message came, so no recording is kept: does a driver run, in the same ROS domain?"
    assert recorder.output().rstrip().endswith(sentence)
    assert not (tmp_path / "s").exists(), "the next recording may have the same name"


def test_streams_that_are_missing_beside_others_are_named(graph, tmp_path):
    encoder = graph.node.create_publisher(JointState, "encoder", 10)
    recorder = record(graph, tmp_path / "s", exclude=["/rosout", "/parameter_events", "/taxels"])
    graph.wait(lambda: encoder.get_subscription_count(), "the recorder's subscription")
    encoder.publish(JointState())
    wait_for_samples(graph, tmp_path / "s")
    assert recorder.end(30.0) == 0
    assert "nothing was recorded of force, taxels" in recorder.output() and "1 message of " in recorder.output()


def test_an_existing_directory_is_refused(graph, tmp_path):
    (tmp_path / "s").mkdir()
    process = graph.processes.start("skin_testbed_driver", "recorder", parameters={"directory": str(tmp_path / "s")})
    assert process.wait(60.0) == 2
    assert process.output().count("\n") == 1 and "exists already" in process.output()
    assert not list((tmp_path / "s").iterdir())


def test_a_rig_file_goes_into_the_recording_and_beside_it(graph, tmp_path):
    (tmp_path / "rig.yaml").write_text("plunger_diameter_mm: 9.9\n")
    graph.driver()
    recorder = record(graph, tmp_path / "s", rig_file=str(tmp_path / "rig.yaml"))
    wait_for_samples(graph, tmp_path / "s")
    assert graph.call(Trigger, "recorder/stop").success
    assert recorder.wait(60.0) == 0
    assert (tmp_path / "s" / "rig.yaml").read_text() == "plunger_diameter_mm: 9.9\n"
    with mcap_of(tmp_path / "s").open("rb") as file:
        assert next(make_reader(file).iter_attachments()).name == "rig.yaml"


def test_what_the_driver_says_of_its_rig_goes_into_the_recording_and_beside_it(graph, tmp_path):
    graph.driver(taxels=2)
    recorder = record(graph, tmp_path / "s")
    files = [tmp_path / "s" / name for name in ("rig.yaml", "calibration.yaml")]
    graph.wait(lambda: all(f.is_file() and f.stat().st_size for f in files), "both files")
    wait_for_samples(graph, tmp_path / "s")
    assert recorder.end(30.0) == 0
    rig, calibration = (yaml.safe_load(f.read_text()) for f in files)
    assert rig["sample_rate_hz"] == 100.0 and rig["taxel_positions_mm"] == [[0.0, 0.0], [14.0, 0.0]]
    assert rig["force_step_n"] == pytest.approx(0.0679, abs=1e-4)
    assert set(calibration["taxels_n_per_v"]) == {"taxel_0", "taxel_1"}
    with mcap_of(tmp_path / "s").open("rb") as file:
        assert {a.name for a in make_reader(file).iter_attachments()} == {"rig.yaml", "calibration.yaml"}


def in_namespace(graph, namespace, taxels):
    """A driver in a namespace of its own."""
    parameters, remap = {"time_scale": 1.0, "taxels": taxels}, {"__ns": namespace}
    graph.processes.start("skin_testbed_driver", "driver_node", parameters=parameters, remap=remap).wait_for_output("sampling at", 60.0)


def test_the_only_rig_of_the_graph_describes_itself_though_it_is_in_a_namespace(graph, tmp_path):
    in_namespace(graph, "/left", taxels=2)
    recorder = record(graph, tmp_path / "s")
    files = [tmp_path / "s" / name for name in ("rig.yaml", "calibration.yaml")]
    graph.wait(lambda: all(f.is_file() and f.stat().st_size for f in files), "both files")
    wait_for_samples(graph, tmp_path / "s")
    assert recorder.end(30.0) == 0
    assert len(yaml.safe_load(files[0].read_text())["taxel_positions_mm"]) == 2


def test_of_two_rigs_the_recorded_one_describes_itself_and_both_are_complained_of(graph, tmp_path):
    in_namespace(graph, "/left", taxels=2)
    in_namespace(graph, "/right", taxels=3)
    for side in ("left", "right"):
        graph.wait(lambda s=side: graph.node.count_publishers(f"/{s}/calibration"), "both rigs")
    one = record(graph, tmp_path / "one", topics=["/right/force", "/right/encoder"])
    both = record(graph, tmp_path / "both")
    both.wait_for_output("more than one rig describes itself .*/left, /right", 60.0)
    rig = tmp_path / "one" / "rig.yaml"
    graph.wait(lambda: rig.is_file() and rig.stat().st_size, "the file")
    wait_for_samples(graph, tmp_path / "one")
    wait_for_samples(graph, tmp_path / "both")
    assert one.end(30.0) == 0 and both.end(30.0) == 0
    assert len(yaml.safe_load(rig.read_text())["taxel_positions_mm"]) == 3 and "more than one rig" not in one.output()


def test_a_vanished_directory_ends_with_one_sentence(graph, tmp_path):
    graph.driver()
    recorder = record(graph, tmp_path / "s")
    shutil.rmtree(tmp_path / "s")
    assert recorder.wait(60.0) == 2
    assert "recorder: " in recorder.output() and not ("Traceback" in recorder.output() or 'File "' in recorder.output())


def test_a_full_disk_ends_with_one_sentence_and_leaves_what_was_written_readable(graph, tmp_path):
    """A limit on the size of files stands in for the disk: the system refuses to write in the same way."""
    graph.driver()
    wrapper = tmp_path / "small.sh"
    from skin_models.ros.processes import Process, executable

    command = f"ulimit -f 400; exec {executable('skin_testbed_driver', 'recorder')} --ros-args -p directory:={tmp_path / 's'}"
    wrapper.write_text(command)
    process = Process(["bash", str(wrapper)], graph.domain.environment(), "recorder")
    graph.processes.running.append(process)
    assert process.wait(90.0) == 2
    assert "stays readable" in process.output() and not ("Traceback" in process.output() or 'File "' in process.output())
    count = 0
    with mcap_of(tmp_path / "s").open("rb") as file, pytest.raises(McapError):
        for record_ in StreamReader(file).records:
            count += type(record_).__name__ == "Message"
    assert count > 100


def test_sigterm_is_a_clean_end(graph, tmp_path):
    graph.driver()
    recorder = record(graph, tmp_path / "s")
    wait_for_samples(graph, tmp_path / "s")
    recorder.send(signal.SIGTERM)
    assert recorder.wait(60.0) == 0
    assert (tmp_path / "s" / "metadata.yaml").is_file()
