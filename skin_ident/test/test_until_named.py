"""Experiment and criticism by turns: one name is left in the end, and the rig's time is counted."""

import json
from itertools import chain, count, repeat
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from skin_ident.cli.identify import _account, _truth, main
from skin_ident.separating import loop
from skin_ident.separating.candidates import random_motion, redrawn
from skin_ident.separating.path import planned
from skin_models.catalogue import effect_class
from skin_models.materials import material
from skin_motion_profiles.profile_file import entry_from_text, entry_from_words

TRIANGLES = (
    "{type: battery, profiles: [{type: free_air, duration_s: 1}, "
    "{type: constant_rate_loops, depths_mm: 1, speeds_mm_s: 1, cycles: 5}, {type: free_air, duration_s: 1}]}"
)


def test_goes_on_until_one_name_is_left(tmp_path, capsys):
    call = ["--until-named", "--cause", "hysteresis", "--seed", "2", "--first", TRIANGLES, "--fixed", "demo", "--out", str(tmp_path)]
    assert main(call) == 0
    said = capsys.readouterr().out
    told = json.loads((tmp_path / "experiments.json").read_text())
    assert "hidden in the specimen: hysteresis in the taxel (" in said and "; it was named\n" in said
    assert "the fixed battery demo" in said and told["course"][0]["battery"] == TRIANGLES
    assert all(len(names) == 1 for names in told["course"][-1]["left"])
    for name in ("findings.json", "model.yaml", "report.html", "specimen.yaml", "recordings/session_1.csv"):
        assert (tmp_path / name).exists(), name


LAG, DRIFT, GAIN = ({"cause": cause, "where": "taxel", "alternatives": []} for cause in ("lag", "drift", "gain_error"))
RANDOM = random_motion(1e-3)


def outcome(*findings, verdict="explained", battery=""):
    proposed = {"separating.yaml": battery} if battery else {}
    return SimpleNamespace(findings={"findings": list(findings), "verdict": verdict}, batteries=proposed)


def course(monkeypatch, *outcomes, first="first"):
    """The loop on criticisms that come out like this, one after the other, the last again and again."""
    each = chain(outcomes, repeat(outcomes[-1]))
    monkeypatch.setattr(loop, "diagnose", lambda *arguments: next(each))
    monkeypatch.setattr(loop, "redrawn", lambda battery: battery)  # these batteries are words that stand for any
    deeper = count()

    def record(battery, name):
        """An encoder whose zero creeps."""
        return SimpleNamespace(t=np.arange(3.0), depth=np.array([0.0, 1e-3 + 1e-5 * next(deeper)]))

    return loop.until_named(record, first, "rich", 100.0)


def batteries(of):
    return [s.battery for s in of.steps]


def test_no_battery_is_recorded_twice(monkeypatch):
    of = course(monkeypatch, outcome(LAG | {"alternatives": [DRIFT]}, battery="again"))
    assert batteries(of) == ["first", "again"] and of.seconds == 8.0


def test_a_name_that_one_battery_leaves_is_held_against_random_motion(monkeypatch):
    assert batteries(course(monkeypatch, outcome(LAG))) == ["first", RANDOM]
    assert batteries(course(monkeypatch, outcome(LAG), first="rich")) == ["rich"]
    lost = course(monkeypatch, outcome(LAG), outcome(verdict="nothing_wrong"))
    assert batteries(lost) == ["first", RANDOM, "rich"]


def test_a_name_that_a_separating_battery_brings_is_held_against_random_motion_and_one_that_it_leaves_is_not(monkeypatch):
    both = outcome(LAG | {"alternatives": [DRIFT]}, battery="apart")
    assert batteries(course(monkeypatch, both, outcome(DRIFT))) == ["first", "apart"]
    assert batteries(course(monkeypatch, both, outcome(DRIFT, GAIN))) == ["first", "apart", RANDOM]


def test_random_motion_is_recorded_once_though_the_depth_is_read_anew(monkeypatch):
    assert batteries(course(monkeypatch, outcome(LAG), outcome(LAG, GAIN), outcome(LAG, GAIN, DRIFT))) == ["first", RANDOM]


def test_rivals_that_no_motion_separates_are_seen_under_one_other_motion_alone(monkeypatch):
    assert batteries(course(monkeypatch, outcome(LAG | {"alternatives": [DRIFT]}))) == ["first", RANDOM]


@pytest.mark.parametrize("verdict", ["nothing_wrong", "unexplained", "partly_explained"])
def test_what_has_no_name_is_shown_the_rich_battery_once(monkeypatch, verdict):
    of = course(monkeypatch, outcome(*([LAG] if verdict == "partly_explained" else []), verdict=verdict))
    assert batteries(of) == ["first", "rich"]


def test_random_motion_is_a_battery_that_the_server_reads():
    motion, kinds = planned(entry_from_text(RANDOM), 0.01), ["free_air", "constant_rate_loops", "multisine", "random_ramps", "free_air"]
    assert 20.0 < motion.t[-1] < 40.0 and 0.95e-3 < motion.x.max() < 1.001e-3
    assert [p["type"] for p in yaml.safe_load(RANDOM)["profiles"]] == kinds


@pytest.mark.parametrize("battery", ["full", RANDOM])
def test_what_shall_be_predicted_is_another_draw_of_the_same_motions(battery):
    first, again = (planned(entry_from_words(b), 0.01) for b in (battery, redrawn(battery)))
    apart = np.diff([m.x[: min(first.x.size, again.x.size)] for m in (first, again)], axis=0)
    assert abs(first.x.size / again.x.size - 1.0) < 0.2 and np.sqrt(np.mean(apart**2)) > 0.05 * first.x.max()
    assert redrawn(redrawn(battery)) != redrawn(battery) and redrawn(TRIANGLES) == TRIANGLES


@pytest.mark.parametrize(
    ("left", "said"),
    [((("lag in the taxel",),), "it was named"), ((("drift in the taxel", "lag in the taxel"),), "it is among the names that are left"),
     ((("lag in the load_cell",),), "it was not named"), ((), "it was not named")],
)  # fmt: skip
def test_what_was_hidden_is_said_last(left, said):
    of = loop.Course((loop.Step("b", 9.0, left, "explained"),), None, ())
    plain = material("silicone_4mm").model
    hidden = plain.extended(effect_class("lag", "taxel").typical("taxel"))
    assert _truth(hidden, of).startswith("hidden in the specimen: lag in the taxel (tau") and _truth(hidden, of).endswith(said)
    assert _truth(plain, of).removeprefix("hidden in the specimen: nothing; ") == (
        "something was named all the same" if left else "nothing was named"
    )
    assert f"9 s of recording, named: {of.steps[-1].words}" in _account(of, of, "full")


@pytest.mark.parametrize(("seconds", "longer"), [(174.0, True), (40.0, False)])
def test_a_loop_that_took_longer_than_the_fixed_battery_says_so(seconds, longer):
    of, fixed = (loop.Course((loop.Step("b", s, (("lag",),), "explained"),), None, ()) for s in (seconds, 150.0))
    assert ("24 s more than the fixed battery" in _account(of, fixed, "full")) is longer


def test_bad_calls(tmp_path, capsys):
    for arguments, word in (
        (["--budget", "0"], "--budget"),
        (["--budget", "nan"], "--budget"),
        (["--seed", "-1"], "--seed"),
        (["--cause", "witchcraft"], ", none, "),
        (["--first", "x"], "no YAML file"),
    ):
        assert main([*arguments, "--out", str(tmp_path / "out")]) == 2
        assert word in capsys.readouterr().err and not (tmp_path / "out").exists()
