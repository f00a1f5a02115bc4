"""What is ruled out is said as a share of what it could be at most, and a fitted number at the end of its range is said to be there."""

import re

import numpy as np
import pytest
import report_examples as examples
from wording_making import findings, rivals

from skin_ident.report.appendix import excluded
from skin_ident.report.charts import _band, _over
from skin_ident.report.counsel import rebuild_answer
from skin_ident.report.gains import better, quieter
from skin_ident.report.markdown import markdown
from skin_ident.report.pictures import pictures
from skin_ident.report.reading import view
from skin_ident.report.ruled_out import bound, reach, strongly, weakly
from skin_ident.report.shapes import Binned
from skin_ident.report.story import tell
from skin_ident.report.terminal import summary

ARM = {"cause": "stress_relaxation", "where": "skin", "parameter": "k_sensed", "below": 9000.0, "unit": "N/m"}
FAST, SLOW = ({"tau": {"value": tau, "unit": "s"}} for tau in (0.03, 2.0))


def told(*entries, **more):
    numbers = {name: {"value": k, "unit": "N/m"} for name, k in (("k1", 9000.0), ("k2", 3000.0))}
    content = findings(**more)
    content = content | {"baseline": content["baseline"] | {"parameters": numbers}, "excluded": list(entries)}
    return tell(examples.Outcome(content, traces=examples.nothing_wrong().traces))


def plainly(said: str) -> str:
    return re.sub(r"\s", " ", said)


def test_a_bound_that_rules_out_little_stands_apart_with_its_share_and_what_would_tell_more():
    arm = ARM | {"at": FAST, "least": {"below": 120.0, "at": SLOW}}
    offset = {"cause": "position_offset", "where": "rig", "parameter": "offset", "below": 0.9e-3, "unit": "m"}
    lag = {"cause": "lag", "where": "taxel", "parameter": "tau", "below": 9.0, "unit": "s"}  # of a time, no whole is known
    t = told(arm, ARM | {"cause": "hysteresis", "below": 600.0}, offset, lag)
    assert [e["cause"] for e in weakly(t.view)] == ["stress_relaxation", "position_offset"]
    assert [e["cause"] for e in strongly(t.view)] == ["hysteresis", "lag"]
    said = plainly(bound(arm, t.view))
    assert "relaxation time 30.0 ms (75 % of the skin's stiffness); 120 N/m at relaxation time 2.00 s (1.0 % of" in said
    assert "of the greatest depth" in bound(offset, t.view) and "5.0 %" in plainly(bound(strongly(t.view)[0], t.view))
    text, page = markdown(t), str(excluded(t.view))
    assert "| Stress relaxation in the skin | 9000" in text.partition("## Ruled out only weakly")[2]
    assert "Holds of several seconds at depth." in text and "Ruled out only weakly" in page
    assert "2 causes could be ruled out only weakly." in t.story.sure_because


def test_a_bound_over_shapes_that_are_alike_has_one_size():
    said = plainly(bound(ARM | {"at": FAST, "least": {"below": 8000.0, "at": SLOW}}))
    assert "at relaxation time 30.0 ms" in said and "8000" not in said and "2.00 s" not in said


@pytest.mark.parametrize(
    ("entry", "weak"),
    [
        ({"cause": "spread_shape", "where": "skin", "parameter": "power", "below": 0.6, "unit": "1"}, False),
        ({"cause": "hysteresis", "where": "taxel_0", "parameter": "relative", "below": 0.6, "unit": "1"}, True),
        ({"cause": "dead_zone", "where": "taxel", "parameter": "threshold", "below": 4.5, "unit": "N"}, True),
        ({"cause": "dead_zone", "where": "load_cell", "parameter": "threshold", "below": 0.1, "unit": "N"}, False),
    ],
    ids=["an exponent is no share", "a share", "half of what the taxels read", "little of what the load cell reads"],
)
def test_a_bound_is_held_against_what_its_own_sensor_reads(entry, weak):
    assert bool(weakly(told(entry).view)) is weak


def test_the_reach_is_known_only_as_far_as_it_was_recorded():
    assert reach(()) == {}
    found = reach(examples.nothing_wrong().traces)
    assert found["depth"] == pytest.approx(0.9e-3, rel=0.3) and 5.0 < found["force"] < 20.0


