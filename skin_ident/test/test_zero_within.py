"""Bags in which the driver tells that a zero was set while it recorded: the parts are records of their own."""

import json
from dataclasses import replace

import numpy as np
import pytest
from making import KINDS, START_NS, recording, serialised, typestore
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_types_from_msg

from skin_ident.cli import diagnose, fit
from skin_ident.recordings.load import load

STATE = "skin_testbed_msgs/msg/DriverState"
TEXT = "std_msgs/Header header\nuint8 INACTIVE=0\nuint8 state\nstring reason\nbool zeroed\nbool tared\n"
COUNTS = "uint32 zero_count\nuint32 tare_count\n"
AT = 30.0  # s, where the zero of the second part begins


def moved(x=0.0, force=0.0):
    """40 s of a session of which the last quarter has other zeros."""
    r = recording(sigma=0.02)
    after = r.t > AT
    return replace(r, depth=r.depth + x * after, force=r.force + force * after)


def write(path, r, states, storage="mcap", text=TEXT + COUNTS):
    """A bag with the topics of a rig and `states`: time (s), zeroed, tared, and how often."""
    store = typestore()
    store.register(get_types_from_msg(text, STATE))
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3) as writer:
        lines = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in {**KINDS, "/driver_state": STATE}.items()}
        told = [("/driver_state", START_NS + round(1e9 * t), said(store, t, flags)) for t, *flags in states]
        for topic, log_ns, data in sorted([*serialised(r), *told], key=lambda entry: entry[1]):
            writer.write(lines[topic], log_ns, data)
    return path


def said(store, t, flags):
    kind, ns = store.types[STATE], START_NS + round(1e9 * t)
    stamp = store.types["builtin_interfaces/msg/Time"](ns // 10**9, ns % 10**9)
    fields = ("zeroed", "tared", "zero_count", "tare_count")
    known = {name: value for name, value in zip(fields, flags, strict=True) if name in kind.__dataclass_fields__}
    header = store.types["std_msgs/msg/Header"](stamp, "")
    return bytes(store.serialize_cdr(kind(header=header, state=1, reason="", **known), STATE))


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_zero_set_within_a_record_ends_it(tmp_path, storage):
    r = moved(x=20e-6)
    read = load(write(tmp_path / "bag", r, [(-1.0, True, True, 1, 1), (AT, True, True, 2, 1)], storage))[0]
    assert len(read) == np.count_nonzero(r.t < AT) and np.array_equal(read.depth, r.depth[: len(read)])
    assert read.warnings[0].startswith("the depth was zeroed anew at 30.00 s: ") and "left 1000 samples out" in read.warnings[0]


def test_states_that_change_no_zero_are_of_no_account(tmp_path):
    states = [(-1.0, True, True, 1, 1), (10.0, True, True, 1, 1), (50.0, True, True, 2, 1)]  # the last one behind the end
    read = load(write(tmp_path / "bag", moved(), states))[0]
    assert len(read) == 4000 and read.warnings == ()


def test_a_driver_that_does_not_count_tells_by_its_flags(tmp_path):
    states = [(-1.0, False, True, 0, 0), (AT - 1.0, True, True, 0, 0), (AT, True, False, 0, 0)]
    read = load(write(tmp_path / "bag", moved(x=20e-6, force=0.5), states, text=TEXT))[0]
    assert "the depth was zeroed anew at 29.00 s and the tare of the loads was reset at 30.00 s" in read.warnings[0]
    assert len(read) == 2900


def test_a_long_wait_for_the_tare_is_not_what_is_kept(tmp_path):
    r = moved(force=-0.5)
    r = replace(r, depth=np.where(r.t > AT, r.depth, -1e-3))
    read = load(write(tmp_path / "bag", r, [(-1.0, True, False, 1, 0), (AT, True, True, 1, 1)]))[0]
    assert len(read) == np.count_nonzero(r.t > AT) and np.array_equal(read.force, r.force[r.t > AT])


def test_fit_and_diagnose_say_it_and_the_stiffness_is_true(tmp_path, capsys):
    bag = write(tmp_path / "bag", moved(x=60e-6, force=0.5), [(0.0, True, True, 1, 1), (AT, True, True, 2, 2)])
    assert fit.main([str(bag), "--out", str(tmp_path / "fit")]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "note: bag: the depth was zeroed anew at 30.00 s and the loads were tared anew at 30.00 s" in printed
    k1 = json.loads((tmp_path / "fit" / "fit.json").read_text())["parameters"]["k1"]
    assert abs(k1["value"] - 9619.0) < 3.0 * k1["std"] < 60.0
    assert diagnose.main([str(bag), "--out", str(tmp_path / "answer")]) == 0
    findings = json.loads((tmp_path / "answer" / "findings.json").read_text())
    assert findings["findings"] == [] and any("zeroed anew at 30.00 s" in w for w in findings["warnings"])
