"""What all fitted sessions have and held-out ones lack: a filter that was taken out, a screw that was tightened on the last day."""

import pytest
from rows import rows
from world import make_sessions, write_case
from world.hidden import Hide

from skin_ident.criticism.diagnose import diagnose
from skin_ident.recordings.load import load

HIDDEN = [
    (Hide("lag", "taxel", "one_pole", 2.0), 30),
    (Hide("stress_relaxation", "skin", "prony2", 2.0), 31),
    (Hide("friction", "rig", "coulomb", 2.0), 32),
    (Hide("dead_zone", "taxel", "threshold", 2.0), 33),
]


def diagnosed(folder, hide, seed, having, held, count):
    """Findings for `count` sessions of one rig, of which the first `having` hide something and the last `held` are held out."""
    how = {"seed": seed, "protocol": "full", "n_sessions": count, "noise": "white"}
    plain, hidden = (make_sessions(hides, **how)[0] for hides in ([], [hide]))
    write_case([*hidden[:having], *plain[having:]], folder)
    every = load(folder)
    return diagnose(every[:-held], every[-held:]).findings, [r.name for r in every]


@pytest.mark.parametrize(("hide", "seed"), rows(HIDDEN, 1), ids=lambda h: getattr(h, "cause", ""))
@pytest.mark.parametrize(
    ("having", "held", "count"),
    rows([(2, 2, 4), (3, 2, 4), (5, 1, 6)], 0),
    ids=["no held-out session has it", "one of two has it", "only the last day lacks it"],
)
def test_what_held_out_sessions_lack_is_named_with_those_that_have_it(tmp_path, hide, seed, having, held, count):
    findings, names = diagnosed(tmp_path, hide, seed, having, held, count)
    (found,) = findings["findings"]
    assert (found["cause"], found["where"], findings["verdict"]) == (hide.cause, hide.where, "explained")
    assert (found["evidence"]["only_in"], found["evidence"]["not_in"]) == (names[:having], names[having:])


@pytest.mark.slow
def test_what_only_fitted_sessions_support_is_in_doubt(tmp_path):
    """So little play changes next to nothing of the plain model, so that a session without it cannot confirm it."""
    findings, _ = diagnosed(tmp_path, Hide("backlash", "rig", "play", 0.5), 40, 2, 1, 3)
    assert findings["findings"] == []
    (doubt,) = [u for u in findings["untestable"] if "predict each other" in u["because"]]
    assert (doubt["cause"], doubt["where"]) == ("backlash", "rig")


MOVED = [("stress_relaxation", "power_law", "single_rate_triangles", 1.0), ("lag", "two_pole", "single_sine", 1.0),
         ("stress_relaxation", "power_law", "single_sine", 3.0), ("lag", "two_pole", "single_rate_triangles", 1.0),
         ("lag", "two_pole", "single_sine", 3.0), ("lag", "two_pole", "single_rate_triangles", 3.0)]  # fmt: skip


@pytest.mark.parametrize(("cause", "form", "protocol", "size"), rows(MOVED, 0))
def test_what_an_imperfect_form_does_not_predict_of_other_motions_is_not_absent_there(tmp_path, cause, form, protocol, size):
    hide, seed = Hide(cause, {"lag": "taxel"}.get(cause, "skin"), form, size), {"lag": 506}.get(cause, 501)
    same = {"seed": seed, "n_sessions": 3, "noise": "white"}
    poor, full = (make_sessions([hide], protocol=name, **same)[0] for name in (protocol, "full"))
    write_case([*poor[:2], full[2]], tmp_path)
    every = load(tmp_path)
    found = diagnose(every[:2], every[2:]).findings["findings"]
    assert not any("not_in" in f["evidence"] for f in found), found
