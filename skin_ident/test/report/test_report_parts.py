"""Numbers, thinning, the telling window, and reading findings that nobody promised to write well."""

import re

import numpy as np
import pytest
import report_examples as examples
from hypothesis import example, given, settings
from hypothesis import strategies as st

from skin_ident.criticism.array.evidence import Fitted
from skin_ident.criticism.array.findings import form_of
from skin_ident.criticism.array.hypotheses import hypotheses
from skin_ident.criticism.array.judgement import Judged
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.array.proposing import OF_ARRAY
from skin_ident.criticism.gates.gate import EACH_IN_TURN
from skin_ident.criticism.scan.diagnose import diagnose_scans
from skin_ident.criticism.scan.family import QUANTITIES
from skin_ident.criticism.telling.outcome import Outcome, Round, Trace
from skin_ident.criticism.vocabulary import cause_at, spoken
from skin_ident.report.charts import goes_beyond, shown_range
from skin_ident.report.focus import focus
from skin_ident.report.numbers import amount, change, percent, plain, span
from skin_ident.report.page import page
from skin_ident.report.reading import view
from skin_ident.report.shapes import binned, smooth, spectrum, thinned
from skin_ident.report.story import explaining, tell
from skin_ident.report.view import HELD_OUT, STRETCHES
from skin_ident.report.words import declared, effect_words, label, rebuild
from skin_ident.spread_scan import SpreadScan
from skin_ident.thesis_spread import thesis_scan
from skin_models.catalogue import effects
from skin_models.parameter import parameters_of


def page_of(outcome: Outcome) -> str:
    return page(tell(outcome))


@pytest.mark.parametrize(
    ("name", "words"),
    [("k1", "stiffness between plunger and taxel"), ("k1_2", "stiffness between plunger and taxel, scan 2"), ("share_1", "taxel 1"),
     ("width", "width of the spread"), ("shape_power", "2: a Gaussian"), ("level_factor_1", "given model, scan 1"), ("odd_1", "odd 1")],
)  # fmt: skip
def test_every_parameter_has_words(name, words):
    assert words in label(name)


def test_every_parameter_of_the_family_of_scans_has_words():
    told_by_effects = {"bend2", "bend3", "bend4", "offset", "threshold", "ceiling", "tail", "disc", "ratio"}  # or never told by that name
    assert all(label(name) != spoken(name) for name in set(QUANTITIES) - told_by_effects)


def test_what_explains_nothing_but_rounding_is_not_ranked():
    ranked = (("lag", "taxel", 4.0), ("drift", "taxel", 0.1), ("saturation", "taxel", 4e-11), ("dead_zone", "taxel", 0.0))
    assert explaining(Round(ranked, None), 8) == list(ranked[:2])


NB, THIN = "\u00a0", "\u202f"


@pytest.mark.parametrize(
    ("value", "unit", "std", "said"),
    [
        (0.0312, "N", None, f"31.2{NB}mN"),
        (0.8, "s", 0.0123, f"0.800{NB}±{NB}0.012{NB}s"),
        (17942.3, "N/m", 3.1, f"17{THIN}942{NB}±{NB}3{NB}N/m"),
        (0.3e-3, "m", None, f"0.300{NB}mm"),
        (57834.0, "N*s/m^2", 3680.0, f"58{NB}±{NB}4{NB}N·s/m per mm"),
        (9.68, "s", 1.64, f"9.7{NB}±{NB}1.6{NB}s"),
        (12e-6, "m", 1e-7, f"12.0{NB}±{NB}0.1{NB}µm"),
        (3e8, "N/m^3", 3e6, f"(3.00{NB}±{NB}0.03){NB}×{NB}10⁸{NB}N/m³"),
        (9.996e6, "N/m", 2e4, f"(1.00{NB}±{NB}0.002){NB}×{NB}10⁷{NB}N/m"),
        (9.996e-5, "1", 1e-6, f"(1.00{NB}±{NB}0.01){NB}×{NB}10⁻⁴"),
        (-0.5, "N*s/m", None, f"−0.500{NB}N·s/m"),
        (0.25, "1", None, "0.250"),
        (float("nan"), "N", None, "–"),
        (float("inf"), "N", 1.0, "–"),
        (None, "N", None, "–"),
        (999.96, "N", None, f"1000{NB}N"),
        (0.0, "N", float("nan"), f"0{NB}N"),
    ],
)
def test_amounts_have_three_digits_a_fitting_unit_and_their_error(value, unit, std, said):
    assert amount(value, unit, std) == said


