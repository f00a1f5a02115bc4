"""A call of the demo that cannot be is refused in a sentence before anything is started or written."""

import pytest

pytest.importorskip("rclpy")
pytest.importorskip("skin_testbed_msgs")

from skin_ident.ros import demo, testbed
from skin_ident.ros.demo import _announced, answer, main, specimen_with_secret
from skin_testbed_driver.rigs.simulated import Imperfections


@pytest.mark.parametrize(
    ("arguments", "word"),
    [(["--seed", "-1"], "--seed is a whole number from 0 to 2147483547, not -1"), (["--seed", "3000000000"], "--seed is a whole number"),
     (["--effect", "witchcraft"], "choose from"), (["--out", ""], "--out needs a name")],
)  # fmt: skip
def test_a_bad_call(tmp_path, monkeypatch, capsys, arguments, word):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert word in said and said.count("\n") == 1 and not list(tmp_path.iterdir())


def test_a_folder_that_holds_something_is_refused_at_once_and_left_as_it_is(tmp_path, capsys):
    secret = tmp_path / "secret_specimen.yaml"
    secret.write_text("of an earlier demo")
    assert main(["--effect", "lag", "--out", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert "already holds secret_specimen.yaml" in said and said.count("\n") == 1
    assert secret.read_text() == "of an earlier demo" and list(tmp_path.iterdir()) == [secret]


@pytest.mark.parametrize(("cause", "word"), [(None, "hides something"), ("none", "hides nothing, as"), ("lag", "hides lag, as")])
def test_what_was_asked_for_is_no_secret(cause, word):
    assert word in _announced(cause)


def test_the_answer_says_how_large_both_are_where_they_are_the_same():
    hidden = specimen_with_secret(1, "lag")[1]
    found = {"cause": "lag", "where": "taxel", "parameters": {"tau": {"value": 0.052, "unit": "s", "std": 0.001}}, "alternatives": []}
    said = answer(hidden, {"findings": [found, found | {"where": "load_cell"}]}).replace("\u00a0", " ")
    assert "hidden: lag in the taxel (tau 50.0 ms)" in said
    assert said.endswith("found:  lag in the taxel (tau 52 ± 1 ms), lag in the load_cell")
    assert answer(None, {"findings": []}) == "\nhidden: nothing\nfound:  nothing"


def test_the_answer_claims_no_more_than_the_diagnosis_where_rivals_are_left():
    rivals = [{"cause": "drift", "where": "taxel"}, {"cause": "lag", "where": "load_cell"}]
    found = {"cause": "lag", "where": "taxel", "parameters": {}, "alternatives": rivals}
    said = answer(specimen_with_secret(1, "lag")[1], {"findings": [found]})
    assert said.endswith("found:  lag in the taxel or drift in the taxel or lag in the load_cell")


def test_a_zero_of_depth_that_is_found_beside_what_was_hidden_is_the_rigs_own():
    zero = {
        "cause": "position_offset",
        "where": "rig",
        "parameters": {"offset": {"value": 2.5e-6, "unit": "m", "std": 1e-7}},
        "alternatives": [],
    }
    screw = f"{1e6 * Imperfections().screw_error:g} µm"
    assert all(screw in answer(hidden, {"findings": [zero]}).splitlines()[-1] for hidden in (None, specimen_with_secret(1, "lag")[1]))
    assert screw not in answer(None, {"findings": []})


def test_of_a_session_that_is_stopped_nothing_is_kept_and_those_before_it_stay(tmp_path, monkeypatch):
    def stopped(*_):
        assert (tmp_path / "torn").is_dir()
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), testbed.Testbed(None, seed=1, time_scale=5.0) as running:
        whole = running.session(tmp_path / "whole", "{type: step, depth_mm: 0.2}")
        monkeypatch.setattr(running, "execute", stopped)
        running.session(tmp_path / "torn", "demo")
    assert list(tmp_path.iterdir()) == [whole]


@pytest.mark.parametrize("recorded", [False, True])
def test_a_demo_that_is_stopped_leaves_only_what_holds_a_recording(tmp_path, monkeypatch, capsys, recorded):
    def stopped(folder, seed, tell):
        if recorded:
            (folder / "session_1").mkdir()
        raise KeyboardInterrupt

    monkeypatch.setattr(demo, "record_sessions", stopped)
    assert main(["--effect", "lag", "--out", str(tmp_path / "out")]) == 130
    assert (tmp_path / "out").exists() is recorded and (tmp_path / "out" / "secret_specimen.yaml").exists() is recorded
