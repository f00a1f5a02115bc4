"""What belongs to one session alone is told in words for people and in numbers for programs."""

import json

import numpy as np
import pytest
from test_faults import NOISE, session

from skin_ident.criticism.courses.carriers import DEPTH, DRIVE, DRIVEN, SLOPE, ZERO
from skin_ident.criticism.courses.kinds import BEND, CONSTANT, STEPS, Course
from skin_ident.criticism.courses.words import said_of
from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.telling.telling import _once_each

MOMENTS, Z = np.array([3.0, 8.0]), np.array([0.02, -0.01])


@pytest.mark.parametrize(
    ("carrier", "shape", "unit", "sign", "moments"),
    [
        (SLOPE, STEPS, "1", 1.0, MOMENTS),
        (DEPTH, STEPS, "m", 1.0, MOMENTS),
        (ZERO, BEND, "N", 1.0, MOMENTS),
        (ZERO, CONSTANT, "N", 1.0, None),
        (DRIVE, CONSTANT, "N", -1.0, None),
        (DRIVEN, CONSTANT, "1", -1.0, None),
    ],
)
def test_every_course_has_its_numbers(carrier, shape, unit, sign, moments):
    z = Z if moments is not None else Z[:1]
    said = said_of(Course(carrier, shape, None, "taxel"), 2.0, MOMENTS if moments is not None else np.zeros(1), z)
    assert [q["value"] for q in said.sizes] == pytest.approx(list(sign * z)) and {q["unit"] for q in said.sizes} == {unit}
    assert [q.get("at_s") for q in said.sizes] == (list(moments) if moments is not None else [None])
    assert said.under_way == (shape == STEPS)
    assert not said_of(Course(carrier, shape, None, "taxel"), 7.5, MOMENTS if moments is not None else np.zeros(1), z).under_way
    assert isinstance(said, str) and json.loads(json.dumps(said)) == said


@pytest.mark.slow
def test_a_finding_of_each_session_has_the_numbers_that_it_speaks_of():
    zeros = (0.0, 0.3, -0.2)

    def moved(i):
        return session(i, lambda y, rng: y + np.array([[zeros[i]], [0.0], [0.0]]))

    findings = diagnose([moved(0), moved(1)], [moved(2)]).findings["findings"]
    (finding,) = [f for f in findings if f["cause"] == "force_offset"]
    sizes = finding["evidence"]["sessions"]
    assert set(sizes) == set(finding["evidence"]["of_each_session"]) == {f"session_{i}" for i in range(3)}
    for i, zero in enumerate(zeros):
        assert sizes[f"session_{i}"] == [{"value": pytest.approx(zero, abs=NOISE), "unit": "N"}]


def test_two_clocks_that_are_wrong_are_two_findings_and_what_was_seen_joins_one():
    depth, taxels = ({"cause": "time_shift", "where": "clock", "channel_clock": c, "evidence": {}} for c in ("clock_depth", "clock_taxels"))
    gaps = {"cause": "time_shift", "where": "clock", "evidence": {"why": "stamps jump"}}
    assert _once_each([], [depth, taxels]) == [depth, taxels]
    assert _once_each([gaps], [depth, taxels]) == [depth | {"evidence": gaps["evidence"]}, taxels]
