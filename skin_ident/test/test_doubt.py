"""What training speaks for and other data leave in doubt is said: it is no finding, and it is not called excluded."""

import pytest
from rows import rows
from world import make_sessions, write_case
from world.hidden import Hide

from skin_ident.criticism.diagnose import diagnose
from skin_ident.recordings.load import load

CASES = [
    (Hide("saturation", "taxel_0", None, 0.5), 37713738, 3, "saturation", "what is held out"),  # a ceiling that few held-out samples reach
    (Hide("drift", "taxel_0", None, 0.5), 1589392155, 1, "drift", "noise that wanders"),  # a random walk, and noise of its kind
]


@pytest.mark.parametrize(("hide", "seed", "taxels", "cause", "words"), rows(CASES, 1), ids=[c[3] for c in CASES])
def test_doubt_is_said_and_excludes_nothing_there(tmp_path, hide, seed, taxels, cause, words):
    sessions, truth = make_sessions([hide], seed=seed, n_taxels=taxels, protocol="full", encoder_step_um=1.0)
    write_case(sessions, tmp_path)
    recordings = load(tmp_path)
    findings = diagnose(recordings[:2], recordings[2:]).findings
    where = "taxel" if taxels == 1 else truth.hidden[0].where
    assert findings["findings"] == [] and findings["verdict"] == "nothing_wrong"
    assert [words in u["because"] for u in findings["untestable"] if (u["cause"], u.get("where")) == (cause, where)] == [True]
    assert (cause, where) not in {(e["cause"], e.get("where")) for e in findings["excluded"]}


@pytest.mark.slow
def test_what_may_be_the_imperfect_form_of_a_larger_cause_is_in_doubt(tmp_path):
    """A loop of a taxel as large as the noise, under relaxation of eight times that: in no form is that quite the skin's."""
    hidden = [Hide("stress_relaxation", "skin", None, 8.0), Hide("hysteresis", "taxel_0", None, 1.0)]
    write_case(make_sessions(hidden, seed=2, protocol="full")[0], tmp_path)
    recordings = load(tmp_path)
    findings = diagnose(recordings[:2], recordings[2:]).findings
    assert [(f["cause"], f["where"]) for f in findings["findings"]] == [("stress_relaxation", "skin")]
    doubts = [u for u in findings["untestable"] if u.get("in_doubt")]
    assert [(u["cause"], u["where"]) for u in doubts] == [("hysteresis", "taxel")] and "imperfect form" in doubts[0]["because"]