def test_values_that_are_compared_share_their_unit():
    assert [amount(v, "N", like=[0.9, 0.02]) for v in (0.9, 0.02)] == [f"0.900{NB}N", f"0.0200{NB}N"]
    assert span(0.0123, 0.2, "N") == f"0.012 to 0.20{NB}N"
    assert span(-2.75e-4, -4.97e-5, "N", [0.125]) == f"−0.00028 to −0.00005{NB}N"
    assert [change(x) for x in (0.008, -0.89, 0.0)] == [f"+0.8{NB}%", f"−89{NB}%", f"0{NB}%"]
    assert percent(-0.0001) == f"0{NB}%" and percent(0.0512) == f"5.1{NB}%"


@given(st.floats(), st.floats(0.0), st.sampled_from(["N", "m", "1", "N/m^3", "ppm", "furlong"]))
def test_no_number_prints_as_nan_or_fails(value, std, unit):
    said = amount(value, unit, std) + plain(value) + percent(value)
    assert not re.search("nan|inf|e[+-]", said)


@given(st.floats(-7.0, 9.0), st.floats(-5.0, 3.0), st.sampled_from([-1.0, 1.0]))
@example(8.9894, -0.5123, 1.0)  # 9.76e8 ± 3e8, which had been printed as (9.76 ± 3) × 10⁹
@example(-0.0044, -0.2322, 1.0)  # 0.99 ± 0.58, as 1 ± 1
def test_a_number_is_printed_as_it_is_and_so_is_its_error(exponent, relative, sign):
    value = sign * 10.0**exponent
    std = 10.0 ** (exponent + relative)
    said = amount(value, "1", std).replace(THIN, "").replace("−", "-").replace(NB, "")
    inner, power = re.fullmatch(r"\((.*)\)×10(.*)", said).groups() if said.startswith("(") else (said, "⁰")
    printed, *spread = (number(x) * number(f"1×10{power}") for x in inner.split("±"))
    assert abs(printed - value) < 0.6 * std
    assert not spread or 0.5 * std < spread[0] < 1.5 * std


