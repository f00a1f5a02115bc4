"""Entries of findings.json on what is not found: the smallest bound beside the largest, and the skin of a lone session."""

from skin_ident.criticism.search.bounds import _weakest
from skin_ident.criticism.search.hardware import specimens_do


def entry(below: float, tau: float | None = None, **more) -> dict:
    at = {} if tau is None else {"at": {"tau": {"value": tau, "unit": "s"}}}
    return {"cause": "stress_relaxation", "where": "skin", "parameter": "k_sensed", "below": below, "unit": "N/m", **at, **more}


def test_the_smallest_bound_over_the_shapes_stands_beside_the_largest():
    each = [entry(10400.0, 0.03), entry(150.0, 2.0), entry(400.0, 2.0), entry(500.0, 0.5), entry(9.0, 5.0, parameter="k_dispersed")]
    said = _weakest([(e["below"], e) for e in each])
    assert said == each[0] | {"least": {"below": 400.0, "at": each[1]["at"]}}  # of one shape, the largest holds
    assert "least" not in _weakest([(1.0, entry(3.0)), (0.5, entry(2.0))])  # no shape
    assert "least" not in _weakest([(1.0, entry(3.0, 0.1)), (0.5, entry(2.0, 0.1))])  # one shape


def test_the_skin_of_a_lone_session_does_not_differ_between_sessions():
    lone, several = specimens_do({"k1": 0.01}, lone=True), specimens_do({"k1": 0.01})
    assert "between sessions" in several.because and "sessions of one specimen" in several.needs
    assert "between sessions" not in lone.because and "k1 by up to 1 %" in lone.because and lone.needs.startswith("a second session")
