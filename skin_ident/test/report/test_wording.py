"""Words that numbers ask for: what is above the noise, what a comparison leaves out, what is ruled out in part."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import report_examples as examples
from wording_making import findings, rivals

from skin_ident.criticism.above import above_noise
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.rivals import Rival
from skin_ident.criticism.telling.findings import found
from skin_ident.criticism.telling.outcome import Round, Trace
from skin_ident.report.appendix import parameters, reading, size_ruled_out, why_untestable
from skin_ident.report.charts import cut_off, overlay
from skin_ident.report.counsel import rebuild_answer
from skin_ident.report.focus import focus
from skin_ident.report.gains import better
from skin_ident.report.markdown import markdown
from skin_ident.report.pictures import pictures
from skin_ident.report.reading import view
from skin_ident.report.story import tell
from skin_ident.report.terminal import summary

LEFT_OUT = "the moments at which it acts are not compared"


def adhesion() -> dict:
    return {
        "cause": "adhesion", "where": "skin", "channels": ["force"], "means": "m", "alternatives": [], "separating_experiment": "",
        "parameters": {"reach": {"value": 1e-5, "unit": "m"}},
        "evidence": {"why": "it pulls", "in_model": True, "predicts_nothing_for": LEFT_OUT},
        "gain": {"held_out_rmse_before": None, "held_out_rmse_after": None, "ci95": None, "channel": "force", "unit": "N"},
    }  # fmt: skip


def test_what_is_above_the_noise_is_not_called_noise():
    assert above_noise(findings()) is None and above_noise(findings(left=0.06)) == ("force", 0.06 / 0.05)
    (near, far) = (tell(examples.Outcome(findings(left=left))).story.headline.line for left in (0.052, 0.06))
    assert "down to their noise" in near and "20\u00a0% above" in far
    assert "looks like noise" in summary(findings()) and "1.20 times" in summary(findings(left=0.06))


def test_what_is_in_doubt_is_said_on_the_first_screen_and_in_the_terminal():
    doubt = {"cause": "lag", "where": "taxel_0", "because": "half of the data speak for it", "needs": "the other half again"}
    said = findings() | {"untestable": [doubt | {"in_doubt": True}, doubt | {"where": "load_cell"}]}
    story = tell(examples.Outcome(said)).story
    assert [w.name for w in story.wrong] == ["", "Not settled"] and "Lag in taxel 0: half of the data" in story.wrong[1].means
    assert story.sure == "Fairly sure: 1 cause in doubt" and story.rebuild != "No"
    assert story.next[0] == "To settle lag in taxel 0: record the other half again."
    assert summary(said).count("in doubt") == 1 and "half of the data" in summary(said)


def test_an_error_below_the_floor_is_no_more_than_noise():
    told = better(view(findings(left=0.045)))
    assert "no more than noise" in told.sentences[0] and "Noise alone" not in told.sentences[0]


def test_a_gain_that_was_not_measured_is_not_claimed():
    v = view(findings("explained", entries=[adhesion()]))
    story = tell(examples.Outcome(findings("explained", entries=[adhesion()]))).story
    assert not v.judged and story.better.number == "Not measured" and "not compared" in story.better.caption
    assert "comparison leaves out" in story.headline.line and not any("improves" in s for s in story.sure_because)
    said = summary(findings("explained", entries=[adhesion()]))
    assert "it pulls" in said and "held-out error" not in said


def test_sizes_of_each_session_are_printed():
    entry = adhesion() | {"parameters": {}, "evidence": {"why": "each has its own", "of_each_session": {"a": "+0.06 N", "b": "-0.03 N"}}}
    assert "a: +0.06 N" in summary(findings("explained", entries=[entry])) and "b: -0.03 N" in summary(
        findings("explained", entries=[entry])
    )


def test_zeros_that_are_no_fault_are_no_gain():
    """With nothing named there is one simulation, that with the zeros, and one sentence says that it has them."""
    own = {"cause": "position_offset", "where": "rig", "because": "it would step by 2 µm", "own_zero": True}
    before = {c: {"train": 0.07, "held_out": 0.07, "unit": "N"} for c in ("force", "taxel_0")}
    content = findings() | {"untestable": [own]}
    content["baseline"] = content["baseline"] | {"rmse": before}
    moved = trace("one", True, None)
    all_ = tell(examples.Outcome(content, traces=(replace(moved, baseline=moved.baseline + 0.01),)))
    story, text = all_.story, markdown(all_)
    assert story.better.number == "Nothing to gain" and "its own zero of depth" in story.better.sentences[-1]
    assert not any("picture" in s for s in story.why) and not all_.seen.changes
    assert "| channel | error |" in text and "less error" not in text and "confidence" not in text


def test_a_picture_that_does_not_speak_for_what_is_named_is_not_called_a_reason():
    entry = rivals(("lag", "taxel_0"), gain={"held_out_rmse_before": 0.03, "held_out_rmse_after": 0.02, "channel": "taxel_0"})
    seen = trace("one", True, 1)
    for better_, said in ((0.1 * np.sin(seen.t), True), (1e-3 * np.sin(seen.t), False)):
        found_ = replace(seen, extended=seen.extended + np.stack([0.0 * seen.t, better_]))
        why = tell(examples.Outcome(findings("explained", entries=[entry]), traces=(found_,))).story.why
        assert any("picture" in s for s in why) is said


def trace(name: str, held: bool, astray: int | None) -> Trace:
    t = np.arange(3000) / 100.0
    noise = np.random.default_rng(len(name)).normal(0.0, 0.02, (2, t.size))
    noise[0] *= 2.5
    if astray is not None:
        noise[astray] += 0.2 * np.sin(t)
    flat = np.zeros((2, t.size))
    return Trace(name, held, t, t, t, ("force", "taxel_0"), noise, flat, flat)


def test_where_nothing_is_named_the_channel_that_strays_is_shown():
    v = view(findings("unexplained", train=0.08))
    seen = focus((trace("one", False, 1), trace("other", True, None)), v)
    assert (seen.trace.session, seen.channel) == ("one", "taxel_0")
    assert better(v).number == "No gain" and "data it was fitted to" in better(v).sentences[0]


def test_what_is_ruled_out_in_part_says_so_in_both_tables():
    lean = {"cause": "off_centre", "where": "rig", "parameter": "shift", "below": 4e-6, "unit": "m", "form": "lean"}
    whole = {"cause": "off_centre", "because": "the ratios differ", "needs": "a scan"}
    v = view({"excluded": [lean, lean | {"cause": "friction"}], "untestable": [whole, whole | {"cause": "anisotropy"}]})
    assert ["only in part" in size_ruled_out(e, v) for e in v.excluded] == [True, False]
    assert [why_untestable(e, v) for e in v.untestable] == [
        "Ruled out in part only (its form lean): the ratios differ.",
        "The ratios differ.",
    ]


@pytest.mark.parametrize(
    ("names", "answer", "because"),
    [
        ([("stress_relaxation", "skin"), ("hysteresis", "skin")], "No", "the skin behaves like this"),
        ([("stress_relaxation", "skin"), ("cyclic_softening", "skin"), ("position_offset", "rig")], "No", "none of the names"),
        ([("stress_relaxation", "skin"), ("mount_compliance", "rig")], "No sensor, but perhaps the mount", "mount: a press on a rigid"),
        ([("lag", "load_cell"), ("backlash", "rig")], "No taxel, but perhaps the load cell or the stage", "stage: reversals in"),
        ([("hysteresis", "skin"), ("lag", "load_cell")], "No taxel, but perhaps the load cell", "To check the load cell: sinusoids"),
        ([("mount_compliance", "rig"), ("backlash", "rig")], "No sensor, but perhaps the mount or the stage", "the test rig is at fault"),
        ([("gain_error", "taxel_0"), ("off_centre", "rig")], "No", "at most its calibration"),
        ([("lag", "taxel_1"), ("hysteresis", "taxel_1")], "Perhaps", "the sensor itself"),
        ([("lag", "taxel_1"), ("time_shift", "clock")], "Not before the next experiment", "another does not"),
        ([("data_error", "taxel_0"), ("gain_error", "taxel_0")], "Not before the next experiment", "a wrong record"),
    ],
)
def test_what_is_said_of_rebuilding_is_true_of_every_name_that_is_left(names, answer, because):
    said = rebuild_answer(view(findings("explained", entries=[rivals(*names)])))
    assert said[0] == answer and because in said[1]


def test_an_experiment_speaks_for_itself_and_words_without_one_are_said_for_whom():
    names = [("lag", "taxel_1"), ("time_shift", "clock")]
    battery = rivals(*names, battery="separating.yaml", separating_experiment="record separating.yaml (x; 20 s): it would tell")
    words = rivals(*names, separating_experiment="record quick motion")
    first, second = (tell(examples.Outcome(findings("explained", entries=[e]))).story for e in (battery, words))
    assert first.next[0] == "Record separating.yaml (x; 20 s): it would tell."
    assert second.next[0] == "To tell lag in taxel 1 from time shift of the clock of the load cell: record quick motion."
    assert any(w.means == "The other name fits these data almost as well." for w in first.wrong)
    elsewhere = tell(examples.Outcome(findings("explained", entries=[battery])), "/there").story.next
    assert "Record /there/separating.yaml (x" in elsewhere[0] and any("model.yaml, in /there," in s for s in elsewhere)


@pytest.mark.parametrize(
    ("has", "scan", "words"),
    [
        ((None, None), False, "everything named here is in it"),
        ((True, False), False, "what can be simulated of what is named here is in it"),
        ((None, None), True, "what can be simulated of what is named here is in it"),
        ((True, True), True, "everything named here is in it"),
        ((False, False), False, None),
    ],
)
def test_the_model_is_not_said_to_have_what_the_findings_say_it_has_not(has, scan, words):
    gain = {"held_out_rmse_before": 0.2, "held_out_rmse_after": 0.1}
    known = [{} if h is None else {"in_model": h, "simulated": "as it may be said"} for h in has]
    entries = [rivals((cause, "rig"), gain=gain, evidence=e) for cause, e in zip(("off_centre", "crosstalk"), known, strict=True)]
    content = findings("explained", entries=entries) | {"recordings": [{"name": "a"} | ({"kind": "static spread scan"} if scan else {})]}
    told = [s for s in tell(examples.Outcome(content)).story.next if "model.yaml" in s]
    assert [words in s for s in told] == ([] if words is None else [True])


def test_the_clocks_of_the_catalogue_are_one_rival_as_near_as_the_nearest():
    near = (Rival("time_shift", "clock", 1.0), Rival("hysteresis", "skin", 5.0), Rival("time_shift", "clock_taxels", 7.0))
    gain = SimpleNamespace(carried=("force",), relative=0.9, held_out="b", entry={})
    entry = found(Named("lag", "taxel", gain, 1.0, near), examples.Model(examples.SILICONE), {}, {})
    told = [(a["cause"], a["where"], a["explains_less_by"]) for a in entry["alternatives"]]
    assert told == [("time_shift", "clock", 1.0), ("hysteresis", "skin", 5.0)]
    nearest = (replace(near[2], short_by=0.5), *near)
    entry = found(Named("lag", "taxel", gain, 1.0, nearest), examples.Model(examples.SILICONE), {}, {})
    assert entry["alternatives"][0] == {"cause": "time_shift", "where": "clock", "channel_clock": "taxels", "explains_less_by": 0.5}
    assert view({"findings": [entry]}).findings[0].names[1] == ("time_shift", "clock_taxels")


def test_it_is_said_which_clock_could_not_be_tested():
    clocks = [{"cause": "time_shift", "where": "clock", "below": 1e-3, "unit": "s", "parameter": "delay"}]
    clocks += [clocks[0] | {"channel_clock": name} for name in ("taxels", "depth")]
    text = markdown(tell(examples.Outcome(findings() | {"excluded": clocks})))
    assert all(f"| time shift of the clock{of} | 1.00\u00a0ms" in text for of in (" of the load cell", " of the taxels", " of the encoder"))
    one = view(findings() | {"excluded": clocks[:1], "untestable": [clocks[1] | {"because": "it was slow"}]})
    assert why_untestable(one.untestable[0], one) == "It was slow." and "only in part" not in size_ruled_out(one.excluded[0], one)


def test_a_rival_that_explains_clearly_less_is_not_said_to_fit_as_well():
    entry = rivals(("lag", "load_cell"), ("stress_relaxation", "skin"), evidence={"likelihood_gain": 51184.0})
    entry["alternatives"][0]["explains_less_by"] = 1168.0
    said = " ".join(w.means for w in tell(examples.Outcome(findings("explained", entries=[entry]))).story.wrong)
    assert "explains 2.3\u00a0% less of the mismatch" in said and "almost as well" not in said


def test_what_is_said_of_other_names_says_of_which_and_stands_below_the_finding():
    entry = rivals(("lag", "taxel"), ("time_shift", "clock"), ("time_shift", "clock"), evidence={"likelihood_gain": 1000.0})
    entry["alternatives"][1] |= {"channel_clock": "depth", "explains_less_by": 92.0}
    told = tell(examples.Outcome(findings("explained", entries=[entry])))
    assert [w.name or re.split(" these data| less", w.means)[0] for w in told.story.wrong[1:]] == [
        "Or time shift of the clock of the load cell", "Or time shift of the clock of the encoder",
        "Time shift of the clock of the load cell fits", "Time shift of the clock of the encoder explains 9.2\u00a0%",
    ]  # fmt: skip
    assert [w.of_last for w in told.story.wrong] == [False, *[True] * 4] and "\n  - **Or time shift" in markdown(told)
    entry |= {"means": "late", "separating_experiment": "", "gain": {"held_out_rmse_before": None}}
    said = summary({"baseline": {}, "verdict": "explained", "findings": [entry]})
    assert "told from: time_shift in the clock of the load cell\n" in said and "told from: time_shift in the clock of the encoder" in said


@pytest.mark.parametrize(("count", "said"), [(3, "The other was accepted in"), (4, "The other 2 were accepted in the same way")])
def test_how_many_others_were_accepted(count, said):
    story = tell(examples.Outcome(findings("explained", entries=[rivals(("drift", f"taxel_{i}")) for i in range(count)]))).story
    assert any(s.startswith(said) for s in story.why)


def test_what_may_be_nothing_is_no_size():
    """A parameter within its noise of none, or a ratio of one, is not printed as a size."""
    sizes = {"delay": {"value": 8e-4, "unit": "s", "std": 1e-4}, "skew": {"value": -2.1, "unit": "ppm", "std": 3.7}}
    entry = rivals(("time_shift", "clock"), parameters=sizes, channel_clock="depth")
    (wrong, *_) = tell(examples.Outcome(findings("explained", entries=[entry]))).story.wrong
    assert wrong.name == "Time shift of the clock of the encoder" and "0.8" in wrong.size and "later it gets" not in wrong.size


def test_where_no_motion_helps_it_is_said_what_a_person_can_do():
    nothing = {"separating_experiment": "none tells them apart", "separating_evidence": {"expected": 2.0, "recorded": 1.0}}
    entry = rivals(("lag", "taxel_1"), ("time_shift", "clock"), advice="remove the filter", **nothing)
    story = tell(examples.Outcome(findings("explained", entries=[entry]))).story
    assert story.rebuild == "Not before a check by hand"
    assert story.next[1] == "If it is lag in taxel 1: remove the filter." and story.next[2].startswith(
        "If it is time shift of the clock of the load cell: sync"
    )


def test_the_headline_drops_no_name_and_the_reasons_compare_with_what_is_not_one_of_them():
    entry = rivals(("rate_dependence", "skin"), ("position_offset", "rig"), ("nonlinear_stiffness", "skin"), ("time_shift", "clock"))
    bars = (("rate_dependence", "skin", 700.0), ("time_shift", "clock_taxels", 600.0), ("drift", "taxel", 350.0))
    story = tell(examples.Outcome(findings("explained", entries=[entry]), rounds=(Round(bars, "rate_dependence"),))).story
    assert story.headline.title == "Explained, but not surely: rate dependence in the skin, position offset in the rig or 2 others"
    assert "2.0 times" in story.why[0] and "not named beside it, drift in" in story.why[0]


def given(**more) -> dict:
    """A given model whose k1 is wrong; its mass is held, and k2 is hardly another."""

    def numbers(k1: float, k2: float, std: float | None) -> dict:
        return {"k1": {"value": k1, "unit": "N/m", "std": std}, "k2": {"value": k2, "unit": "N/m", "std": std}}

    content = findings("explained", entries=[rivals(("parameters", "skin"), parameters=numbers(8526.0, 2629.0, 1.0))])
    before = content["baseline"] | {"given": True, "parameters": numbers(11087.0, 2622.7, None)} | more
    return content | {"baseline": before, "extended": content["extended"] | {"parameters": numbers(8526.0, 2629.0, 1.0)}}


def test_given_numbers_are_not_said_to_be_fitted_nor_to_hide_anything():
    told = tell(examples.Outcome(given()))
    (wrong, *_), v = told.story.wrong, told.view
    assert re.sub(r"\s", " ", wrong.size) == "k1 8526 ± 1 N/m instead of 11 090 N/m (−23 %)"
    table, read = str(parameters(v)), str(reading(v, ""))
    assert "not as given" in table and "hiding" not in table and "they were not fitted" in table and table.count("±") == 2
    assert "that was given, not fitted" in read and "both fitted" not in read
    assert "recorded as a twin" in str(reading(view(given(model="twin")), ""))
    assert "both fitted" in str(reading(view(findings("explained", entries=[adhesion()])), "")) and "| as given |" in markdown(told)


def test_what_is_held_is_no_wrong_number():
    gain = SimpleNamespace(carried=("force",), relative=0.9, held_out="b", entry={})
    wrong = Named("parameters", "skin", gain, 1.0, ())
    assert set(found(wrong, examples.Model(examples.SILICONE), {"k1": 1.0, "k2": 2.0}, {})["parameters"]) == {"k1", "k2"}


def test_many_findings_keep_their_main_size_on_the_first_screen():
    sizes = {"frequency": {"value": 5.63, "unit": "Hz"}, "amplitude": {"value": 0.34, "unit": "N"}, "phase": {"value": 1.0, "unit": "1"}}
    own = rivals(("drift", "taxel_1"), evidence={"of_each_session": {"a": "+0.06 N", "b": "-0.03 N", "c": "+0.01 N"}})
    entries = [rivals(("interference", "taxel_0"), parameters=sizes), own, rivals(("lag", "taxel_1")), rivals(("lag", "load_cell"))]
    said = [w.size for w in tell(examples.Outcome(findings("explained", entries=entries))).story.wrong]
    assert "5.63\u00a0Hz" in said[0] and "0.340\u00a0N" in said[0] and "phase" not in said[0] and "more" not in said[0]
    assert said[1] == "a: +0.06 N; b: -0.03 N"


@pytest.mark.parametrize(("left", "shown"), [(0.0198, "force"), (0.01, "signal of taxel 0")])
def test_a_gain_says_that_it_is_of_all_findings_and_what_became_of_the_channel_of_the_first(left, shown):
    """The sensor in which the first lies stands out, though another gained most, unless nearly nothing became of it."""
    entries = [rivals(("lag", "taxel_0"), gain={"channel": "force"}), rivals(("drift", "skin"))]
    content = findings("explained", entries=entries)
    after = {c: {"train": e, "held_out": e, "unit": "N"} for c, e in {"force": 0.01, "taxel_0": left}.items()}
    told = better(view(content | {"extended": {"rmse": after}}))
    assert told.caption.startswith(f"less error in the {shown} with everything named here together")
    beside = "Taxel 0, in which the first of the causes lies: 20.0\u00a0mN before, 19.8\u00a0mN after."
    assert (beside in told.sentences) is (shown == "force")


def test_it_is_said_where_the_picture_leaves_out_what_was_not_compared():
    whole = trace("one", True, 1)
    measured = whole.measured + 2.0 * (np.arange(whole.t.size) == 1500)
    left_out = (np.abs(np.arange(whole.t.size) - 1500) < 50).astype(float)
    v = view(findings())
    cut = replace(whole, measured=measured, left_out=left_out)
    assert cut_off(cut, 0, v, slice(None))
    assert "(axis cut)" in overlay(cut, 0, v, slice(None), 100)
    assert not cut_off(whole, 0, v, slice(None)) and not cut_off(cut, 0, v, slice(0, 1000))


def test_names_stay_as_they_are_and_no_space_is_left_before_a_full_stop():
    content = findings() | {"recordings": [{"name": "neg"}], "warnings": ["neg: odd", "rig.yaml does not say", "every session: odd"]}
    text = markdown(tell(examples.Outcome(content)))
    assert "**Nothing to gain**.\n" in text and " ." not in text
    assert all(f"- Warning: {said}" in text for said in ("neg: odd.", "rig.yaml does not say.", "Every session: odd."))


def test_what_explains_nothing_has_no_bar():
    nothing = Round((("backlash", "rig", 0.0), ("crosstalk", "taxel", -1.0)), None)
    told = [tell(examples.Outcome(findings(), rounds=rounds)) for rounds in ((nothing,), (examples.LAST_ROUND, nothing))]
    assert "evidence.png" not in pictures(told[0])
    (axes,) = pictures(told[1])["evidence.png"]().axes
    assert len(axes.patches) == len(examples.LAST_ROUND.ranked)


def test_taxels_and_rivals_are_spoken_of_as_a_person_does():
    asked = {"cause": "dead_taxel", "where": "taxel_2", "because": "taxel_2 does not follow", "needs": "a press on taxel_2"}
    entry = rivals(("drift", "skin"), ("hysteresis", "skin"))
    told = tell(examples.Outcome(findings("explained", entries=[entry]) | {"untestable": [asked]}))
    assert "taxel_2" not in markdown(told) and "| Taxel 2 does not follow. | a press on taxel 2 |" in markdown(told)
    assert "These data cannot tell it from the other name." in told.story.sure_because
