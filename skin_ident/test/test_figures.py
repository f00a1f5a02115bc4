"""Numbers as a person reads them."""

import math

import pytest

from skin_ident.estimators.figures import figures, plus_minus


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.00312, "0.0031"), (9.96, "10"), (99.6, "100"), (1234.5, "1200"), (-31.2, "-31"), (0.0, "0"), (1e9, "1e+09"), (math.inf, "inf")],
)
def test_no_exponent_where_none_is_needed(value, text):
    assert figures(value) == text


@pytest.mark.parametrize(
    ("value", "half", "text"),
    [(12.3456, 0.0031, "12.3456 ± 0.0031"), (1318.3, 10.4, "1318 ± 10"), (10.4, 99.6, "10 ± 100"), (5.0, math.inf, "5 ± inf"),
     (5.0, 0.0, "5 ± 0")],
)  # fmt: skip
def test_value_and_error_end_at_the_same_digit(value, half, text):
    assert plus_minus(value, half) == text
