"""A month of sessions: what some of them have is named with these, and skin that differs from day to day is none of it."""

from dataclasses import replace

import numpy as np
import pytest
from gate_records import PLAIN, recorded
from rows import rows
from world import make_sessions, without, write_case
from world.hidden import Hide

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.search import own_skin, partly
from skin_ident.criticism.sessions.session import prepare
from skin_ident.recordings.load import load

SESSIONS, HELD = 5, 4
SINCE = [
    (Hide("lag", "taxel", "one_pole", 2.0), {2, 3, 4}, 3),
    (Hide("stress_relaxation", "skin", "prony2", 2.0), {2, 3, 4}, 4),
    (Hide("friction", "rig", "coulomb", 2.0), {0, 1}, 5),
    (Hide("dead_zone", "taxel", "threshold", 2.0), {1, 2, 3}, 6),
]


def month(folder, hide, having, seed, **how):
    """Recordings of one rig over days, in which the sessions `having` hide something."""
    how = {"seed": seed, "protocol": "full", "n_sessions": SESSIONS, "noise": "white"} | how
    plain, hidden = make_sessions([], **how)[0], make_sessions([hide], **how)[0]
    write_case([hidden[i] if i in having else plain[i] for i in range(SESSIONS)], folder)
    every = load(folder)
    return [r for i, r in enumerate(every) if i != HELD], [every[HELD]]


@pytest.mark.parametrize(("hide", "having", "seed"), rows(SINCE, 0), ids=lambda h: getattr(h, "cause", ""))
def test_what_some_sessions_have_is_named_with_them(tmp_path, hide, having, seed):
    train, held = month(tmp_path, hide, having, seed)
    findings = diagnose(train, held).findings
    (found,) = findings["findings"]
    assert (found["cause"], findings["verdict"]) == (hide.cause, "explained")
    names = [r.name for r in (*train, *held)]
    assert set(found["evidence"]["only_in"]) == {names[i] for i in having}
    assert set(found["evidence"]["not_in"]) == {names[i] for i in range(SESSIONS) if i not in having}


@pytest.mark.parametrize("seed", rows([5, 6, 8, 9], 0))
def test_skin_that_is_a_hundredth_stiffer_or_softer_every_day_is_no_finding(tmp_path, seed):
    sessions, _ = make_sessions([], seed=seed, protocol="full", between=0.01)
    write_case(sessions, tmp_path)
    every = load(tmp_path)
    findings = diagnose(every[:2], every[2:]).findings
    assert findings["findings"] == [] and findings["verdict"] == "nothing_wrong", findings["findings"]


@pytest.mark.parametrize("seed", rows([5, 6, 7, 8], 1))
@pytest.mark.parametrize("fitted_alike", rows([True, False], 1), ids=["the one that is held out", "every session"])
def test_skin_of_another_specimen_is_named_with_its_numbers(tmp_path, seed, fitted_alike):
    specimens, alike = (make_sessions([], seed=seed, protocol="full", noise="white", between=b)[0] for b in (0.15, 0.0))
    write_case([*(alike if fitted_alike else specimens)[:2], specimens[2]], tmp_path)
    every = load(tmp_path)
    findings = diagnose(every[:2], every[2:]).findings
    assert [(f["cause"], f["where"]) for f in findings["findings"]] == [("parameters", "skin")] and findings["verdict"] == "explained"


@pytest.mark.parametrize("seed", rows([20, 15, 16], 0))
def test_nor_is_it_a_gain_or_a_zero_of_depth_where_no_taxel_tells(tmp_path, seed):
    sessions, _ = make_sessions([], seed=seed, protocol="full", between=0.01, n_sessions=6)
    write_case([without(s, "taxels") for s in sessions], tmp_path)
    every = load(tmp_path)
    findings = diagnose(every[:5], every[5:]).findings
    assert findings["findings"] == [] and findings["verdict"] == "nothing_wrong", findings["findings"]
    by_hardware = {u["cause"] for u in findings["untestable"] if u.get("hardware")}
    assert by_hardware and by_hardware <= {"gain_error", "position_offset", "parameters"}


