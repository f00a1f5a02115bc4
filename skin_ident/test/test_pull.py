"""A pull on release is found from the moments that the rest of the comparison leaves out."""

import pytest
from hide_and_seek import seek


@pytest.mark.parametrize("form", ["pull_off", "jkr"])
def test_a_skin_that_holds_on_is_found(tmp_path, form):
    found = seek(tmp_path, "adhesion", where="skin", form=form, size=1.0, seed=41)
    assert ("adhesion", "skin") in found.names, found.names


@pytest.mark.parametrize(("cause", "where"), [("stress_relaxation", "skin"), ("hysteresis", "load_cell")])
def test_what_looks_like_a_pull_is_none(tmp_path, cause, where):
    assert "adhesion" not in [c for c, _ in seek(tmp_path, cause, where=where, size=2.0, seed=43).names]
