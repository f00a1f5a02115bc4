"""What a finding advises to do."""

from types import SimpleNamespace

import pytest
import report_examples as examples

from skin_ident.criticism.said import Said
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.telling.findings import advice_on, found


@pytest.mark.parametrize(
    ("courses", "said"),
    [
        ({}, "warm up"),
        ({"a": Said.of("+1.2 % at 140.0 s", [0.012], "1", [140.0], under_way=True)}, "what happened at the moments"),
        ({"a": Said.of("+1.2 % at 100.0 s", [0.012], "1", [100.0])}, "before every session"),
        ({"a": Said.of("creeps by 0.1 N", [0.1, 0.2], "N", [0.0, 9.0], crept=True)}, "crept (warm up"),
        ({"a": Said.of("close to +0.1 N", [0.1], "N")}, "before every session"),
    ],
)
def test_a_zero_that_jumped_asks_for_more_than_a_warm_up(courses, said):
    assert said in advice_on(Named("drift", "taxel", None, 0.0, (), courses=courses))


@pytest.mark.parametrize(("squares", "driven", "said"), [(1e-4, False, True), (1e-4, True, False), (0.04, False, False)])
def test_a_bend_no_larger_than_errors_of_a_screw_asks_for_another_look_at_the_depth(squares, driven, said):
    gain = SimpleNamespace(carried=("force",), relative=0.9, held_out="b", entry={}, channel="force", squares=squares)
    bend = Named("nonlinear_stiffness", "skin", gain, 1.0, ())
    entry = found(bend, examples.Model(examples.SILICONE), {}, {}, driven=driven)
    assert ("0.81 µm in depth" in entry["advice"]) == said
