"""Bags whose topics come at rates and instants of their own: what a slow taxel reads is judged as it was read. And how bags and topics are
named."""

from dataclasses import replace

import numpy as np
import pytest
from making import KINDS, recording, serialised, typestore, write_bag
from rosbags.rosbag2 import StoragePlugin, Writer

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.errors import DiagnosisError
from skin_ident.recordings.chosen import only_taxels
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.load import load
from skin_ident.recordings.readings import Readings, between
from skin_ident.recordings.recording import FORCE_TO_FORCE
from skin_ident.recordings.rows import interpolated

DT, STEP = 0.002, 0.01  # s, N


def session(i, change=lambda taxel, rng: taxel, every=5):
    """Two taxels in noise that wanders, read in steps; `change` alters the first, of which every so many samples will be kept."""
    rng = np.random.default_rng(40 + i)
    r = recording(10 * i + 1, shares=(0.7, 0.3), sigma=0.03, rho=0.9, name=f"run_{i}", dt=DT, n=10_000, hz=(0.5, 0.7, 0.6)[i])
    taxels = STEP * np.round(r.taxels / STEP)
    taxels[0] = np.repeat(change(taxels[0, ::every].copy(), rng), every)[: len(r)]
    return replace(r, force=STEP * np.round(r.force / STEP), taxels=taxels)


