"""The pages on reliability hold the tables that the counts give, and the counts add up."""

import re
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "bench"))
import bench_reliability as bench
from reliability_counts import DOC, interval, read


@pytest.mark.parametrize("name", bench.PAGES)
def test_the_tables_of_a_page_are_those_of_the_counts(name):
    page = (DOC / name).read_text(encoding="utf-8")
    assert bench.filled(page, read()) == page, "call bench/bench_reliability.py --write"


def test_every_world_has_its_table():
    page = (DOC / "worlds.md").read_text(encoding="utf-8")
    shown = re.findall(r"<!-- table: world (\w+) -->", page)
    assert sorted(shown) == sorted({r.text["world"] for r in read()})


@pytest.mark.parametrize(("k", "n", "low", "high"), [(0, 10, 0.0, 0.3085), (10, 10, 0.6915, 1.0), (5, 10, 0.1871, 0.8129)])
def test_an_interval_is_that_of_clopper_and_pearson(k, n, low, high):
    assert interval(k, n) == pytest.approx((low, high), abs=1e-4)


def test_what_a_target_leaves_open_is_said_to_be_open():
    assert bench.verdict(4, 2167, 0.01, at_most=True) == "met"
    assert bench.verdict(17, 368, 0.01, at_most=True) == "**missed**"
    assert bench.verdict(187, 194, 0.95, at_most=False) == "met, within error"
    assert bench.verdict(123, 145, 0.90, at_most=False) == "missed, within error"
