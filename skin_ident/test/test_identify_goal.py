"""One goal of the action `identify`, run without a node: it ends with a code that says what happened, and reads as `diagnose` does."""

import json

import pytest
from making import recording, write_table

pytest.importorskip("rclpy")
pytest.importorskip("skin_testbed_msgs")

from skin_testbed_msgs.action import Identify

from skin_ident.cli import diagnose
from skin_ident.ros import identify

Result = Identify.Result


def result_of(**goal):
    return identify.Run(Identify.Goal(**goal), lambda: False, lambda feedback: None).result()


@pytest.mark.parametrize("where", ["load_one", "fit_recordings", "save_model"])
def test_what_nobody_foresaw_is_no_success(tmp_path, monkeypatch, where):
    def broken(*given):
        raise ZeroDivisionError("float division\nby zero")

    logged = []
    monkeypatch.setattr(identify, where, broken)
    monkeypatch.setattr(identify, "get_logger", raising=False, value=lambda name: type("Logger", (), {"error": logged.append}))
    result = result_of(recordings=[str(write_table(tmp_path / "a.csv", recording(n=500)))], output_directory=str(tmp_path / "out"))
    assert result.error_code == Result.FAILED != Result.SUCCESS
    assert "ZeroDivisionError: float division by zero" in result.error_string
    assert len(logged) == 1 and "in broken" in logged[0]


def test_recordings_are_held_out_as_the_command_line_does(tmp_path):
    """A folder with the held-out file in it, and one file named twice."""
    for i, name in enumerate("abc"):
        write_table(tmp_path / f"{name}.csv", recording(i, n=1500, offset=0.2e-3))
    given, held, out = [str(tmp_path), str(tmp_path / "a.csv")], [str(tmp_path / "c.csv")], [tmp_path / "action", tmp_path / "command"]
    result = result_of(recordings=given, hold_out=held, criticise=True, output_directory=str(out[0]))
    assert result.error_code == Result.SUCCESS, result.error_string
    assert diagnose.main([*given, "--hold-out", *held, "--out", str(out[1])]) == 0
    first, second = (json.loads((folder / "findings.json").read_text())["recordings"] for folder in out)
    assert first == second and [(r["name"], r["held_out"]) for r in first] == [("a.csv", False), ("b.csv", False), ("c.csv", True)]


def test_nothing_is_left_to_fit(tmp_path):
    table = str(write_table(tmp_path / "a.csv", recording(n=500)))
    result = result_of(recordings=[table], hold_out=[table], criticise=True)
    assert result.error_code == Result.UNUSABLE_INPUT and "none is left to fit" in result.error_string


@pytest.mark.parametrize("criticise", [False, True])
def test_a_goal_that_is_cancelled_once_its_answer_is_written_has_succeeded(tmp_path, criticise):
    table, out = str(write_table(tmp_path / "a.csv", recording(n=1500))), tmp_path / "out"
    goal = Identify.Goal(recordings=[table], output_directory=str(out), criticise=criticise)
    told = []
    result = identify.Run(goal, out.exists, lambda feedback: told.append((feedback.stage, feedback.progress))).result()
    assert result.error_code == Result.SUCCESS and (out / "model.yaml").exists() and told[-1] == ("done", 1.0)
