"""How what sessions have of their own goes from one to the next is said first, whatever the order of the files."""

import numpy as np
import pytest

from skin_ident.criticism.pattern import in_order, pattern, shown, when

DAYS = [f"day{n:02d}_{who}.csv" for n, who in zip((3, 5, 9, 12, 14, 18, 22, 31), ("ben", "dora") * 4, strict=True)]
RNG = np.random.default_rng(0)


@pytest.mark.parametrize(
    ("numbers", "said"),
    [
        ((1.5, 1.8, 1.5, 1.5, -2.1, -2.1, -2.1, -2.0), "steps by −3.7 % at day14_ben, from +1.6 % to −2.1 %"),
        ((-2.0, -1.5, -0.8, -0.3, 0.3, 0.9, 1.6, 2.2), "rises steadily from −2.0 % (day03_ben) to +2.2 % (day31_dora)"),
        ((2.0, 0.2, 0.0, -0.1, -0.2, -0.3, -0.5, -3.0), "falls on the whole from +2.0 % (day03_ben) to −3.0 % (day31_dora)"),
        ((0.01, -0.02, 2.0, 0.0, 0.02, -0.01, 0.0, 0.01), "is +2.0 % in day09_ben alone"),
        ((-0.5, -0.5, -0.5, 2.1, -0.5, -0.51, -0.5, -0.5), "differs by +2.6 % in day12_dora alone"),
        ((0.0, 0.01, 0.0, 0.0, 0.0, 0.01, 0.0, 2.0), "is +2.0 % in day31_dora alone"),
        ((1.0, -1.0, -1.02, 1.0, -1.0, -1.0, 1.01, -1.0), "differs by +2.0 % in day03_ben, day12_dora and day22_ben"),
        ((-1.0, -1.0, 1.0, 1.0, 1.02, -1.0, -1.0, -1.02), "differs by +2.0 % from day09_ben to day14_ben"),
        ((0.3, -1.0, 0.5, 1.2, -0.7, 0.1, -0.2, 0.9), ""),
        ((1.0,) * 8, ""),
    ],
)
def test_the_pattern_of_what_sessions_have_of_their_own(numbers, said):
    values = {name: 0.01 * x for name, x in zip(DAYS, numbers, strict=True)}
    assert pattern(values, "1") == said
    held_out_last = {name: values[name] for name in [*DAYS[1::2], *DAYS[::2]]}
    assert pattern(held_out_last, "1") == said


def test_few_numbers_and_chance_have_no_pattern():
    assert pattern(dict.fromkeys(DAYS[:3], 0.0) | {DAYS[0]: 1.0}, "1") == ""
    for n in (4, 6, 8):
        draws = RNG.standard_normal((400, n))
        assert np.mean([pattern(dict(zip(DAYS, y, strict=False)), "N") != "" for y in draws]) < 0.1


@pytest.mark.parametrize(
    ("some", "said"),
    [
        (DAYS[5:], "from day18_dora on"),
        (DAYS[:3], "until day09_ben"),
        (DAYS[4:5], "in day14_ben alone"),
        (DAYS[:1] + DAYS[2:], "in all but day05_dora"),
        (DAYS[2:5], "from day09_ben to day14_ben"),
        (DAYS[1:3], "in day05_dora and day09_ben"),
        (DAYS[:1] + DAYS[2:3] + DAYS[5:], "in 5 of 8 sessions"),
        (DAYS, "in every session"),
        ([], "in no session"),
    ],
)
def test_the_sessions_in_which_something_is_are_said_shortly(some, said):
    assert when(some, [*DAYS[1:], DAYS[0]]) == said


def test_names_are_in_natural_order_where_they_have_numbers_and_else_as_given():
    assert in_order(["s10", "s2", "s1"]) == ["s1", "s2", "s10"]
    assert in_order(["warm", "cold", "s1"]) == ["warm", "cold", "s1"]
    assert shown(["a.csv", "b.csv"]) == {"a.csv": "a", "b.csv": "b"}
    assert shown(["a.csv", "b.tsv"]) == {"a.csv": "a.csv", "b.tsv": "b.tsv"}
