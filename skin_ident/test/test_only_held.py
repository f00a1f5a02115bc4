"""What only held-out sessions have is in doubt by its right name, and no course of theirs is named in its place."""

import pytest
from rows import rows
from world import make_sessions, write_case
from world.hidden import Hide

from skin_ident.criticism.diagnose import diagnose
from skin_ident.recordings.load import load

SESSIONS = 5
HIDDEN = [
    (Hide("lag", "taxel", "one_pole", 2.0), 60),
    (Hide("dead_zone", "taxel", "threshold", 2.0), 63),
    (Hide("stress_relaxation", "skin", "prony2", 2.0), 61),
    (Hide("friction", "rig", "coulomb", 2.0), 62),
    (Hide("rate_dependence", "skin", "thickening", 2.0), 64),
    (Hide("hysteresis", "skin", "preisach", 2.0), 65),
    (Hide("nonlinear_stiffness", "skin", "fung", 2.0), 66),
    (Hide("backlash", "rig", "play", 2.0), 67),
    (Hide("saturation", "taxel", "hard", 2.0), 68),
]


@pytest.mark.parametrize(("hide", "seed"), rows(HIDDEN, 0), ids=lambda h: getattr(h, "cause", ""))
@pytest.mark.parametrize(("having", "held"), [(3, 2), (4, 1)], ids=["one of two", "the only one"])
def test_what_one_held_out_session_has_is_in_doubt(tmp_path, hide, seed, having, held):
    how = {"seed": seed, "protocol": "full", "n_sessions": SESSIONS, "noise": "white"}
    plain, hidden = (make_sessions(hides, **how)[0] for hides in ([], [hide]))
    write_case([hidden[i] if i == having else plain[i] for i in range(SESSIONS)], tmp_path)
    every = load(tmp_path)
    findings = diagnose(every[:-held], every[-held:]).findings
    assert findings["findings"] == []
    doubted = [u for u in findings["untestable"] if "which is held out" in u["because"]]
    assert (hide.cause, hide.where) in {(u["cause"], u["where"]) for u in doubted}
    assert all(u["in_doubt"] and every[having].name in u["because"] for u in doubted)
