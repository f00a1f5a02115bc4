"""Rows of one test: the first of them in every run, the others with `./skin test -m slow`."""

from collections.abc import Iterable
from typing import Any

import pytest


def rows(every: Iterable[Any], quick: int) -> list[Any]:
    """All rows for `parametrize`, those after the first `quick` marked `slow`."""
    every = list(every)
    return [*every[:quick], *(pytest.param(*(r if isinstance(r, tuple) else (r,)), marks=pytest.mark.slow) for r in every[quick:])]