def bag_of(path, r, every=5, topics=KINDS):
    """A bag of some topics, in which taxels come once for so many samples of depth and force, half a sample late."""

    def late(store, i, message):
        if "TaxelArray" in type(message).__name__:
            stamp = message.header.stamp
            stamp.nanosec += int(0.5e9 * DT)
            stamp.sec, stamp.nanosec = stamp.sec + stamp.nanosec // 10**9, stamp.nanosec % 10**9
        return message

    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        lines = {topic: writer.add_connection(topic, KINDS[topic], typestore=typestore()) for topic in topics}
        for k, (topic, log, data) in enumerate(serialised(r, change=late)):
            if topic in topics and (topic != "/taxels" or (k // len(KINDS)) % every == 0):
                writer.write(lines[topic], log, data)
    return path


def told(tmp_path, change, every=5):
    """The findings on two bags and a third held out, of which the second has its first taxel changed."""
    made = [session(i, change if i == 1 else lambda taxel, _: taxel, every) for i in range(3)]
    recordings = [one for r in made for one in load(bag_of(tmp_path / r.name, r, every))]
    return [(f["cause"], f["where"]) for f in diagnose(recordings[:2], recordings[2:]).findings["findings"]]


def spiked(taxel, rng):
    taxel[rng.integers(50, taxel.size - 50, 8)] += 5.0
    return taxel


def frozen(taxel, rng):
    for start in rng.choice(np.arange(60, taxel.size - 60, 40), 6, replace=False):
        taxel[start : start + 12] = taxel[start]
    return taxel


def written_twice(taxel, rng):
    taxel[700:1000] = taxel[310:610]
    return taxel


@pytest.mark.parametrize("every", [2, 5, 10])
def test_a_sound_slow_taxel_is_told_nothing(tmp_path, every):
    """Two equal readings in a row are many equal samples, and straight lines between readings lose what moves quickly."""
    assert told(tmp_path, lambda taxel, _: taxel, every) == []


@pytest.mark.parametrize(("change", "cause"), [(spiked, "outliers"), (frozen, "outliers"), (written_twice, "data_error")])
def test_faults_of_single_readings_are_found_in_a_slow_taxel(tmp_path, change, cause):
    assert told(tmp_path, change) == [(cause, "taxel_0")]


def test_a_topic_that_hardly_ever_comes_is_refused_by_its_name(tmp_path):
    recordings = [one for i in range(2) for one in load(bag_of(tmp_path / f"bag_{i}", session(i), 250))]
    with pytest.raises(DiagnosisError, match="taxel_0 comes every"):
        diagnose(recordings)


@pytest.mark.parametrize("every", [1, 5])
def test_without_a_depth_taxels_are_brought_onto_the_instants_of_the_force(tmp_path, every):
    made = recording(3, shares=(0.7,), sigma=0.0, dt=DT, n=5000, hz=0.5)
    (r,) = load(bag_of(tmp_path / "bag", made, every, ("/force", "/taxels")))
    assert r.kind == FORCE_TO_FORCE and "taxels: interpolated to the instants of the force" in " ".join(r.warnings)
    first = int(np.flatnonzero(made.force == r.force[0])[0])  # the one before has no taxel beside it
    assert np.array_equal(r.force, made.force[first : first + len(r)]) and len(r) > len(made) - 2 * every - 1
    late = r.t + (first - 0.5) * DT
    assert np.allclose(r.taxels[0], np.interp(late, made.t, made.taxels[0]), atol=1e-3)
    assert list(r.readings) == ["taxel_0"] and r.longest_period == pytest.approx(every * DT)


def test_what_lies_between_readings_keeps_its_size():
    """At a sixth of the rate, straight lines lose a twelfth."""
    known, t = np.arange(0.0, 20.0, 0.02), np.arange(1.0, 19.0, 0.001)
    wave = 2.0 * np.pi / 6.01 / 0.02
    rows = np.sin(wave * known)[None]
    meant = np.sin(wave * t)
    kept, lost = (float(f(t, known, rows)[0] @ meant / (meant @ meant)) for f in (between, interpolated))
    assert abs(kept - 1.0) < 3e-3 and lost == pytest.approx(np.sinc(1.0 / 6.01) ** 2, abs=2e-3)


@pytest.mark.parametrize("few", [2, 10])
def test_of_a_channel_read_more_often_noise_is_not_folded_into_the_recording(few):
    """What is slow stays; of white noise the share that lies below half the recording's rate."""
    rng, known = np.random.default_rng(few), np.arange(40_000) * 1e-3
    t, wave = known[::few][20:-20], 2.0 * np.pi * 0.05 / few / 1e-3
    kept, left = between(t, known, np.array([np.sin(wave * known), rng.normal(size=known.size)]))
    assert np.allclose(kept, np.sin(wave * t), atol=2e-3) and np.std(left) == pytest.approx(np.sqrt(1.0 / few), rel=0.15)


@pytest.mark.parametrize("tremble", [0.0, 0.2, 0.7])
def test_readings_with_lost_ones_and_trembling_stamps_stay_between_their_neighbours(tremble):
    """Where curves would swing between stamps that nearly meet, or over a gap, lines are drawn."""
    rng = np.random.default_rng(3)
    known = np.sort(np.arange(500) * 0.01 + tremble * 0.01 * rng.uniform(-0.5, 0.5, 500))
    known = np.delete(known, np.arange(200, 206))
    rows, t = rng.normal(size=(2, known.size)), np.arange(0.02, 4.95, 0.001)
    gap = (t > known[199]) & (t < known[200])
    out = between(t, known, rows)
    assert np.allclose(out[:, gap], interpolated(t, known, rows)[:, gap]) and np.abs(out).max() < 1.3 * np.abs(rows).max()


def test_readings_go_with_their_taxels_signs_and_stretches(tmp_path):
    (r,) = load(bag_of(tmp_path / "bag", session(0)))
    (second,) = only_taxels([r], ["1"])
    assert list(r.readings) == ["taxel_0", "taxel_1"] and list(second.readings) == ["taxel_0"]
    assert np.array_equal(second.readings["taxel_0"].y, r.readings["taxel_1"].y)
    assert r.longest_period == pytest.approx(5 * DT)
    turned = r.scaled({"taxel_0": -1.0})
    assert np.array_equal(turned.readings["taxel_0"].y, -r.readings["taxel_0"].y) and np.array_equal(turned.taxels[0], -r.taxels[0])
    cut = r.part(1000, 2000).readings["taxel_0"]
    assert r.t[1000] <= cut.t[0] and cut.t[-1] <= r.t[1999] and abs(cut.t.size - 200) <= 1
    assert r.part(1000, 1050).own("taxel_0") is None
    assert "taxel_0" not in r.with_channels({"taxel_0": r.taxels[0]}).readings


def test_samples_that_hang_on_a_reading_lie_between_its_neighbours():
    t, own = 0.001 * np.arange(100), Readings(0.0052 + 0.01 * np.arange(9), np.zeros(9))
    wrong = np.arange(9) == 4
    assert np.flatnonzero(own.spanned(wrong, t)).tolist() == list(range(36, 56))
    assert np.flatnonzero(own.ringing(own.spanned(wrong, t), 0.001)).tolist() == list(range(16, 76))
    assert np.flatnonzero(own.spanned(wrong, t[::40])).tolist() == [1]


@pytest.mark.parametrize("every", [2, 7])
def test_a_row_that_stands_still_does_so_between_its_readings_and_a_ceiling_is_not_exceeded(every):
    known, t = 0.001 * every * np.arange(600), 0.001 * np.arange(600 * every - every)
    clipped = np.clip(3.0 * np.sin(2.0 * known), None, 2.1)
    stuck, told = between(t, known, np.array([np.full(known.size, 1.65), clipped]))
    assert np.ptp(stuck) == 0.0 and told.max() == 2.1
    assert np.mean(told == 2.1) == pytest.approx(np.mean(clipped == 2.1), abs=0.02)


def test_two_topics_of_one_role_are_refused(tmp_path):
    with pytest.raises(RecordingError, match="names encoder and depth, which are the same"):
        load(write_bag(tmp_path / "bag", recording(n=300)), {"encoder": "/encoder", "depth": "/encoder"})


@pytest.mark.parametrize("path", [".", "../bag/.", "deeper/.."])
def test_a_bag_that_is_named_from_within_has_its_own_name_and_rig(tmp_path, monkeypatch, path):
    (write_bag(tmp_path / "bag", recording(n=300)) / "deeper").mkdir()
    (tmp_path / "rig.yaml").write_text("skin_thickness_mm: 4\n")
    monkeypatch.chdir(tmp_path / "bag")
    (r,) = load(path)
    assert r.name == "bag" and r.declared.skin_thickness_mm == 4