@pytest.mark.parametrize("seed", rows([43, 41, 42], 0))
def test_a_gain_that_may_as_well_be_skin_is_not_ruled_out(tmp_path, seed):
    sessions, _ = make_sessions([], seed=seed, protocol="full", noise="white", between=0.01, n_sessions=6)
    weaker = [replace(s, taxels=0.975 * s.taxels) for s in sessions[3:]]
    write_case([*sessions[:3], *weaker], tmp_path)
    every = load(tmp_path)
    findings = diagnose(every[:5], every[5:]).findings
    bounds = {e["where"]: e["below"] for e in findings["excluded"] if e["cause"] == "gain_error"}
    noted = {u["where"] for u in findings["untestable"] if u["cause"] == "gain_error" and u.get("hardware")}
    named = {f["where"] for f in findings["findings"] if f["cause"] == "gain_error"}
    assert "taxel" in named | noted or bounds["taxel"] > 0.025, (bounds, findings["untestable"])


@pytest.mark.slow
def test_what_zeros_do_in_its_place_is_no_finding_and_the_search_goes_on(tmp_path, monkeypatch):
    monkeypatch.setattr(partly, "take_tare", lambda search, finding: finding not in search.yielded and not search.yielded.append(finding))
    train, held = month(tmp_path, *SINCE[0])
    assert diagnose(train, held).findings["verdict"] != "nothing_wrong"


@pytest.mark.parametrize("seed", rows([31, 33, 34, 35], 0))
def test_zeros_of_depth_as_stages_have_them_are_no_other_skin(tmp_path, seed):
    """A zero bends a force as numbers of its own would: it is one number of a session, and they are four."""
    sessions, _ = make_sessions([], seed=seed, protocol="full", noise="white", n_taxels=2)
    write_case(sessions, tmp_path)
    every = [replace(r, depth=r.depth + off) for r, off in zip(load(tmp_path), (1.5e-6, 0.0, -2e-6), strict=True)]
    findings = diagnose(every[:2], every[2:]).findings
    assert findings["findings"] == [] and findings["verdict"] == "nothing_wrong", findings["findings"]
    assert "parameters" not in {u["cause"] for u in findings["untestable"] if u.get("hardware")}


@pytest.mark.parametrize("seed", rows([5, 7], 0))
def test_skin_that_differs_by_more_than_specimens_do_is_a_finding_with_the_numbers_of_each_session(tmp_path, seed):
    sessions, _ = make_sessions([], seed=seed, protocol="full", between=0.06, n_sessions=4)
    write_case(sessions, tmp_path)
    every = load(tmp_path)
    findings = diagnose(every[:3], every[3:]).findings
    (found,) = findings["findings"]
    assert (found["cause"], found["where"], findings["verdict"]) == ("parameters", "skin", "explained")
    assert set(found["evidence"]["of_each_session"]) == {r.name for r in every} and "session to session" in found["means"]
    (held,) = [r["rmse"] for r in findings["recordings"] if r["held_out"]]
    for channel, gain in findings["gain_by_channel"].items():
        before = findings["baseline"]["rmse"][channel]["held_out"], held[channel]["baseline"]
        assert before == pytest.approx([gain["held_out_rmse_before"]] * 2), "one skin of all sessions, everywhere"


@pytest.mark.slow
def test_what_all_sessions_have_is_found_beside_skin_that_differs(tmp_path):
    sessions, _ = make_sessions([Hide("lag", "taxel", "one_pole", 1.5)], seed=11, protocol="full", between=0.01, n_taxels=2)
    write_case(sessions, tmp_path)
    every = load(tmp_path)
    findings = diagnose(every[:2], every[2:]).findings
    assert [(f["cause"], f["where"]) for f in findings["findings"]] == [("lag", "taxel")]


@pytest.mark.parametrize(("spread", "off"), [(None, 0.06), (np.ones(1), 0.0)])
def test_where_taxels_have_shares_of_a_sessions_own_the_load_cell_alone_shows_another_skin(spread, off):
    """These take up any stiffness: at the edge of an array the taxels feel less, while the whole skin is the same."""
    session = replace(prepare(recorded(PLAIN)), spread=spread, skin={"k1": 1.06, "k2": 1.0 - 0.06 * 3.0})
    assert own_skin._off(PLAIN, session) == pytest.approx(off, abs=1e-9)


@pytest.mark.parametrize("seed", rows([1, 3], 0))
def test_relaxation_is_found_beside_skin_that_differs_and_nothing_else_with_it(tmp_path, seed):
    """Softening until some day, or zeros of depth, would explain part of such skin, and hide the relaxation."""
    hide = Hide("stress_relaxation", "skin", "prony2", 1.0)
    sessions, _ = make_sessions([hide], seed=seed, protocol="full", noise="white", between=0.02, n_sessions=4)
    write_case(sessions, tmp_path)
    every = load(tmp_path)
    findings = diagnose(every[:3], every[3:]).findings
    assert [(f["cause"], f["where"]) for f in findings["findings"]] == [("stress_relaxation", "skin")]
