"""What lies in the ratios of an array's taxels is found in whole recordings of the world of hidden effects."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from array_making import Spread, analysed, found, names, names_or_rivals, record, record_at
from rows import rows

from skin_ident.criticism.array.layout import layout_of
from skin_ident.criticism.array.sentences import why
from skin_ident.criticism.diagnose import diagnose
from skin_models.model_file import load_model, save_model
from skin_models.signals import motion

ALONG = ((0, 0), (4, 0), (-4, 0))
SHORT = {"protocol": "pyramid", "noise": "white", "thickness_mm": 4, "layout": "row_5mm"}


@pytest.mark.slow
def test_a_contact_that_leans_with_depth_is_off_centre_and_no_saturation(tmp_path):
    findings = found(record(tmp_path, "off_centre", "lean", seed=0, layout="row_5mm", noise="white"))
    assert names(findings) == [("off_centre", "rig")]


@pytest.mark.slow
def test_a_lean_that_steps_may_feign_is_said_and_not_excluded(tmp_path):
    findings = found(record(tmp_path, "off_centre", "lean", size=0.5, seed=0, layout="row_5mm", noise="white"))
    reasons = [u["because"] for u in findings["untestable"] if (u["cause"], u.get("where")) == ("off_centre", "rig")]
    assert not names(findings) and len(reasons) == 1 and "it would explain" in reasons[0]
    assert "off_centre" not in {e["cause"] for e in findings["excluded"]}


def test_sessions_at_several_places_name_the_contact_and_the_written_model_says_the_same(tmp_path):
    recordings = record_at(tmp_path, ALONG, "off_centre", "shift", size=8.0, seed=0, **SHORT)
    outcome = diagnose(recordings[:-1], recordings[-1:])
    assert names(outcome.findings) == [("off_centre", "rig")]
    finding = outcome.findings["findings"][0]
    assert finding["gain"]["held_out_rmse_after"] < finding["gain"]["held_out_rmse_before"]
    save_model(outcome.model, tmp_path / "model.yaml", outcome.std)
    model, trace = load_model(tmp_path / "model.yaml"), outcome.traces[0]
    again = model.simulate(motion(trace.t, trace.depth, trace.speed)).taxels
    assert np.allclose(again, trace.extended[1:], atol=1e-3 * np.abs(trace.extended).max())


def test_nothing_is_named_where_nothing_is_hidden_and_bounds_are_given(tmp_path):
    findings = found(record(tmp_path, seed=4, **SHORT))
    assert not names(findings) and findings["verdict"] == "nothing_wrong"
    bounds = {(e["cause"], e.get("where"), e.get("parameter")) for e in findings["excluded"]}
    assert {("off_centre", "rig", "x"), ("crosstalk", "taxel", "share")} <= bounds
    assert "spread_width" in {u["cause"] for u in findings["untestable"]}
    limited = [e for e in findings["excluded"] if "limited_by" in e]
    assert {e["cause"] for e in limited} & {"off_centre", "crosstalk"} and all("taxel_gain_uncertainty" in e["limited_by"] for e in limited)


def test_without_positions_an_array_cannot_be_judged_and_the_findings_say_so(tmp_path):
    recordings = record(tmp_path, "off_centre", "shift", seed=0, taxels=2, **SHORT)
    for r in recordings:
        object.__setattr__(r, "declared", r.declared.__class__())
    because = {u["cause"]: u["because"] for u in found(recordings)["untestable"]}
    assert "taxel_positions_mm" in because["off_centre"] and "taxel_positions_mm" in because["anisotropy"]


@pytest.mark.parametrize(
    ("cause", "form", "where", "key"),
    [
        ("off_centre", "shift", None, ("off_centre", "rig")),
        ("gain_error", "static", "taxel_0", ("gain_error", "taxel_0")),
        ("crosstalk", "neighbour", "taxel", ("crosstalk", "taxel")),
        ("crosstalk", "common", "taxel", ("crosstalk", "taxel")),
    ],
)
def test_the_cause_in_static_ratios_is_named_from_several_contacts(tmp_path, cause, form, where, key):
    a = analysed(record_at(tmp_path, (*ALONG, (2, 0)), cause, form, where, seed=2, careful=where == "taxel_0", **SHORT))
    assert a.named and a.judgement.causes[0].key == key


@pytest.mark.parametrize(("kind", "amount", "cause"), [("wider", 0.1, "spread_width"), ("flat", 0.15, "spread_shape")])
def test_a_spread_other_than_declared_is_named_from_several_contacts(tmp_path, kind, amount, cause):
    a = analysed(record_at(tmp_path, (*ALONG, (2, 0)), seed=2, careful=True, also=[(Spread(kind), amount)], **SHORT))
    assert a.named and a.judgement.causes[0].key == (cause, "skin")


def test_a_block_that_was_written_twice_is_left_out_of_the_ratios(tmp_path):
    recordings = record_at(tmp_path, (*ALONG, (2, 0)), seed=2, careful=True, also=[(Spread("wider"), 0.1)], **SHORT)
    rows = np.vstack([recordings[1].depth, recordings[1].force, recordings[1].taxels])
    rows[:, 2200:2400] = rows[:, 2000:2200]
    recordings[1] = replace(recordings[1], depth=rows[0], force=rows[1], taxels=rows[2:])
    findings = diagnose(recordings[:2], recordings[2:]).findings["findings"]
    assert {f["cause"] for f in findings} == {"data_error", "spread_width"}


@pytest.mark.parametrize(("size", "also"), rows([(1.0, {("gain_error", "taxel_2")}), (None, set())], 1), ids=["a gain", "nothing else"])
def test_beside_a_dead_taxel_the_others_are_judged(tmp_path, size, also):
    hidden = ("gain_error", "static", "taxel_2", size) if size else ()
    recordings = record_at(tmp_path, (*ALONG, (2, 0)), *hidden, seed=2, taxels=4, careful=True, **SHORT)
    living = np.array([0.0, 1.0, 1.0, 1.0])[:, None]
    findings = found([replace(r, taxels=np.where(r.t > 5.0 * (i == 0), living, 1.0) * r.taxels) for i, r in enumerate(recordings)])
    assert set(names(findings)) == {("dead_taxel", "taxel_0"), *also}
    assert ("gain_error", "taxel_0") not in {(e["cause"], e.get("where")) for e in findings["excluded"]}
    assert also or any(e["cause"] == "gain_error" and e.get("where") == "taxel_2" and "limited_by" in e for e in findings["excluded"])


@pytest.mark.parametrize("step", [0.0, 0.01])
def test_a_stuck_taxel_under_the_plunger_leaves_the_others_their_model(tmp_path, step):
    """Its constant may move by a step of the converter from one session to the next: beside noise of nothing that is no error."""
    recordings = record_at(tmp_path, ((0, 0), (2, 0), (-2, 0), (1, 0)), seed=2, careful=True, **SHORT)
    nearest = int(np.argmax(recordings[0].taxels.std(axis=1)))
    held = [np.where(np.arange(3)[:, None] == nearest, 4.78 + step * (i == 3), r.taxels) for i, r in enumerate(recordings)]
    findings = found([replace(r, taxels=taxels) for r, taxels in zip(recordings, held, strict=True)])
    force = findings["gain_by_channel"]["force"]
    assert names(findings) == [("dead_taxel", f"taxel_{nearest}")] and findings["verdict"] == "explained"
    assert force["held_out_rmse_before"] < 0.1 and force["held_out_rmse_after"] < 1.5 * force["noise_floor"] < 0.1


@pytest.mark.parametrize(("times", "recognised"), [(2**-0.5, True), (0.6, False)])
def test_a_standard_deviation_that_was_declared_as_the_width_is_recognised(tmp_path, times, recognised):
    recordings = record_at(tmp_path, (*ALONG, (2, 0)), seed=2, careful=True, **SHORT)
    declared = [replace(r.declared, spread_width_mm=times * r.declared.spread_width_mm) for r in recordings]
    recordings = [replace(r, declared=d) for r, d in zip(recordings, declared, strict=True)]
    first = analysed(recordings).judgement.causes[0]
    assert first.key == ("spread_width", "skin")
    assert ("standard deviation" in why(first, layout_of(recordings))) == recognised


@pytest.mark.parametrize("taxels", [3, 4])
def test_scattered_calibrations_are_no_cause(tmp_path, taxels):
    for seed in range(3):
        assert not analysed(record(tmp_path / str(seed), seed=seed, taxels=taxels, scatter=0.02, **SHORT)).named


@pytest.mark.campaign
def test_campaign_over_arrays(tmp_path, capsys):
    """Every cause of an array, under one contact and under four: rates with their counts."""
    cases = [(None, None, None), *(("off_centre", f, None) for f in ("shift", "walk", "lean")), ("gain_error", "static", "taxel_0")]
    cases += [("crosstalk", f, "taxel") for f in ("neighbour", "common", "smeared")]
    counts: dict[tuple, Counter] = {}
    for i, (cause, form, where) in enumerate(cases):
        for seed in range(6):
            one, four = tmp_path / f"one_{i}_{seed}", tmp_path / f"four_{i}_{seed}"
            made = {
                "one": record(one, cause, form, where, seed=seed),
                "four": record_at(four, (*ALONG, (2, 0)), cause, form, where, seed=seed),
            }
            for contacts, recordings in made.items():
                counts.setdefault((cause, form, contacts), Counter())[_verdict(found(recordings), cause, where or "rig")] += 1
    with capsys.disabled():
        for key, count in counts.items():
            print(*key, dict(count))
    assert not any(count["wrong"] for (cause, *_), count in counts.items() if cause is None)


def _verdict(findings: dict, cause: str | None, where: str) -> str:
    if not names(findings):
        return "silent"
    if (cause, where) in names(findings):
        return "right"
    return "alternative" if (cause, where) in names_or_rivals(findings) else "wrong"


@pytest.mark.parametrize(("cause", "form", "where", "seed"), [("crosstalk", "smeared", "taxel", 22), ("off_centre", "walk", "rig", 21)])
def test_what_cannot_be_written_leaves_a_model_that_does_no_worse_than_the_baseline(tmp_path, cause, form, where, seed):
    recordings = record(tmp_path, cause, form, size=4.0, seed=seed, **SHORT)
    outcome = diagnose(recordings[:-1], recordings[-1:])
    assert [f["evidence"]["in_model"] for f in outcome.findings["findings"] if (f["cause"], f["where"]) == (cause, where)] == [False]
    for trace in outcome.traces:
        error = {}
        for name in ("baseline", "model"):
            save_model(getattr(outcome, name), tmp_path / f"{name}.yaml")
            again = load_model(tmp_path / f"{name}.yaml").simulate(motion(trace.t, trace.depth, trace.speed)).taxels
            error[name] = np.sqrt(np.mean((again - trace.measured[1:]) ** 2))
        assert error["model"] < 1.01 * error["baseline"]
