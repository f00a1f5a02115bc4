"""Experiment and criticism by turns: one name is left in the end, and the rig's time is counted."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from skin_ident.cli.identify import _account, main
from skin_ident.separating import loop

TRIANGLES = (
    "{type: battery, profiles: [{type: free_air, duration_s: 1}, "
    "{type: constant_rate_loops, depths_mm: 1, speeds_mm_s: 1, cycles: 5}, {type: free_air, duration_s: 1}]}"
)


def test_goes_on_until_one_name_is_left(tmp_path, capsys):
    call = ["--until-named", "--cause", "hysteresis", "--seed", "2", "--first", TRIANGLES, "--fixed", "demo", "--out", str(tmp_path)]
    assert main(call) == 0
    said = capsys.readouterr().out
    told = json.loads((tmp_path / "experiments.json").read_text())
    assert "the fixed battery demo" in said and told["course"][0]["battery"] == TRIANGLES
    assert all(len(names) == 1 for names in told["course"][-1]["left"])
    for name in ("findings.json", "model.yaml", "report.html", "specimen.yaml", "recordings/session_1.csv"):
        assert (tmp_path / name).exists(), name


def test_no_battery_is_recorded_twice_and_the_rich_one_stands_in(monkeypatch):
    finding = {"cause": "lag", "where": "skin", "alternatives": [{"cause": "drift", "where": "skin"}]}
    same = SimpleNamespace(findings={"findings": [finding], "verdict": "explained"}, batteries={"separating.yaml": "again"})
    monkeypatch.setattr(loop, "diagnose", lambda *arguments: same)
    course = loop.until_named(lambda battery, name: SimpleNamespace(t=np.arange(3.0)), "first", "rich", 100.0)
    assert [s.battery for s in course.steps] == ["first", "again", "rich"] and course.seconds == 12.0


@pytest.mark.parametrize(("seconds", "longer"), [(174.0, True), (40.0, False)])
def test_a_loop_that_took_longer_than_the_fixed_battery_says_so(seconds, longer):
    course, fixed = (loop.Course((loop.Step("b", s, (("lag",),), "explained"),), None, ()) for s in (seconds, 150.0))
    assert ("24 s more than the fixed battery" in _account(course, fixed, "full")) is longer


def test_bad_calls(tmp_path, capsys):
    for arguments, word in (
        (["--budget", "0"], "--budget"),
        (["--budget", "nan"], "--budget"),
        (["--seed", "-1"], "--seed"),
        (["--cause", "witchcraft"], "choose from"),
        (["--first", "x"], "no YAML file"),
    ):
        assert main([*arguments, "--out", str(tmp_path / "out")]) == 2
        assert word in capsys.readouterr().err and not (tmp_path / "out").exists()
