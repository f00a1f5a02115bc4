"""`diagnose` as a user meets it: what cannot be right is asked about in one sentence, and who interrupts it finds nothing left behind."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from making import recording, write_bag, write_table

from skin_ident.cli import diagnose
from skin_ident.criticism.telling.outcome import Outcome
from skin_models.materials import material
from skin_models.model_file import save_model

R = recording(n=1500, shares=(1.0, 0.4))
SCAN = "depth_mm,a_n,b_mm\n0.1,0.6,12\n0.2,1.5,12\n"


@pytest.fixture
def command(capsys, tmp_path):
    """Run the command into tmp_path/out; status and what it said."""

    def run(*arguments, out=tmp_path / "out"):
        status = diagnose.main([*(str(a) for a in arguments), "--out", str(out)])
        return SimpleNamespace(status=status, said=capsys.readouterr().err.splitlines()[-1])

    return run


def written(path, content):
    path.write_bytes(content)
    return path


BAD = {
    "milliseconds as seconds": (lambda d: [write_table(d / "a.csv", replace(R, t=1e3 * R.t))], "is the time in milliseconds?"),
    "metres as millimetres": (lambda d: [write_table(d / "a.csv", replace(R, depth=1e-3 * R.depth))], "check the units of depth and force"),
    "newtons as millinewtons": (lambda d: [write_table(d / "a.csv", replace(R, force=1e-3 * R.force))], "is the force in N, not in mN?"),
    "a role that nothing has": (lambda d: [write_table(d / "a.csv", R), "--topics", "foo=/bar"], "not 'foo'"),
    "the same of a bag": (lambda d: [write_bag(d / "a", R), "--topics", "foo=/bar"], "not 'foo'"),
    "zeros as a bag": (lambda d: [written(d / "a.mcap", b"\x89MCAP0\r\n" + bytes(5000))], "a.mcap is damaged"),
    "a table of something else": (lambda d: [written(d / "a.csv", SCAN.encode())], "static spread scan"),
    "a file as folder": (lambda d: [write_table(d / "a.csv", R), "--model", written(d / "m.yaml", b"k1: 3\n")], "does not say schema: 1"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_right_is_one_sentence(command, tmp_path, case):
    arguments, sentence = BAD[case]
    done = command(*arguments(tmp_path))
    assert done.status == 2 and done.said.startswith("error: ") and sentence in done.said
    assert not (tmp_path / "out").exists()


def test_a_misread_header_is_told_of_scans_only_where_it_may_be_one(command, tmp_path):
    lost = written(tmp_path / "a.csv", b"t_s,depth_mm,b_mm\n0,1,2\n1,1,2\n")
    assert "scan" not in command(lost).said and "'b_mm' is not known" in command(lost).said


@pytest.mark.parametrize("where", ["diagnose", "write"])
def test_an_interrupted_diagnosis_leaves_nothing(command, tmp_path, monkeypatch, where):
    """Neither before the answer is there nor while it is written; folders that were there before stay, with what is in them."""

    def interrupted(*given):
        if where == "write":
            (given[1] / "report.html").write_text("half of it")
        raise KeyboardInterrupt

    monkeypatch.setattr(diagnose, "diagnose", lambda *given: SimpleNamespace(findings={}))
    monkeypatch.setattr(diagnose, where, interrupted)
    table, own = write_table(tmp_path / "a.csv", R), tmp_path / "own"
    own.mkdir()
    done = command(table, out=own / "deeper" / "still")
    assert done.status == 130 and done.said.endswith("interrupted; nothing was written") and list(own.iterdir()) == []
    (own / "kept.txt").write_text("mine")
    assert command(table, out=own).status == 130 and (own / "kept.txt").read_text() == "mine"


def test_a_model_of_another_kind_of_skin_is_no_wrong_unit(command, tmp_path, monkeypatch):
    """Who gives a model as stiff as that knows more than the usual bounds."""
    skin = material("silicone_4mm").model
    stiff = replace(skin, dispersion=replace(skin.dispersion, k1=1e3 * skin.dispersion.k1), shares=(1.0, 0.4))
    save_model(stiff, tmp_path / "stiff.yaml")
    table = write_table(tmp_path / "a.csv", replace(R, force=1e3 * R.force, taxels=1e3 * R.taxels, name="a"))
    assert "check the units" in command(table).said

    def far_enough(*given):
        raise KeyboardInterrupt

    monkeypatch.setattr("skin_ident.criticism.diagnose.layout_of", far_enough)
    assert command(table, "--model", tmp_path / "stiff.yaml").status == 130


FINDINGS = {"schema": 1, "verdict": "nothing_wrong", "recordings": [], "findings": []}
OURS = ("baseline.yaml", "model.yaml", "separating.yaml", "separating_2.yaml", "separating_10.yaml")
THEIRS = ("separating_notes.yaml", "separating_2_old.yaml", "my_model.yaml", "rig.yaml")


def answered(folder, **outcome):
    """What lies in a folder of an earlier answer, beside files of somebody's own, after another one."""
    folder.mkdir()
    diagnose.write(Outcome(FINDINGS), folder)
    for name in (*OURS, *THEIRS):
        (folder / name).write_text("earlier")
    diagnose.write(Outcome(FINDINGS, **outcome), folder)
    return {p.name: p.read_text() for p in folder.glob("*.yaml")}