def number(said: str) -> float:
    """The number of `3.2` or `3×10⁻⁴`."""
    digits, _, power = said.partition("×10")
    return float(digits) * 10.0 ** int(power.translate(str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")) or 0)


@given(st.integers(3, 40), st.integers(0, 10**6))
def test_thinning_keeps_every_bucket_s_extremes(buckets, seed):
    y = np.random.default_rng(seed).standard_normal(1000)
    y[seed % 1000] = 50.0  # a spike of one sample
    x, kept = thinned(np.arange(1000.0), y, buckets)
    assert x.size <= 2 * buckets and kept.max() == 50.0 and kept.min() == y.min()
    assert np.all(np.diff(x) > 0) and np.array_equal(y[x.astype(int)], kept)


def test_smoothing_keeps_slow_and_removes_fast_without_shifting():
    t = np.arange(2000) / 100.0
    slow, fast = np.sin(2 * np.pi * 0.5 * t), np.sin(2 * np.pi * 40.0 * t)
    inside = slice(100, -100)
    assert np.allclose(smooth(t, slow + fast, 8.0)[inside], slow[inside], atol=0.03)
    assert smooth(t, slow, None) is slow


def test_binned_medians_follow_a_line_and_leave_empty_bins_out():
    x = np.r_[np.linspace(0, 1, 500), np.linspace(2, 3, 500)]
    b = binned(x, 2.0 * x, 0.0, 3.0)
    known = np.isfinite(b.median)
    assert np.allclose(b.median[known], 2.0 * b.centre[known], atol=0.01)
    assert not known[(b.centre > 1.1) & (b.centre < 1.9)].any()


def test_spectrum_finds_a_line_at_its_frequency():
    t = np.arange(6000) / 100.0
    f, density = spectrum(t, np.sin(2 * np.pi * 7.0 * t))
    assert abs(f[np.argmax(density)] - 7.0) < 0.3


def test_the_telling_window_lies_where_the_error_was_removed():
    t = np.arange(6000) / 100.0
    truth = np.sin(t)
    wrong = truth + 0.5 * ((t > 31.0) & (t < 38.9))
    trace = Trace("s", True, t, t, t, ("force",), truth[None], wrong[None], truth[None])
    seen = focus((trace,), view({}))
    assert t[seen.start] <= 31.0 and t[seen.stop - 1] >= 38.9 and seen.words == "the most telling 10 s"


def test_where_spikes_are_the_finding_the_largest_are_shown():
    t = np.arange(6000) / 100.0
    measured = np.where((t > 20.0) & (t < 30.0), 5.0, 0.0)  # where the plunger left the skin: not compared either, and no spike
    measured[[500, 4100, 4200]] = 3.0, 9.0, 8.0
    zero, gentle = np.zeros((1, t.size)), np.full((1, t.size), 0.1)
    spiky = Trace("one", False, t, t, t, ("force",), measured[None], zero, zero, left_out=(t < 50.0).astype(float))
    found = {"cause": "outliers", "where": "load_cell", "channels": ["force"], "gain": {}}
    v = view({"findings": [found], "verdict": "explained", "noise_floor": {"force": {"band_hz": 8.0}}})
    seen = focus((spiky, Trace("held", True, t, t, t, ("force",), gentle, zero, zero)), v)
    assert seen.trace.session == "one" and seen.start <= 4100 and seen.stop > 4200


def test_every_parameter_of_every_effect_has_words():
    for cls in effects():
        names = tuple(p.name for p in parameters_of(cls))
        words = effect_words(cls.cause, next(iter(cls.places)), names)
        assert set(words) == set(names)
    assert effect_words("stress_relaxation", "skin", ("tau", "tau_2"))["tau_2"] == "relaxation time, number 2"


def test_a_parameter_is_said_in_the_words_of_its_own_form():
    """Of drift there are three forms whose `per_decade` or `rate` is a force, or a share of the reading."""
    for cls in (*OF_ARRAY, *effects()):
        for p in parameters_of(cls):
            if p.doc:
                said = declared(cls.cause, next(iter(cls.places)), (p.name,), (cls.__name__,))
                assert said[p.name].doc == p.doc, (cls.__name__, p.name)


@pytest.mark.parametrize(("form", "words"), [("Walking", "by the end of the longest session"), ("Leaning", "at the greatest depth")])
def test_a_contact_that_moves_sideways_is_no_other_zero_of_depth(form, words):
    size = {"value": 3e-4, "unit": "m"}
    found = {"cause": "off_centre", "where": "rig", "parameters": {"shift": size}, "evidence": {"forms": [form]}}
    v = view({"findings": [found], "extended": {"parameters": {"off_centre.rig.shift": size}}})
    assert [a.words for a in v.findings[0].amounts] == [f"sideways shift of the contact {words}"]
    assert [a.words for a in v.after] == [f"off centre in the rig: sideways shift of the contact {words}"]


def test_a_share_of_what_comes_smeared_is_one_of_the_sum_of_the_neighbours():
    assert effect_words("crosstalk", "taxel", ("share",), ("Smeared",)) == {"share": "share of the neighbours' sum"}
    assert effect_words("crosstalk", "taxel", ("share",), ("capacitive",)) == {"share": "share of the neighbours' sum"}
    assert effect_words("crosstalk", "taxel_1", ("share",)) == {"share": "share of the neighbours' mean"}


ROW = Layout(np.array([[-5e-3, 0.0], [0.0, 0.0], [5e-3, 0.0]]), np.zeros((2, 2)), 5e-3, True)


@pytest.mark.parametrize("h", [h for h in hypotheses(ROW, [], ["repeat_0_1"]) if h.cause == "crosstalk"], ids=lambda h: str(*h.free))
def test_the_share_of_every_form_of_static_crosstalk_is_of_what_is_repeated(h):
    form = form_of(Judged(h, 0.0, Fitted({}, {}, 0.0), None))
    words = effect_words(h.cause, h.where, ("share",), (form,))["share"]
    assert words.startswith("share of ") and words != effect_words(h.cause, h.where, ("share",))["share"]


def test_places_are_words():
    assert cause_at("gain_error", "taxel_3") == "gain error in taxel 3"
    assert cause_at("time_shift", "clock") == "time shift of the clock of the load cell"
    assert cause_at("dead_taxel", "taxel_2") == "dead taxel 2"
    assert [rebuild(*f).answer for f in (("dead_taxel", "taxel_0"), ("lag", "taxel"), ("drift", "taxel_1"), ("friction", "rig"))] == [
        "yes", "perhaps", "no", "no",
    ]  # fmt: skip


ODD = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=8) | st.sampled_from(["taxel_0", "force", "skin", "N"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["value", "unit", "cause", "where", "force", "x"]), inner),
    max_leaves=12,
)
KEYS = ["recordings", "baseline", "findings", "excluded", "untestable", "extended", "noise_floor", "warnings", "systematic_rest", "new"]
INNER = ["cause", "where", "channels", "parameters", "evidence", "gain", "alternatives", "separating_experiment"]


