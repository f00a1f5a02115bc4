"""A recording leaves as a tab-delimited table and comes back as a bag, without loss."""

import errno
import io
import re
import subprocess

import numpy as np
import pytest
from mcap.reader import make_reader

from skin_testbed_driver.bag import BagError, _Stream
from skin_testbed_driver.rig import RigError
from skin_testbed_driver.rigs.replay import Recorded, Track
from skin_testbed_driver.rigs.table import read_table, write_table


def recorded(n: int = 500, taxels: int = 3) -> Recorded:
    """Encoder steps of 1 um, forces of any value, a taxel that is not known for a while."""
    rng = np.random.default_rng(1)
    t = 0.01 * np.arange(n)
    sensed = rng.normal(size=(n, taxels))
    sensed[100:110, -1:] = np.nan
    return Recorded(Track(t, 1e-6 * rng.integers(-2000, 2000, n)), Track(t, rng.normal(size=n)), Track(t, sensed))


@pytest.mark.parametrize("taxels", [0, 1, 3])
def test_a_table_reads_back_as_it_was_written(tmp_path, taxels):
    before = recorded(taxels=taxels)
    assert write_table(tmp_path / "run.tsv", before) == 500
    after = read_table(tmp_path / "run.tsv")
    for name, atol in (("depth", 1e-15), ("force", 1e-9), ("taxels", 1e-9)):
        np.testing.assert_allclose(getattr(after, name).t, getattr(before, name).t, atol=1e-9)
        np.testing.assert_allclose(getattr(after, name).values, getattr(before, name).values, atol=atol, rtol=0.0)


def test_the_table_begins_and_ends_with_what_was_recorded_of_everything(tmp_path):
    """Where the encoder is heard before the force there is nothing to read but a gap; a taxel that dies has its nan, and no rows go."""
    whole = recorded()
    whole.taxels.values[300:, 0] = np.nan
    late = Recorded(whole.depth, Track(whole.force.t[14:], whole.force.values[14:]), Track(whole.taxels.t[:490], whole.taxels.values[:490]))
    assert write_table(tmp_path / "run.tsv", late) == 476
    after = read_table(tmp_path / "run.tsv")
    assert after.depth.t[0] == 0.0 and np.isfinite(after.force.values).all() and np.isnan(after.taxels.values[290:, 0]).all()
    np.testing.assert_allclose(after.depth.values, whole.depth.values[14:490], atol=1e-15)


def test_the_table_has_tabs_a_header_with_units_and_a_row_per_sample(tmp_path):
    write_table(tmp_path / "run.tsv", recorded())
    lines = (tmp_path / "run.tsv").read_text().splitlines()
    assert lines[0].split("\t") == ["t_s", "x_mm", "force_n", "taxel_0_n", "taxel_1_n", "taxel_2_n"]
    assert len(lines) == 501 and {line.count("\t") for line in lines} == {5}


