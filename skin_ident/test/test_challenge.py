"""`challenge` counts honestly, goes on where it stopped, and says what is wrong with a call in one sentence."""

import csv
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from skin_ident.cli.challenge import RESULTS, main
from skin_ident.hiding.campaign import NULL, Case, cases, keep, kept, key
from skin_ident.hiding.picture import save_confusion
from skin_ident.hiding.tally import confusion, extra, interval, rate, right, summary, write_tables


def entry(cause, named=(), alternatives=(), where="skin", size=1.0, seed=0, **more):
    return {
        "cause": cause, "size": size if cause != NULL else 0.0, "seed": seed, "protocol": "full", "taxels": 1, "where": where, "form": "",
        "imitated": False, "named": [list(n) for n in named], "alternatives": [list(a) for a in alternatives], "verdict": "explained",
        "over_oracle": 1.02, "seconds_per_session": 0.4, **more,
    }  # fmt: skip


LAG, FRICTION = ("lag", "taxel"), ("friction", "rig")
ENTRIES = [
    entry(NULL, seed=0), entry(NULL, [LAG], seed=1), entry("lag", [LAG], where="taxel"), entry("friction", [LAG], [FRICTION], where="rig"),
    entry("lag", [("lag", "load_cell")], where="taxel", seed=1), entry("gain_error", imitated=True), entry("backlash", [FRICTION, LAG]),
]  # fmt: skip


def test_clopper_pearson_as_in_the_tables():
    assert interval(0, 10) == pytest.approx((0.0, 0.3085), abs=1e-4)
    assert interval(5, 10) == pytest.approx((0.1871, 0.8129), abs=1e-4)
    assert interval(10, 10)[1] == 1.0 and rate(0, 0) == "none tried"


def test_what_is_right():
    assert [right(e) for e in ENTRIES] == [True, False, True, True, False, True, False]
    assert right(ENTRIES[4], place=False)
    assert [extra(e) for e in ENTRIES] == [[], ["lag"], [], [], [], [], ["friction", "lag"]]


def test_the_matrix_and_its_picture(tmp_path):
    causes, names, counts = confusion(ENTRIES)
    assert counts.sum() == len(ENTRIES) and causes[-1] == NULL and names[-1] == "nothing"
    assert counts[causes.index("lag"), names.index("lag")] == 2
    save_confusion(ENTRIES, tmp_path / "confusion.png")
    assert (tmp_path / "confusion.png").stat().st_size > 5000
    said = summary([*ENTRIES, {"cause": "lag", "skipped": "too large"}])
    assert "1 of 2, 50 %" in said and "skipped 1: too large" in said


def test_what_nobody_could_see_is_in_no_rate(tmp_path):
    """Nothing was named, and the model imitates what was hidden; a wrong name for it is wrong all the same."""
    missed, wrong = entry("gain_error", imitated=True, seed=1), entry("gain_error", [LAG], imitated=True, seed=2)
    said = summary([ENTRIES[2], ENTRIES[6], missed, wrong])
    assert "size 1: cause right 1 of 3, " in said and "size 1: cause and place right 1 of 3, " in said
    assert "imitates what was hidden, and nothing was named: 1" in said and "gain_error           nothing 1, lag 1" in said
    assert "neither" not in summary([ENTRIES[2], wrong]) and "cause right none tried" in summary([missed])
    write_tables([ENTRIES[2], missed], tmp_path)
    assert [r["right"] for r in csv.DictReader((tmp_path / "cases.csv").open())] == ["True", ""]


def test_cases_are_spread_over_causes_before_seeds():
    wanted = cases([NULL, "lag"], [0.5, 1.0], 3, "demo", 1)
    assert len(wanted) == 9 and {c.cause for c in wanted[:3]} == {NULL, "lag"} and wanted[0].size == 0.0


def test_a_line_cut_short_is_played_again(tmp_path):
    file = tmp_path / RESULTS
    file.write_text(json.dumps(ENTRIES[2]) + "\n" + json.dumps(ENTRIES[3])[:40])
    assert [key(e) for e in kept(file)] == [Case("lag", 1.0, 0)]


def test_what_follows_a_line_cut_short_is_kept(tmp_path):
    file = tmp_path / RESULTS
    file.write_text(json.dumps(ENTRIES[2]) + "\n" + json.dumps(ENTRIES[3])[:40])
    keep(ENTRIES[4], file), keep(ENTRIES[5], file)
    assert list(kept(file)) == [ENTRIES[2], ENTRIES[4], ENTRIES[5]] and file.read_text().count("\n") == 4