@settings(max_examples=150, deadline=None)
@given(
    st.dictionaries(st.sampled_from(KEYS), ODD),
    st.dictionaries(st.sampled_from(INNER), ODD),
    st.sampled_from(["explained", "unexplained", ""]),
)
def test_a_page_comes_out_of_any_findings(content, finding, verdict):
    page_of(Outcome({"findings": [finding], **content, "verdict": verdict}))


def test_a_scan_is_known_by_its_recordings_and_not_by_words_in_its_findings():
    """A scan with a model of any name and a finding of any cause was held out; a lone session with a spread that widens was not."""
    rmse = {"taxel_0": {"train": 0.01, "held_out": 0.01, "unit": "N"}}
    scan = diagnose_scans([thesis_scan("4-10")]).findings["recordings"]
    for recordings, cause, tested in ((scan, "drift", HELD_OUT), ([{"name": "a.csv"}], "spread_depth", STRETCHES)):
        model = {"model": "my silicone", "rmse": rmse}
        v = view({"recordings": recordings, "baseline": model, "extended": model, "findings": [{"cause": cause, "where": "skin"}]})
        assert v.tested == tested


def test_no_model_is_promised_where_none_is_written():
    """Nothing of a scan that never answers can be believed, and there is no extended model."""
    depth, distance = np.linspace(2e-4, 2e-3, 10), np.linspace(0.0, 1e-2, 8)
    noise = 0.01 * np.random.default_rng(0).standard_normal((depth.size, distance.size))
    outcome = diagnose_scans([SpreadScan(depth, distance, noise, name="silent.csv")])
    assert outcome.model is None and "model.yaml" not in page_of(outcome)
    assert "model.yaml (the extended model)" in page_of(examples.explained())


def test_the_words_of_the_gate_are_the_readers():
    assert view({"gain_by_channel": {"force": {"tested_on": EACH_IN_TURN}}}).in_turn


@pytest.mark.parametrize("depth", [np.nan, 0.0])
def test_sessions_without_depth_or_motion_are_drawn(depth):
    outcome = examples.explained()
    still = tuple(
        Trace(t.session, t.held_out, t.t, 0 * t.t + depth, 0 * t.t + depth, t.channels, t.measured, t.baseline, t.extended)
        for t in outcome.traces
    )
    text = page_of(Outcome(outcome.findings, traces=still))
    assert "against frequency" in text and "against depth (" not in text and "against speed<" not in text


def test_a_session_of_gaps_and_flat_lines_is_drawn():
    t = np.arange(40) / 100.0
    flat = np.zeros((1, 40))
    gappy = np.where(np.arange(40) % 7 == 0, np.nan, 1.0)[None]
    for y in (flat, gappy, np.full((1, 40), np.nan)):
        assert "<svg" in page_of(Outcome({"verdict": "unexplained"}, traces=(Trace("s", False, t, t, t, ("force",), y, flat, flat),)))


def test_an_axis_holds_what_was_not_compared_as_far_again_and_no_spike():
    rest = np.concatenate([np.linspace(-1.0, 1.0, 100), np.full(10, -2.0)])
    judged = np.arange(110) < 100
    assert shown_range([("after", "", rest)], judged) == (-2.0, 1.0)
    low, high = shown_range([("after", "", np.append(rest, 50.0))], np.append(judged, False))
    assert -2.0 <= low <= -1.0 and high == 1.0 and goes_beyond([("after", "", np.append(rest, 50.0))], np.append(judged, False))
