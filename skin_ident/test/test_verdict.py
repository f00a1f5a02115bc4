"""The verdict never contradicts what is left: clearly more than noise is unexplained, whatever the search could name."""

from dataclasses import replace

import numpy as np
import pytest
from rows import rows
from scipy.signal import lfilter
from test_faults import session
from world import make_sessions, write_case
from world.hidden import Hide

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.telling.outcome import Outcome
from skin_ident.estimators.fit import fit_recordings
from skin_ident.recordings.declared import Declared
from skin_ident.recordings.load import load
from skin_ident.report.gains import better
from skin_ident.report.markdown import markdown
from skin_ident.report.reading import view
from skin_ident.report.story import tell
from skin_ident.report.terminal import summary


def bent(r, power):
    """A taxel that follows another power of the load in every session, which no form of the catalogue does."""
    first, second, third = r.taxels
    return replace(r, taxels=np.array([first, 2.0 * np.sign(second) * np.abs(second / 2.0) ** power, third]))


def late(r, samples):
    first, second, third = r.taxels
    return replace(r, taxels=np.array([first, np.roll(second, samples), third]))


@pytest.mark.parametrize(("spoil", "by"), rows([(bent, (1.0, 1.6, 0.6)), (late, (0, 40, -40))], 0))
def test_a_taxel_that_is_another_one_in_each_session_is_not_nothing(spoil, by):
    findings = diagnose([spoil(session(i), q) for i, q in enumerate(by)]).findings
    assert findings["verdict"] == ("partly_explained" if findings["findings"] else "unexplained")
    assert any(w.startswith("taxel_1: the remaining error") for w in findings["warnings"])
    assert findings["gain_by_channel"]["taxel_1"]["held_out_rmse_after"] > 1.5 * findings["gain_by_channel"]["taxel_1"]["noise_floor"]


def coarse(r):
    return replace(r, depth=np.round(r.depth / 10e-6) * 10e-6, declared=Declared(encoder_step_um=10.0))


def heavy_tailed(r):
    rng = np.random.default_rng(len(r.name))
    return replace(r, force=r.force + 0.03 * rng.standard_t(3, r.t.size), taxels=r.taxels + 0.03 * rng.standard_t(3, r.taxels.shape))


def grows(r):
    return replace(r, force=r.force + 0.02 * r.force * np.random.default_rng(5).standard_normal(r.t.size))


@pytest.mark.parametrize("spoil", rows([heavy_tailed, grows, coarse], 2))
def test_noise_of_any_kind_is_nothing_wrong(spoil):
    findings = diagnose([spoil(session(i)) for i in (11, 12, 13)]).findings
    assert findings["verdict"] == "nothing_wrong" and not findings["warnings"]


@pytest.mark.parametrize("declared", [Declared(), Declared(skin_thickness_mm=6.0), Declared(moving_mass_kg=0.0005)])
def test_fit_and_diagnosis_hold_one_mass_and_say_where_it_is_from(declared):
    sessions = [replace(session(i), declared=declared) for i in (1, 2)]
    findings, estimate = diagnose(sessions).findings, fit_recordings(sessions)
    held = findings["baseline"]["held"]["m"]
    assert (
        held["value"]
        == pytest.approx(estimate.values["m"])
        == pytest.approx(declared.moving_mass_kg or 0.108e-3 * (declared.skin_thickness_mm or 4.0))
    )
    assert held["because"] in summary(findings) and held["because"] in estimate.verdicts["m"].sentence and "rig.yaml" in held["because"]
    assert held["because"] in markdown(tell(Outcome(findings)))


def lagging(r):
    share = 1.0 - np.exp(-r.dt / 0.05)
    return replace(r, taxels=np.array([r.taxels[0], lfilter([share], [1.0, share - 1.0], r.taxels[1]), r.taxels[2]]))


@pytest.mark.parametrize("held_out", rows([1, 0], 1))
def test_the_gain_of_the_only_cause_is_one_number_in_terminal_findings_and_report(held_out):
    sessions = [lagging(session(i)) for i in (1, 2, 3)]
    findings = diagnose(sessions[held_out:], sessions[:held_out]).findings
    assert [(f["cause"], f["where"]) for f in findings["findings"]] == [("lag", "taxel_1")]
    gain, whole = findings["findings"][0]["gain"], findings["gain_by_channel"]["taxel_1"]
    assert gain["ci95"] == whole["ci95"] and gain["held_out_rmse_after"] == whole["held_out_rmse_after"]
    error = next(e for e in view(findings).errors if e.channel == "taxel_1")
    assert error.pair == pytest.approx((gain["held_out_rmse_before"], gain["held_out_rmse_after"]), rel=1e-9)
    printed = [f"{1e3 * x:.3g}\u00a0mN" for x in error.pair]
    assert f"-> {error.pair[1]:.3g} N" in summary(findings) and all(x in better(view(findings)).sentences[0] for x in printed)


def test_what_is_many_times_louder_than_the_air_is_not_nothing(tmp_path):
    """A load cell that is late by 80 ms from some moment on, on triangles: by far more than any delay that is like its first order."""
    made, _ = make_sessions(None, seed=55, n_sessions=3, noise="white", protocol="single_rate_triangles")

    def slipped(s):
        return replace(s, force=np.interp(s.t - 0.08 * (s.t > np.quantile(s.t, 0.6)), s.t, s.force))

    write_case([slipped(s) for s in made], tmp_path)
    recordings = load(tmp_path)
    findings = diagnose(recordings[:2], recordings[2:]).findings
    assert findings["verdict"] != "nothing_wrong"
    assert {f["cause"] for f in findings["findings"]} <= {"time_shift"}


def test_the_terminal_says_in_which_sessions_most_is_left():
    rest = {"most_in": ["day4", "day5"], "times": 2.34, "channel": "force"}
    findings = {"recordings": [{"name": f"day{i}"} for i in range(6)], "findings": [], "baseline": {}, "untestable": []}
    said = {verdict: summary(findings | {"systematic_rest": rest, "verdict": verdict}) for verdict in ("unexplained", "nothing_wrong")}
    assert "of the force is from day4 on: 2.3 times" in said["unexplained"] and "day4" not in said["nothing_wrong"]


@pytest.mark.slow
def test_in_turn_the_plain_model_does_no_worse_than_where_it_was_fitted(tmp_path):
    """Its error is systematic, and no noise that wanders: fitted as if it were, it would be twice as large in other sessions."""
    made, _ = make_sessions([Hide("nonlinear_stiffness", "skin", "fung", 12.0)], seed=5, n_taxels=1, protocol="full", noise="white")
    write_case(made, tmp_path)
    findings = diagnose(load(tmp_path)).findings
    assert [f["cause"] for f in findings["findings"]] == ["nonlinear_stiffness"]
    for channel, gain in findings["gain_by_channel"].items():
        fitted = [r["rmse"][channel]["baseline"] for r in findings["recordings"]]
        assert gain["held_out_rmse_before"] == pytest.approx(np.mean(fitted), rel=0.05)