def softened(length: float) -> dict:
    """Stiffness with a rival whose depth scale may be at the end of its range."""
    sizes = {"k_sensed": 71e3, "k_dispersed": 32e3, "length": length}
    sizes = {name: {"value": x, "unit": "m" if name == "length" else "N/m"} for name, x in sizes.items()}
    entry = rivals(("nonlinear_stiffness", "skin"), ("cyclic_softening", "skin"))
    (rival,) = entry["alternatives"]
    return findings("explained", entries=[entry | {"alternatives": [rival | {"parameters": sizes, "forms": ["DamagedSprings"]}]}])


@pytest.mark.parametrize(("length", "at_end"), [(0.05, True), (0.0496, True), (0.5e-3, False)])
def test_a_size_at_the_end_of_its_range_is_said_to_be_there_wherever_sizes_are_shown(length, at_end):
    content = softened(length)
    t = tell(examples.Outcome(content))
    said = next(w.size for w in t.story.wrong if w.name.startswith("Or"))
    assert (", at the end of its range" in said) is at_end is ("depth scale" in said)
    assert ("at the end of its range" in summary(content)) is at_end


def test_a_floor_above_the_error_is_printed_as_it_was_measured():
    content = findings("nothing_wrong", left=0.045)
    t = tell(examples.Outcome(content))
    assert "50.0\u00a0mN" in plainly(markdown(t)).replace(" mN", "\u00a0mN") and "which may be quieter" in quieter(t.view)
    assert markdown(t).count("which may be quieter") == 1 and "which may be quieter" not in markdown(tell(examples.Outcome(findings())))


def test_zeros_that_sessions_were_allowed_are_no_gain_of_a_fault_of_the_record():
    content = findings("explained", entries=[rivals(("noise", "load_cell"), gain={})])
    after = {"force": {"train": 0.01, "held_out": 0.01, "unit": "N"}}
    gained = {"force": {"ci95": [0.01, 0.05]}}
    zeros = [{"cause": "force_offset", "where": "load_cell", "own_zero": True, "because": "tares"}]
    content |= {"extended": content["extended"] | {"rmse": after}, "gain_by_channel": gained, "untestable": zeros}
    figure = better(tell(examples.Outcome(content)).view)
    assert figure.number == "No change" and any("its own zero of the load cell" in said for said in figure.sentences)


def test_a_line_and_its_band_cover_the_same_bins():
    known = np.array([1.0, np.nan, np.nan, 2.0, 3.0])
    b = Binned(np.arange(5.0), known, known - 1.0, known + 1.0)
    x, _ = _over(b, b.median)
    assert np.array_equal(x[np.isfinite(x)], [-0.5, 0.0, 0.5, 2.5, 3.0, 4.0, 4.5])
    band = _band(b, 1.0, 1.0, "after")
    assert set(band.x[np.isfinite(band.x)]) == set(x[np.isfinite(x)]) and np.isnan(band.x).sum() == 2


def test_every_round_has_its_own_scale_and_numbers_and_every_panel_one_legend():
    drawn = pictures(tell(examples.explained()))
    first, last = drawn["evidence.png"]().axes
    assert first.get_xlim()[1] > 100.0 * last.get_xlim()[1] and "variance of the noise" in last.get_xlabel()
    assert "14.2" in [label.get_text() for label in last.texts]
    (legend,) = drawn["residual.png"]().legends
    assert [entry.get_text() for entry in legend.get_texts()] == ["what is left after", "what is left before"][::-1]


def test_of_several_findings_the_reasons_come_first_and_then_the_checks():
    """Beside a load cell that is surely at fault, no sensor is not said of the others."""
    skin = rivals(("stress_relaxation", "skin"), ("mount_compliance", "rig"))
    answer, because = rebuild_answer(view(findings("explained", entries=[rivals(("lag", "load_cell")), skin])))
    assert answer == "No taxel, but perhaps the mount"
    reasons, checks = because.split(". To check the mount: ")
    assert reasons.startswith("the reference load cell is at fault") and "none of the names" in reasons and "rigid" in checks
