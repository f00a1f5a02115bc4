"""Many sessions at once: one table, failures in it, and nothing is done twice."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from making import SILICONE, recording, write_bag, write_mcap, write_table

from skin_ident import batch
from skin_ident.batch import JOURNAL, run_batch
from skin_ident.batch import write_table as write_rows
from skin_ident.cli.fit import main
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.fit import Options


@pytest.fixture
def folder(tmp_path):
    data = tmp_path / "data"
    data.mkdir()
    for i in range(6):
        write_table(data / f"s{i}.csv", recording(i, n=800))
    (data / "broken.csv").write_text("t_s,x,force_n\n0,1,2\n")
    return data


def test_every_session_gives_a_row_and_a_second_call_does_nothing(folder, tmp_path):
    out, seen = tmp_path / "out", []
    out.mkdir()
    paths = sorted(folder.glob("*.csv"))
    rows = run_batch(paths, out, Options(mass=str(SILICONE[4][0])), jobs=2, progress=lambda done, total, row: seen.append(done))
    assert [row["status"] for row in rows] == ["failed", *["ok"] * 6] and seen == list(range(1, 8))
    assert rows[1]["k1"] == pytest.approx(9619, rel=0.01) and "unit" in rows[0]["why"]
    again = run_batch(paths, out, Options(mass=str(SILICONE[4][0])), jobs=2, progress=lambda *_: pytest.fail("fitted again"))
    assert again == rows
    assert len(run_batch(paths, out, Options(mass="free"), jobs=2)) == 7  # other options, other fits
    write_rows(rows, out / "fits.csv")
    assert len(list(csv.DictReader((out / "fits.csv").open()))) == 7


def test_a_link_to_nothing_is_a_row_like_others(folder, tmp_path):
    (folder / "gone.csv").symlink_to(tmp_path / "nowhere.csv")
    row = run_batch([folder / "gone.csv"], tmp_path, jobs=1)[0]
    assert row["status"] == "failed" and "link to nothing" in row["why"]


@pytest.mark.parametrize("form", ["table", "bag"])
def test_a_rig_file_that_is_edited_is_heard(tmp_path, form):
    """Beside a bag, it lies outside of the folder that the bag is."""
    r = recording(1, n=800)
    path = write_table(tmp_path / "s.csv", r) if form == "table" else write_bag(tmp_path / "s", r)
    masses = []
    for declared in (None, "moving_mass_kg: 0.001\n", "moving_mass_kg: 0.002\n", "moving_mass_kg: 0.001\n"):
        if declared:
            (tmp_path / "rig.yaml").write_text(declared)
        masses.append(run_batch([path], tmp_path, jobs=1)[0]["m"])
    assert masses == [0.000432, 0.001, 0.002, 0.001] and len((tmp_path / JOURNAL).read_text().splitlines()) == 3


def test_resumes_after_a_crash(folder, tmp_path):
    paths = sorted(folder.glob("s*.csv"))[:3]
    run_batch(paths[:2], tmp_path, jobs=1)
    journal = tmp_path / JOURNAL
    lines = journal.read_text().splitlines()
    journal.write_text(lines[0] + "\n" + lines[1][: len(lines[1]) // 2])
    fresh = []
    rows = run_batch(paths, tmp_path, jobs=1, progress=lambda done, total, row: fresh.append(row["path"]))
    assert len(rows) == 3 and len(fresh) == 2 and all(row["status"] == "ok" for row in rows)
    assert [json.loads(line)["status"] for line in journal.read_text().splitlines()[2:]] == ["ok", "ok"]
    run_batch(paths, tmp_path, jobs=1, progress=lambda *_: pytest.fail("fitted again"))


def children_of(number):
    """Process numbers, as Linux lists them."""
    return [int(n) for task in Path(f"/proc/{number}/task").iterdir() for n in (task / "children").read_text().split()]


def gone(number):
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


def test_a_killed_batch_leaves_no_process_behind_and_goes_on(folder, tmp_path):
    command = [sys.executable, "-m", "skin_ident.cli.fit", folder, "--each", "--jobs", "2", "--out", tmp_path / "out"]
    for i in range(40):
        write_table(folder / f"t{i:03}.csv", recording(i, n=400))
    started = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    for _ in range(4):
        started.stderr.readline()  # a row is finished
    workers = children_of(started.pid)
    started.kill()
    started.wait(10)
    until = time.monotonic() + 20.0
    while not all(map(gone, workers)) and time.monotonic() < until:
        time.sleep(0.05)
    assert workers and all(map(gone, workers))
    done = (tmp_path / "out" / JOURNAL).read_text().count("\n")
    assert 1 <= done < 47 and not (tmp_path / "out" / "fits.csv").exists()
    again = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert again.returncode == 2 and again.stderr.count("\n") == 47 - done + 1 and "46 sessions fitted, 1 failed" in again.stdout


def test_an_interrupted_batch_says_what_is_kept(folder, tmp_path):
    for i in range(40):
        write_table(folder / f"t{i:03}.csv", recording(i, n=400))
    # tests that run in the background have Ctrl-C switched off, and so have their children
    program = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); from skin_ident.cli.fit import main; exit(main())"
    command = [sys.executable, "-c", program, folder, "--each", "--jobs", "2", "--out", tmp_path / "out"]
    started = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True)
    started.stderr.readline()
    os.killpg(started.pid, signal.SIGINT)  # as a terminal does: to all of them
    said = started.communicate(timeout=60)[1]
    assert started.returncode == 130 and "the same call goes on from there" in said and "Traceback" not in said
    assert 1 <= (tmp_path / "out" / JOURNAL).read_text().count("\n") < 40


@pytest.mark.parametrize("there", [False, True])
def test_a_batch_that_is_interrupted_before_its_first_row_leaves_nothing(folder, tmp_path, monkeypatch, capsys, there):
    def interrupted(*_):
        raise KeyboardInterrupt
        yield

    monkeypatch.setattr(batch, "_rows", interrupted)
    if there:
        (tmp_path / "out").mkdir()
    assert main([str(folder), "--each", "--out", str(tmp_path / "out")]) == 130
    said = capsys.readouterr().err
    assert said == "no session was finished yet\ninterrupted; nothing was written\n"
    assert (tmp_path / "out").exists() is there and not (there and list((tmp_path / "out").iterdir()))


def test_on_a_command_line(folder, tmp_path, capsys):
    assert main([str(folder), "--each", "--jobs", "2", "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr()
    assert said.err.splitlines()[-1].startswith("error: 1 of 7 sessions could not be fitted")
    assert "6 sessions fitted, 1 failed" in said.out and "broken.csv" in said.out and "[7/7]" in said.err
    assert len((tmp_path / "out" / "fits.csv").read_text().splitlines()) == 8


def test_parquet_holds_what_csv_holds(folder, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    arguments = [str(folder), "--each", "--jobs", "2", "--out", str(tmp_path / "out")]
    assert main([*arguments, "--format", "parquet"]) == main(arguments) == 2  # the second reads the journal of the first
    table = parquet.read_table(tmp_path / "out" / "fits.parquet")
    rows = list(csv.DictReader((tmp_path / "out" / "fits.csv").open()))
    assert table.column_names == list(rows[0]) and table.num_rows == len(rows) == 7
    for typed, text in zip(table.to_pylist(), rows, strict=True):
        assert {k: "" if v is None else str(v) for k, v in typed.items()} == text
    assert not list((tmp_path / "out").glob("*.partial"))


def test_parquet_without_its_library_is_refused_before_any_work(folder, tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    assert main([str(folder), "--each", "--out", str(tmp_path / "out"), "--format", "parquet"]) == 2
    assert "pip install pyarrow" in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_log_times_reach_the_batch(tmp_path):
    """Stamps that stand still: refused by themselves, fitted by the times of recording."""

    def frozen(store, i, message):
        message.header.stamp.sec, message.header.stamp.nanosec = 5, 0
        return message

    bag = write_mcap(tmp_path / "a.mcap", recording(n=800), log_delay_ns=0, change=frozen)
    (by_stamp,), (by_log,) = (run_batch([bag], tmp_path, jobs=1, log_time=log) for log in (False, True))
    assert "--log-time" in by_stamp["why"] and by_log["status"] == "ok"


def test_nothing_fitted_is_an_error(folder, tmp_path, capsys):
    assert main([str(folder / "broken.csv"), "--each", "--out", str(tmp_path / "out")]) == 2
    assert main([str(folder), "--each"]) == 2 and "--out" in capsys.readouterr().err


def test_no_scheduler_answers(folder, tmp_path):
    with pytest.raises(FitError, match=r"not installed|no Dask scheduler"):
        run_batch([folder / "s0.csv"], tmp_path, scheduler="tcp://127.0.0.1:9")


def test_no_scheduler_leaves_no_folder(folder, tmp_path, capsys):
    assert main([str(folder), "--each", "--out", str(tmp_path / "out"), "--scheduler", "tcp://127.0.0.1:9"]) == 2
    assert "Dask" in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_on_a_dask_cluster(folder, tmp_path):
    """A real scheduler and a real worker, each a process."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None, host="127.0.0.1") as cluster:
        rows = run_batch(sorted(folder.glob("s*.csv")), tmp_path, scheduler=cluster.scheduler_address)
    assert [row["status"] for row in rows] == ["ok"] * 6
