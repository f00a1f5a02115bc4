"""`fit` as a user meets it: a table and two files, or one sentence and status 2 with nothing written."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from making import SILICONE, recording, write_bag, write_mcap, write_table

from skin_ident.cli.common import write_json
from skin_ident.cli.fit import main
from skin_ident.recordings.recording import Recording
from skin_models.model_file import load_model

R = recording(n=1500, shares=(1.0, 0.4))


@pytest.fixture
def fit(capsys):
    """Run the command in this process: status and what it printed."""

    def run(*arguments):
        status = main([str(a) for a in arguments])
        return SimpleNamespace(returncode=status, **dict(zip(("stdout", "stderr"), capsys.readouterr(), strict=True)))

    return run


def test_as_a_program(tmp_path):
    command = [sys.executable, "-m", "skin_ident.cli.fit", tmp_path / "nowhere"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and "error: " in done.stderr and "Traceback" not in done.stderr


def test_prints_a_table_and_writes_two_files(fit, tmp_path):
    write_bag(tmp_path / "in" / "a", R)
    write_table(tmp_path / "in" / "b.csv", R)
    done = fit(tmp_path / "in", "--thickness-mm", 4, "--out", tmp_path / "out")
    assert done.returncode == 0 and "identifiable" in done.stdout and "N*s/m" in done.stdout and "Traceback" not in done.stderr
    content = json.loads((tmp_path / "out" / "fit.json").read_text())
    k1 = content["parameters"]["k1"]
    assert k1["ci95"][0] < 9619 < k1["ci95"][1] and content["parameters"]["m"]["value"] == pytest.approx(SILICONE[4][0])
    assert load_model(tmp_path / "out" / "model.yaml").dispersion.k1 == pytest.approx(k1["value"])


def test_the_answer_of_a_diagnosis_is_not_written_over(fit, tmp_path):
    (tmp_path / "findings.json").write_text("{}")
    (tmp_path / "model.yaml").write_text("extended")
    done = fit(write_table(tmp_path / "a.csv", R), "--out", tmp_path)
    assert done.returncode == 2 and "name another folder" in done.stderr and done.stderr.count("\n") == 1
    assert (tmp_path / "model.yaml").read_text() == "extended" and not (tmp_path / "fit.json").exists()


@pytest.mark.parametrize(
    "more",
    [["--mass", "free"], ["--mass", "0.001"], ["--motion", "sinusoid"], ["--bootstrap", "50"], ["--profile"], ["--offsets", "--profile"]],
)
def test_options(fit, tmp_path, more):
    done = fit(write_table(tmp_path / "a.csv", R), *more)
    assert done.returncode == 0 and not list(tmp_path.glob("*.yaml"))


def test_taxels_that_the_plunger_does_not_reach_have_no_say(fit, tmp_path):
    done = fit(write_table(tmp_path / "a.csv", recording(n=3000, shares=(1.0, 0.0, 0.0))), "--out", tmp_path / "out")
    found = json.loads((tmp_path / "out" / "fit.json").read_text())
    verdicts = {name: p["verdict"] for name, p in found["parameters"].items()}
    assert [verdicts[n] for n in ("b1", "k1", "share_1", "share_2")] == ["identifiable"] * 2 + ["not identifiable"] * 2
    assert list(found["notes"]["latency_behind_depth_ms"]) == ["force", "taxel_0"]
    assert done.stdout.count("taxel_1, taxel_2: next to nothing") == 1


def test_the_sinusoid_that_was_fitted_is_printed(fit, tmp_path):
    done = fit(write_table(tmp_path / "a.csv", R), "--motion", "sinusoid")
    assert "A 0.3 mm, B 1.5708 rad/s, C 0.5 mm, t0 " in done.stdout


def test_a_session_given_twice_counts_once(fit, tmp_path):
    write_bag(tmp_path / "in" / "a", R)
    write_table(tmp_path / "in" / "b.csv", R)
    once, twice = fit(tmp_path / "in" / "a"), fit(tmp_path / "in")
    assert "b.csv holds the same samples" in twice.stdout and "1 session (a)" in twice.stdout
    assert [line for line in once.stdout.splitlines() if line.startswith("  k1 ")] == [
        line for line in twice.stdout.splitlines() if line.startswith("  k1 ")
    ]


def test_a_full_disk_is_said_in_one_sentence(tmp_path):
    path = write_table(tmp_path / "a.csv", R)
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "skin_ident.cli.fit", path], stdout=full, stderr=subprocess.PIPE, text=True, timeout=60
        )
    errors = [line for line in done.stderr.splitlines() if "reading" not in line and "fitting" not in line]
    assert done.returncode == 2 and len(errors) == 1 and "No space left" in errors[0], done.stderr


@pytest.mark.parametrize("fails", ["write", "rename"])
def test_nothing_half_written_is_left(tmp_path, monkeypatch, fails):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_text" if fails == "write" else "pathlib.Path.replace", full)
    with pytest.raises(OSError, match="No space"):
        write_json(tmp_path / "fit.json", {"a": 1})
    assert not list(tmp_path.iterdir())


def test_force_to_force_writes_no_model(fit, tmp_path):
    lines = write_table(tmp_path / "b.csv", R).read_text().splitlines()
    (tmp_path / "a.csv").write_text("\n".join(",".join(line.split(",")[i] for i in (0, 2, 3)) for line in lines))
    done = fit(tmp_path / "a.csv", "--out", tmp_path / "out")
    assert done.returncode == 0 and "share" in done.stdout and [p.name for p in (tmp_path / "out").iterdir()] == ["fit.json"]


def truncated(path):
    data = write_mcap(path, R).read_bytes()
    path.write_bytes(data[:300])
    return path


def commas(path):
    path.write_text(path.read_text().replace(",", ";").replace(".", ","))
    return path


UNHEARD = {
    "the table of one fit": (["--format", "parquet"], "--format is for many sessions"),
    "the processes of one fit": (["--jobs", "2"], "--jobs is for many sessions"),
    "a cluster for one fit": (["--scheduler", "tcp://host:8786"], "--scheduler is for many sessions"),
    "an order where there is a depth": (["--order", "1"], "a.csv has a depth"),
    "an order of straight lines": (["--order", "2", "--what", "stiffness"], "--order is that of a fit from force to force"),
    "topics of a table": (["--topics", "force=/ft"], "--topics is for bags"),
    "times of recording of a table": (["--log-time"], "--log-time is for bags"),
    "the same for each": (["--log-time", "--each", "--out", "OUT"], "--log-time is for bags"),
}


@pytest.mark.parametrize("case", UNHEARD)
def test_options_that_would_not_be_heard_are_refused(fit, tmp_path, case):
    more, says = UNHEARD[case]
    done = fit(write_table(tmp_path / "a.csv", R), *(str(tmp_path / "out") if word == "OUT" else word for word in more))
    assert done.returncode == 2 and says in done.stderr and not done.stdout and not (tmp_path / "out").exists()


@pytest.mark.parametrize("more", [[], ["--each"], ["--what", "prony"]])
def test_milliseconds_under_a_title_that_says_seconds_are_refused(fit, tmp_path, more):
    slow = write_table(tmp_path / "a.csv", replace(R, t=1e3 * R.t))
    done = fit(slow, *more, "--out", tmp_path / "out")
    asked = "is the time in milliseconds? If it is not, declare sample_rate_hz in rig.yaml"
    assert done.returncode == 2 and asked in done.stdout + done.stderr and not (tmp_path / "out" / "fit.json").exists()


BAD = {
    "missing": lambda d: [d / "nowhere"],
    "empty bag": lambda d: [(d / "a.mcap").touch() or d / "a.mcap"],
    "truncated to nothing": lambda d: [truncated(d / "a.mcap")],
    "empty folder": lambda d: [d],
    "unit missing": lambda d: [(d / "a.csv").write_text("t_s,x,force_n\n0,1,2\n") and d / "a.csv"],
    "in the air": lambda d: [write_table(d / "a.csv", Recording("a", R.t, R.depth - 1.0e-3, R.force, R.taxels))],
    "wrong topic": lambda d: [write_mcap(d / "a.mcap", R), "--topics", "force=/ft"],
    "topics without a role": lambda d: [write_mcap(d / "a.mcap", R), "--topics", "/ft"],
    "mass that is none": lambda d: [write_table(d / "a.csv", R), "--mass", "heavy"],
    "bad rig.yaml": lambda d: [(d / "rig.yaml").write_text("skin_thickness_mm: [") and write_table(d / "a.csv", R)],
    "nothing but comments": lambda d: [(d / "a.csv").write_text("# only\n# comments\n") and d / "a.csv"],
    "a device": lambda d: ["/dev/null"],
    "no name": lambda d: [""],
    "a link to nothing": lambda d: [(d / "a.mcap").symlink_to(d / "gone") or d],
    "a role twice": lambda d: [write_mcap(d / "a.mcap", R), "--topics", "force=/force", "force=/ft"],
    "no thickness": lambda d: [write_table(d / "a.csv", R), "--thickness_mm", "-4"],
    "a night of bootstrap": lambda d: [write_table(d / "a.csv", R), "--bootstrap", "1000000000"],
    "a picture": lambda d: [(d / "a.png").write_bytes(b"\x89PNG") and d / "a.png"],
    "binary in a table": lambda d: [(d / "a.csv").write_bytes(bytes(range(256))) and d / "a.csv"],
    "none of it": lambda d: [write_table(d / "a.csv", R), "--bootstrap", "0"],
    "no bootstrap at all": lambda d: [write_table(d / "a.csv", R), "--bootstrap", "-3"],
    "no name in a batch": lambda d: ["", "--each"],
    "no processes": lambda d: [write_table(d / "a.csv", R), "--each", "--jobs", "-1"],
    "profiles of a batch": lambda d: [write_table(d / "a.csv", R), "--each", "--profile"],
    "decimal commas": lambda d: [commas(write_table(d / "a.csv", R))],
    "a plunger that never moves": lambda d: [write_table(d / "a.csv", Recording("a", R.t, 0 * R.depth + 5e-4, R.force, R.taxels))],
    "a dead load cell": lambda d: [write_table(d / "a.csv", Recording("a", R.t, R.depth, 0 * R.force, R.taxels))],
    "output is a file": lambda d: [write_table(d / "a.csv", R), "--out", d / "a.csv"],
    "output in a file": lambda d: [write_table(d / "a.csv", R), "--out", d / "a.csv" / "deeper" / "still"],
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_ends_in_one_sentence(fit, tmp_path, case):
    arguments = BAD[case](tmp_path)
    out = [] if "--out" in arguments else ["--out", tmp_path / "out"]
    done = fit(*arguments, *out)
    errors = [line for line in done.stderr.splitlines() if line.startswith("error:")]
    assert done.returncode == 2 and len(errors) == 1 and "Traceback" not in done.stderr, done.stderr
    assert done.stdout == ""
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="/proc is where nothing can be made, whoever asks")
@pytest.mark.parametrize("more", [[], ["--each"], ["--what", "stiffness"]])
def test_a_folder_that_cannot_be_made_is_refused_before_any_work(fit, tmp_path, more):
    done = fit(write_table(tmp_path / "a.csv", R), *more, "--out", "/proc/deeper/still")
    assert done.returncode == 2 and done.stderr.startswith("error: cannot write into /proc/deeper/still: nothing can be made in /proc")
    assert done.stderr.count("\n") == 1 and done.stdout == ""  # not even that it reads


@pytest.mark.parametrize("more", ["--bootstrap abc", "--loss foo", "--mass -1", "--mass nan", "--bootstrap -3", "--no-such-thing"])
def test_wrong_arguments_are_one_line_before_anything_is_read(fit, tmp_path, more):
    done = fit(write_table(tmp_path / "a.csv", R), *more.split())
    assert done.returncode == 2 and done.stderr.startswith("error: ") and done.stderr.count("\n") == 1 and done.stdout == ""


@pytest.mark.parametrize("order", [1, 2])
def test_noise_between_forces_claims_nothing(fit, tmp_path, order):
    for seed in range(6):
        y = np.random.default_rng(seed).uniform(size=(400, 2))
        (tmp_path / "a.csv").write_text("t_s,force_n,taxel_0_n\n" + "".join(f"{0.01 * i},{a},{b}\n" for i, (a, b) in enumerate(y)))
        done = fit(tmp_path / "a.csv", "--order", order)
        assert "Traceback" not in done.stderr and (done.returncode == 2 or "its parameters mean little" in done.stdout)


def test_exact_data_have_no_likelihood(fit, tmp_path):
    path = write_table(tmp_path / "a.csv", recording(sigma=0.0, n=1500, shares=(1.0, 0.4)))
    assert "no likelihood" in fit(path, "--profile").stderr and fit(path).returncode == 0


def cut_in_the_air(path):
    """The beginning of a session, until just before the plunger moves."""
    still = Recording("a", R.t, np.where(R.t < 5.0, -1.0e-3, R.depth), R.force, R.taxels)
    data = write_mcap(path, still).read_bytes()
    path.write_bytes(data[: len(data) // 5])
    return path


@pytest.mark.parametrize("more", [[], ["--each"], ["--what", "stiffness"]])
def test_what_fails_in_a_file_that_is_cut_off_says_so(fit, tmp_path, more):
    done = fit(cut_in_the_air(tmp_path / "a.mcap"), *more, "--out", tmp_path / "out")
    assert done.returncode == 2 and "a.mcap is cut off: the last" in done.stderr + done.stdout
    assert sum(line.startswith("error:") for line in done.stderr.splitlines()) == 1 and "a.mcap: a.mcap is" not in done.stderr + done.stdout


@pytest.mark.parametrize("off", [0.0, 5e-6])
def test_a_zero_of_the_depth_that_is_off_is_said(fit, tmp_path, off):
    done = fit(write_table(tmp_path / "a.csv", Recording("a", R.t, R.depth + off, R.force, R.taxels)))
    assert done.returncode == 0 and ("comes out at" in done.stdout) is (off > 0.0)
