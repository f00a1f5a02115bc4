"""How sure page and terminal sound: of what is not settled, of gains that may be chance, of names beside others and their sizes."""

import re
from types import SimpleNamespace

import pytest
import report_examples as examples
from wording_making import findings, rivals

from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.rivals import Rival
from skin_ident.criticism.telling.findings import found
from skin_ident.report.appendix import size_ruled_out
from skin_ident.report.evidence import evidence
from skin_ident.report.story import tell
from skin_ident.report.terminal import summary


def test_what_is_left_open_is_no_all_clear():
    """Ratios that several causes would explain keep title, first screen and terminal from saying that nothing is wrong."""
    open_ = {"because": "the ratios differ (taxel_1 reads more)", "needs": "press at three places", "left_open": True}
    said = findings() | {"untestable": [{"cause": c, **open_} for c in ("crosstalk", "off_centre")]}
    told = tell(examples.Outcome(said))
    story = told.story
    assert story.headline.tone == "part" and story.headline.title == "Nothing named, but not settled: crosstalk or off centre"
    assert story.sure == "Fairly sure: 2 causes left open" and story.rebuild != "No"
    assert story.next[0] == "To settle whether it is crosstalk or off centre: press at three places." and "Until then" in story.next[-1]
    assert "not settled" in summary(said).splitlines()[0] and "would settle it: press at three places" in summary(said)
    assert "looks like noise" not in summary(said) and "not settled" in summary(findings(left=0.06) | {"untestable": said["untestable"]})


@pytest.mark.parametrize(
    ("interval", "page", "card", "line"),
    [
        ([0.02, 0.03], "The fall is 20 to 30 mN with", "20 to 30 mN", "falls by 0.02 to 0.03 N"),
        ([0.02, 0.06], "The fall is at least 20 mN with", "at least 20 mN", "falls by at least 0.02 N"),
        (
            [-0.01, 0.06],
            "This fall may be chance: the 95 % interval also allows the error to rise by 10 mN",
            "at least −10 mN",
            "rise by 0.01 N",
        ),
    ],
)
def test_no_error_is_said_to_fall_by_more_than_all_of_it(interval, page, card, line):
    gain = {"held_out_rmse_before": 0.05, "held_out_rmse_after": 0.02, "ci95": interval, "channel": "force", "unit": "N"}
    said = findings("explained", entries=[rivals(("drift", "skin"), gain=gain)])
    told = tell(examples.Outcome(said))
    assert any(page in re.sub(r"\s", " ", s) for s in told.story.better.sentences) and line in summary(said)
    assert f"<dd>{card}</dd>" in re.sub(r"\s", " ", evidence(told.outcome, told.view))


def test_a_name_of_which_neither_gain_nor_name_is_sure_is_no_plain_explanation():
    """Title, banner and terminal carry what the card says, that the gain may be chance and the name another."""
    gain = {"held_out_rmse_before": 0.05, "held_out_rmse_after": 0.02, "ci95": [-0.01, 0.04], "channel": "force", "unit": "N"}
    entry = rivals(("drift", "skin"), ("hysteresis", "skin"), gain=gain)
    for verdict, title in (("explained", "Explained, but not surely: drift"), ("partly_explained", "Partly explained, but not surely: ")):
        story = tell(examples.Outcome(findings(verdict, entries=[entry]))).story
        assert story.headline.title.startswith(title) and story.headline.tone == "part" and "Neither gain" in story.headline.line
        assert "explained, but not surely" in summary(findings(verdict, entries=[entry])).splitlines()[0]
    sure = entry | {"gain": gain | {"ci95": [0.01, 0.04]}}
    assert tell(examples.Outcome(findings("explained", entries=[sure]))).story.headline.title.startswith("Explained: drift")
    assert "not surely" not in summary(findings("explained", entries=[sure]))


def test_a_rival_that_was_fitted_has_its_size_on_screen_and_card():
    clipping, before = examples.effect("saturation", "load_cell", level=20.0), examples.Model(examples.SILICONE)
    fitted = (Rival("saturation", "load_cell", 1.0, before.extended(clipping)), Rival("drift", "load_cell", 2.0))
    gain = SimpleNamespace(carried=("force",), relative=0.9, held_out="b", entry={})
    named = Named("hysteresis", "load_cell", gain, 900.0, fitted, before)
    entry = found(named, before, {}, {})
    told = tell(examples.Outcome(findings("explained", entries=[entry])))
    sizes = {w.name: w.size for w in told.story.wrong}
    assert "20.0\u00a0N" in sizes["Or saturation in the load cell"] and sizes["Or drift in the load cell"] == ""
    assert "20.0\u00a0N" in evidence(told.outcome, told.view) and "parameters" not in entry["alternatives"][1]
    assert "(level = 20.0 N)" in summary(findings("explained", entries=[entry]))


def test_sizes_in_the_terminal_have_the_units_of_the_page_and_a_rounding_zero_is_none():
    sizes = {"onset": {"value": 2.2e-4, "unit": "m", "std": 8.1e-6}, "k_sensed": {"value": -2.3e-16, "unit": "N/m", "std": 3.7e-17}}
    said = findings("explained", entries=[rivals(("nonlinear_stiffness", "skin"), parameters=sizes)])
    story = tell(examples.Outcome(said)).story
    assert "onset = 0.220 ± 0.008 mm" in summary(said) and "k_sensed" not in summary(said) and "10⁻¹" not in story.wrong[0].size


@pytest.mark.parametrize("alone", [True, False])
def test_a_load_cell_that_stands_alone_divides_no_stiffness_by_what_taxels_feel(alone):
    sizes = {n: {"value": v, "unit": "N/m", "std": s} for n, v, s in (("k_sensed", 0.0, None), ("k_dispersed", 271.0, 8.0))}
    said = findings("explained", entries=[rivals(("stress_relaxation", "skin"), parameters=sizes)])
    said |= {"excluded": [{"cause": "hysteresis", "where": "skin", "parameter": "k_dispersed", "below": 41.0, "unit": "N/m"}]}
    for part in ("baseline", "extended") if alone else ():
        said[part]["rmse"] = {"force": said[part]["rmse"]["force"]}
    told = tell(examples.Outcome(said))
    size = told.story.wrong[0].size
    assert "271" in size and ("taxels)" in size) is not alone
    ruled_out = size_ruled_out(told.view.excluded[0], told.view)
    assert "41.0" in ruled_out and ("taxels)" in ruled_out) is not alone


@pytest.mark.parametrize(("form", "says"), [("Densification", "added beyond the onset"), ("Plateau", "lost on the plateau")])
def test_a_rivals_parameters_are_in_the_words_of_its_own_form(form, says):
    """Two forms of one cause call different things by one name."""
    entry = rivals(("position_offset", "rig"), ("nonlinear_stiffness", "skin"))
    entry["alternatives"][0] |= {"parameters": {"k_sensed": {"value": -1490.0, "unit": "N/m"}}, "forms": [form]}
    wrong = tell(examples.Outcome(findings("explained", entries=[entry]))).story.wrong
    assert any(says in w.size for w in wrong)