def test_nothing_of_an_earlier_answer_stays_beside_another(tmp_path):
    theirs = dict.fromkeys(THEIRS, "earlier")
    assert answered(tmp_path / "without_model") == theirs
    skin = material("silicone_4mm").model
    left = answered(tmp_path / "with_model", baseline=skin, model=skin, batteries={"separating.yaml": "new"})
    assert {*left} == {*THEIRS, "baseline.yaml", "model.yaml", "separating.yaml"} and left["separating.yaml"] == "new"
    assert theirs.items() <= left.items() and "earlier" not in (left["model.yaml"], left["baseline.yaml"])


@pytest.mark.parametrize("failing", ["write_report", "save_traces", "save_model"])
@pytest.mark.parametrize("failure", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_an_answer_that_cannot_be_written_leaves_the_earlier_one_whole(tmp_path, monkeypatch, failing, failure):
    def broken(*given):
        raise failure

    skin = material("silicone_4mm").model
    diagnose.write(Outcome(FINDINGS, baseline=skin, model=skin, batteries={"separating.yaml": "earlier"}), tmp_path)
    earlier = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    monkeypatch.setattr(diagnose, failing, broken)
    with pytest.raises(type(failure)):
        diagnose.write(Outcome({**FINDINGS, "verdict": "unexplained"}, baseline=skin, model=skin), tmp_path)
    assert len(earlier) > 5 and {p.name: p.read_bytes() for p in tmp_path.iterdir()} == earlier


def test_an_answer_that_is_stopped_while_it_is_put_in_place_is_none(tmp_path, monkeypatch):
    diagnose.write(Outcome(FINDINGS), tmp_path)
    move, moved = Path.replace, []

    def stopped(file, target):
        if target.parent == tmp_path:
            moved.append(target.name)
        if len(moved) == 2:
            raise KeyboardInterrupt
        return move(file, target)

    monkeypatch.setattr(Path, "replace", stopped)
    with pytest.raises(KeyboardInterrupt):
        diagnose.write(Outcome(FINDINGS), tmp_path)
    assert not (tmp_path / "findings.json").exists() and not [p for p in tmp_path.iterdir() if p.is_dir()]


def test_a_model_in_a_folder_without_an_answer_is_somebodys_own(tmp_path):
    (tmp_path / "model.yaml").write_text("mine")
    diagnose.write(Outcome(FINDINGS), tmp_path)
    assert (tmp_path / "model.yaml").read_text() == "mine"


@pytest.mark.parametrize("name", ["model.yaml", "baseline.yaml", "report.html"])
def test_it_is_not_written_over(command, tmp_path, name):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / name).write_text("mine")
    done = command(write_table(tmp_path / "session_1.csv", R), out=tmp_path / "mine")
    assert done.status == 2 and f"holds {name}, which no diagnosis wrote" in done.said
    assert [p.read_text() for p in (tmp_path / "mine").iterdir()] == ["mine"]


def test_an_answer_in_a_recording_is_refused(command, tmp_path):
    write_bag(tmp_path / "in" / "a", R)
    had = sorted(tmp_path.rglob("*"))
    done = command(tmp_path / "in", out=tmp_path / "in" / "a")
    assert done.status == 2 and "is a recording" in done.said and sorted(tmp_path.rglob("*")) == had


def test_a_copy_that_is_held_out_is_told_from_its_twin_by_its_path(command, tmp_path):
    for name in "ab":
        (tmp_path / name).mkdir()
    one, other = (write_table(tmp_path / name / "session_1.csv", R) for name in "ab")
    done = command(one, "--hold-out", other)
    assert done.status == 2 and f"{other}, which is held out, holds the same samples as {one}, which is fitted" in done.said


def test_what_is_held_out_of_the_fitted_is_said_before_the_work(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr(diagnose, "_loaded", lambda *_: 1 / 0)
    files = [str(write_table(tmp_path / f"{name}.csv", R)) for name in "ab"]
    with pytest.raises(ZeroDivisionError):
        diagnose.main([*files, "--hold-out", files[1], "--out", str(tmp_path / "out")])
    assert f"{files[1]}: it was given to fit, too: it is held out, and not fitted" in capsys.readouterr().err


def test_on_a_terminal_no_progress_stays_in_front_of_what_is_said(tmp_path, monkeypatch, capsys):
    places = range(0, 14, 2)  # mm
    rows = [[z, *(9.0 * z * np.exp(-((r / 5.2) ** 2)) for r in places)] for z in (0.2, 0.5, 1.0)]
    head = ",".join(["depth_mm", *(f"f_{r}mm_n" for r in places)])
    (tmp_path / "scan.csv").write_text("\n".join([head, *(",".join(f"{x:.2f}" for x in row) for row in rows)]) + "\n")
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    for name, status in (("scan.csv", 0), ("nowhere.csv", 2)):
        assert diagnose.main([str(tmp_path / name), "--out", str(tmp_path / "out")]) == status
        _, clear, after = capsys.readouterr().err.rpartition("\r\033[K")
        assert clear and after.startswith("error: " if status else "") and "[" not in after
