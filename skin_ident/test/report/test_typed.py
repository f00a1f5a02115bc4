"""What the report decides by is said in fields of findings.json; sentences may say it as they like."""

import pytest
import report_examples as examples
from wording_making import findings, rivals

from skin_ident.criticism.telemetry.faults import UNLIKE
from skin_ident.criticism.telemetry.symptom import Symptom
from skin_ident.criticism.telling.telling import _simulated
from skin_ident.criticism.vocabulary import CAUSES
from skin_ident.report.appendix import why_untestable
from skin_ident.report.reading import view
from skin_ident.report.sizes import sizes
from skin_ident.report.story import tell

REACH = {"reach": {"value": 1e-5, "unit": "m"}}
ALL = {"in_model": True, "predicts_nothing_for": True}


@pytest.mark.parametrize("left_open", [True, False])
def test_what_leaves_several_causes_open_is_said_once_on_the_first_screen(left_open):
    reason = {"because": "taxel_1 reads otherwise than declared", "needs": "a scan"} | ({"left_open": True} if left_open else {})
    open_to = [{"cause": cause} | reason for cause in ("off_centre", "gain_error")]
    wrong = tell(examples.Outcome(findings() | {"untestable": open_to})).story.wrong
    assert [w.means for w in wrong if w.name == "Not settled"] == ["Taxel 1 reads otherwise than declared."] * left_open


def test_one_form_that_cannot_be_told_is_not_said_to_be_all_of_a_cause():
    form = {"cause": "gain_error", "where": "taxel", "form": "", "because": "a constant one looks like another stiffness"}
    v = view({"excluded": [{"cause": "gain_error", "where": "taxel", "form": "step", "below": 0.1}], "untestable": [form]})
    assert why_untestable(v.untestable[0], v) == "A constant one looks like another stiffness."


def test_a_ratio_of_one_is_no_size_and_a_ratio_of_none_is():
    for recovery, told in ((1.1, False), (0.1, True)):
        parameters = {"tau": {"value": 0.3, "unit": "s", "std": 0.01}, "recovery": {"value": recovery, "unit": "1", "std": 0.2}}
        entry = rivals(("lag", "taxel_0"), parameters=parameters)
        said = sizes(view(findings("explained", entries=[entry])).findings[0], view(findings("explained", entries=[entry])))
        assert any("ratio" in s for s in said) is told


@pytest.mark.parametrize(
    ("unlike", "predicts", "known"),
    [(True, False, {"in_model": False}), (False, True, {"in_model": True}), (False, False, ALL)],
)
def test_a_finding_says_for_programs_what_it_says_in_a_sentence(unlike, predicts, known):
    symptom = Symptom("adhesion", "skin", ("force",), REACH, {UNLIKE: True} if unlike else {})
    said = _simulated(symptom, predicts)
    assert {k: bool(v) for k, v in said.items() if k in ("in_model", "predicts_nothing_for")} == known
    assert said["simulated"].startswith("yes" if known["in_model"] else "no")


def test_what_is_done_instead_of_a_model_speaks_of_none():
    assert all("model" not in (c.instead or "") for c in CAUSES) and next(c for c in CAUSES if c.name == "adhesion").instead