def test_lines_of_another_shape_are_left_out(tmp_path):
    file = tmp_path / RESULTS
    skipped, without = entry("lag") | {"skipped": "too large"}, {k: v for k, v in ENTRIES[3].items() if k != "named"}
    strange = [3, None, "lag", [1], {}, {"cause": "lag"}, entry(["lag"]), without]
    file.write_text("".join(json.dumps(e) + "\n" for e in (*strange, skipped, ENTRIES[2])))
    assert list(kept(file)) == [skipped, ENTRIES[2]]


def test_a_campaign_resumes_and_writes_its_tables(tmp_path, capsys):
    call = ["--causes", NULL, "force_offset", "--sizes", "2", "--seeds", "1", "--protocol", "demo", "--jobs", "1", "--out", str(tmp_path)]
    assert main(call) == 0
    first = (tmp_path / RESULTS).read_text()
    assert "failed" not in first and "force_offset" in capsys.readouterr().out
    assert main(call) == 0
    assert (tmp_path / RESULTS).read_text() == first and "2 of 2 cases are there already" in capsys.readouterr().err
    rows = list(csv.DictReader((tmp_path / "cases.csv").open()))
    assert {r["cause"] for r in rows} == {NULL, "force_offset"} and (tmp_path / "confusion.png").exists()
    ratios = [float(r["over_oracle"]) for r in rows]
    assert np.all(np.array(ratios) < 1.5) and (tmp_path / "confusion.csv").exists()


def test_all_cases_in_a_folder_are_counted_together(tmp_path, capsys):
    held = [entry("lag", [LAG], where="taxel", protocol="demo"), entry(NULL, protocol="demo")]
    (tmp_path / RESULTS).write_text("".join(json.dumps(e) + "\n" for e in held))
    call = ["--sizes", "1", "--seeds", "1", "--jobs", "1", "--out", str(tmp_path), "--causes", NULL]
    assert main([*call, "--protocol", "demo"]) == 0
    assert "2 cases, 1 of them from earlier calls" in capsys.readouterr().out
    assert {r["cause"] for r in csv.DictReader((tmp_path / "cases.csv").open())} == {NULL, "lag"}
    assert main([*call, "--protocol", "full"]) == 2 and main([*call, "--protocol", "demo", "--taxels", "2"]) == 2
    said = capsys.readouterr().err
    assert said.count("holds cases of the battery demo with 1 taxel") == 2 and len((tmp_path / RESULTS).read_text().splitlines()) == 2


@pytest.mark.parametrize(
    ("arguments", "word"),
    [(["--causes", "witchcraft"], "is no cause"), (["--causes", "frction"], "mean friction?"),
     (["--protocol", "array_walk"], "motions alone"), (["--seeds", "0"], "--seeds"),
     (["--causes", "spread_width"], "cannot be hidden here"), (["--sizes", "0"], "positive"), (["--sizes", "nan"], "positive"),
     (["--protocol", "x"], "no battery"), (["--causes", "lag", "lag"], "names lag twice"),
     (["--sizes", "1", "2", "1.0"], "names 1.0 twice")],
)  # fmt: skip
def test_a_bad_call(tmp_path, capsys, arguments, word):
    assert main([*arguments, "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert word in said and "Traceback" not in said and not (tmp_path / "out").exists()


def test_a_campaign_in_which_nothing_could_be_hidden_says_why(tmp_path, capsys):
    call = ["--causes", "lag", "--sizes", "1e300", "--seeds", "1", "--protocol", "demo", "--jobs", "1", "--out", str(tmp_path)]
    assert main(call) == 2
    assert "none of the 1 cases could be played, the first because" in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == [RESULTS]


def test_causes_may_have_commas_between(tmp_path, capsys):
    assert main(["--causes", "lag,backlash", "witchcraft", "--out", str(tmp_path / "out")]) == 2
    assert "'witchcraft' is no cause" in capsys.readouterr().err


def test_an_interruption_before_the_first_result_is_one_line_and_leaves_nothing(tmp_path):
    # tests that run in the background have Ctrl-C switched off, and so have their children
    listening = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    program = f"{listening}; from skin_ident.cli.challenge import main\nif __name__ == '__main__':\n    exit(main())\n"
    (tmp_path / "challenge.py").write_text(program)
    command = [sys.executable, tmp_path / "challenge.py", "--causes", "lag", "--sizes", "1", "--seeds", "3", "--out", tmp_path / "out"]
    campaign = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True)
    until = time.monotonic() + 60.0
    while not (tmp_path / "out").exists() and time.monotonic() < until:
        time.sleep(0.05)
    time.sleep(1.0)  # the workers are importing
    os.killpg(campaign.pid, signal.SIGINT)  # as a terminal does: to all of them
    said = campaign.communicate(timeout=60)[1]
    assert (campaign.returncode, said) == (130, "interrupted; nothing was written\n") and not (tmp_path / "out").exists()