def test_taxels_are_in_the_order_of_their_numbers(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("t_s,x_mm,force_n,taxel_10_n,taxel_2_n\n0,0,0,10,2\n0.01,0,0,10,2\n")
    assert read_table(path).taxels.values.tolist() == [[2.0, 10.0]] * 2


@pytest.mark.parametrize(
    ("header", "word"), [("taxel_0_v,taxel_1_n", "taxel_0 is in volts"), ("taxel_0_n,taxel_0_n", "two columns taxel_0")]
)
def test_columns_that_would_be_lost_are_refused(tmp_path, header, word):
    path = tmp_path / "run.csv"
    path.write_text(f"t_s,x_mm,force_n,{header}\n0,0,0,1,1\n0.01,0,0,1,1\n")
    with pytest.raises(RigError, match=word):
        read_table(path)


def test_nothing_is_overwritten_and_nothing_is_left_half_written(tmp_path):
    (tmp_path / "run.tsv").write_text("mine")
    with pytest.raises(RigError, match="exists already"):
        write_table(tmp_path / "run.tsv", recorded())
    with pytest.raises(RigError, match="cannot write"):
        write_table(tmp_path / "nowhere" / "run.tsv", recorded())
    assert [p.name for p in tmp_path.iterdir()] == ["run.tsv"] and (tmp_path / "run.tsv").read_text() == "mine"


def run(name: str, *arguments: object) -> subprocess.CompletedProcess:
    from skin_models.ros.processes import executable

    command = [str(executable("skin_testbed_driver", name)), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_table_to_bag_to_table_is_the_same_table(tmp_path):
    pytest.importorskip("skin_testbed_msgs")
    write_table(tmp_path / "run.tsv", recorded())
    (tmp_path / "rig.yaml").write_text("sample_rate_hz: 100\n")
    assert run("import_table", tmp_path / "run.tsv", "--out", tmp_path / "bag", "--start", "1700000000.25").returncode == 0
    assert (tmp_path / "bag" / "rig.yaml").read_text() == "sample_rate_hz: 100\n"
    exported = run("export_table", tmp_path / "bag", "--out", tmp_path / "other" / "again.tsv")
    assert (exported.returncode, exported.stderr) == (0, "")
    assert exported.stdout == f"500 samples: wrote {tmp_path / 'other' / 'again.tsv'} and {tmp_path / 'other' / 'rig.yaml'}\n"
    assert (tmp_path / "other" / "again.tsv").read_text() == (tmp_path / "run.tsv").read_text()
    assert (tmp_path / "other" / "rig.yaml").exists()
    (tmp_path / "other" / "rig.yaml").write_text("sample_rate_hz: 50\n")
    refused = run("export_table", tmp_path / "bag", "--out", tmp_path / "other" / "third.tsv")
    assert refused.returncode == 2 and "another rig" in refused.stderr and not (tmp_path / "other" / "third.tsv").exists()
    way_out = tmp_path / "other" / "third_table" / "third.tsv"
    assert refused.stderr.endswith(f"such as --out {way_out}\n")
    assert run("export_table", tmp_path / "bag", "--out", way_out).returncode == 0 and way_out.is_file()
    (tmp_path / "bag" / "rig.yaml").unlink()
    doubted = run("export_table", tmp_path / "bag", "--out", tmp_path / "other" / "third.tsv")
    assert doubted.returncode == 0 and f"{tmp_path / 'other' / 'rig.yaml'} lies there already" in doubted.stderr


def test_what_cannot_be_used_ends_with_one_sentence_and_status_2(tmp_path):
    pytest.importorskip("skin_testbed_msgs")
    (tmp_path / "bad.tsv").write_text("t_s\tx_mm\n0\t0\n1\t1\n")
    for name, arguments in (("export_table", (tmp_path / "none",)), ("import_table", (tmp_path / "bad.tsv", "--out", tmp_path / "b"))):
        ended = run(name, *arguments)
        assert ended.returncode == 2 and len(ended.stderr.strip().splitlines()) == 1, ended
    assert not (tmp_path / "b").exists()


@pytest.mark.parametrize("late", [0, 1], ids=["at once", "later"])
def test_a_table_that_does_not_fit_on_the_disk_leaves_nothing_and_says_so(tmp_path, monkeypatch, late):
    pytest.importorskip("skin_testbed_msgs")
    from skin_testbed_driver.ros.import_table import import_table

    write, taken = _Stream.flush, []

    def flush(stream):
        taken.append(stream)
        if len(taken) > late:
            raise OSError(errno.ENOSPC, "No space left on device")
        write(stream)

    monkeypatch.setattr(_Stream, "flush", flush)
    write_table(tmp_path / "run.tsv", recorded())
    with pytest.raises(BagError, match="the disk is full; nothing of it is kept"):
        import_table(tmp_path / "run.tsv", tmp_path / "b")
    assert not (tmp_path / "b").exists()


def test_an_existing_recording_stays_where_a_table_would_be_imported(tmp_path):
    pytest.importorskip("skin_testbed_msgs")
    from skin_testbed_driver.ros.import_table import import_table

    write_table(tmp_path / "run.tsv", recorded())
    (tmp_path / "b").mkdir()
    with pytest.raises(BagError, match="never overwritten"):
        import_table(tmp_path / "run.tsv", tmp_path / "b")
    assert (tmp_path / "b").exists()


def test_a_file_that_is_cut_off_says_how_much_of_it_was_read(tmp_path):
    pytest.importorskip("skin_testbed_msgs")
    write_table(tmp_path / "run.tsv", recorded(n=20000))
    assert run("import_table", tmp_path / "run.tsv", "--out", tmp_path / "bag").returncode == 0
    data = (tmp_path / "bag" / "bag_0.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(data[: int(0.6 * len(data))])
    exported = run("export_table", tmp_path / "cut.mcap", "--out", tmp_path / "cut.tsv")
    rows = len((tmp_path / "cut.tsv").read_text().splitlines()) - 1
    assert exported.returncode == 0 and 5000 < rows < 20000 and len(exported.stderr.splitlines()) == 1
    read = int(re.search(r"cut.mcap is cut off: (\d+) samples of encoder", exported.stderr)[1])
    assert read - 3 < rows <= read, "of the last samples the file may hold the depth alone"
    assert f"up to {0.01 * (read - 1):.2f} s" in exported.stderr and exported.stdout.startswith(f"{rows} samples: wrote")
    (tmp_path / "cut.mcap").write_bytes(data[:100])
    refused = run("export_table", tmp_path / "cut.mcap", "--out", tmp_path / "none.tsv")
    assert refused.returncode == 2 and "cut off" in refused.stderr and not (tmp_path / "none.tsv").exists()
    (tmp_path / "file").touch()
    refused = run("export_table", tmp_path / "bag", "--out", tmp_path / "file" / "none.tsv")
    assert refused.returncode == 2 and refused.stderr.count("\n") == 1


def test_a_damaged_chunk_is_left_out_and_said(tmp_path):
    pytest.importorskip("skin_testbed_msgs")
    write_table(tmp_path / "run.tsv", recorded(n=20000))
    assert run("import_table", tmp_path / "run.tsv", "--out", tmp_path / "bag").returncode == 0
    file = tmp_path / "bag" / "bag_0.mcap"
    data = bytearray(file.read_bytes())
    chunk = make_reader(io.BytesIO(data)).get_summary().chunk_indexes[3]
    data[chunk.chunk_start_offset + chunk.chunk_length // 2] ^= 0x10
    file.write_bytes(data)
    exported = run("export_table", tmp_path / "bag", "--out", tmp_path / "again.tsv")
    assert exported.returncode == 0 and "1 damaged chunk" in exported.stderr, exported.stderr


@pytest.mark.parametrize(("name", "says"), [("b_0.db3", "ros2 bag convert"), ("b_0.mcap", "is empty"), ("b.txt", "no recording at")])
def test_a_bag_of_another_kind_is_refused_in_a_sentence(tmp_path, name, says):
    pytest.importorskip("skin_testbed_msgs")
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / name).write_bytes(b"")
    ended = run("export_table", tmp_path / "bag", "--out", tmp_path / "out.tsv")
    assert ended.returncode == 2 and says in ended.stderr and ended.stderr.count("\n") == 1


def test_a_recorded_session_is_exported_sample_by_sample(graph, tmp_path):
    pytest.importorskip("skin_testbed_msgs")
    graph.driver(taxels=2)
    parameters = {"directory": str(tmp_path / "s"), "topics": ["encoder", "force", "taxels"]}
    recorder = graph.processes.start("skin_testbed_driver", "recorder", parameters=parameters)
    recorder.wait_for_output("every topic", 60.0)
    graph.command((1.0, 5e-4, 0.0))
    from skin_testbed_msgs.msg import TaxelArray

    taxels = graph.hear(TaxelArray, "taxels")
    graph.wait(lambda: len(taxels) > 200, "samples")
    recorder.end(30.0)
    assert run("export_table", tmp_path / "s", "--out", tmp_path / "s.tsv").returncode == 0
    table = read_table(tmp_path / "s.tsv")
    assert table.depth.t.size > 200 and np.allclose(np.diff(table.depth.t), 0.01)
    by_time = {round(m.header.stamp.sec * 100 + m.header.stamp.nanosec * 1e-7): m.force[1] for m in taxels}
    sensed = {round(v, 9) for v in by_time.values()}
    assert len(sensed & set(table.taxels.values[:, 1].tolist())) > 0.9 * len(sensed)
