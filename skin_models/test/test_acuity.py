"""The designer's command: its numbers are those of `design`, its picture is one, and nonsense is refused in a sentence."""

import numpy as np
import pytest

from skin_models.acuity.__main__ import main
from skin_models.acuity.patch import Patch, looked_at
from skin_models.design import acuity
from skin_models.layout import A201_AREA, grid, row
from skin_models.spread.kernels import Gaussian


def patch(layout, **changed):
    return Patch(layout, **{"kernel": Gaussian(width=5.25e-3), "noise": 0.02, "force": 5.0, "share": 0.777, "name": "", **changed})


def test_in_the_middle_of_a_wide_patch_it_is_the_acuity_of_the_pitch():
    over = looked_at(patch(grid(8, 8, 9e-3, A201_AREA)))
    known = acuity(5.25e-3, [9e-3], force=5.0, noise=0.02, peak=0.777)[0]
    inner = np.abs(over.x) <= 4.5e-3
    assert over.error[np.ix_(inner, inner)].max() == pytest.approx(known.error_worst, rel=0.05)
    assert np.median(over.error[np.ix_(inner, inner)]) == pytest.approx(known.error_median, rel=0.05)
    assert over.error[over.inside].max() == pytest.approx(known.error_worst, rel=0.05)
    assert f"near the edge ({1e3 * over.error[over.inside].max():.3g} mm away from it)" in over.sentence()


def test_a_row_is_located_along_itself_and_a_lone_taxel_locates_nothing():
    told, alone = looked_at(patch(row(3, 8e-3))), looked_at(patch(row(1, 8e-3)))
    assert np.isfinite(told.error).all() and told.y.size < told.x.size
    assert not np.isfinite(alone.error).any() and "located nowhere" in alone.sentence()
    assert alone.force.min() == pytest.approx(alone.force[alone.y.size // 2, alone.x.size // 2], rel=1e-3)


def test_far_apart_places_tell_nothing():
    some, none = (looked_at(patch(grid(3, 3, pitch, A201_AREA))) for pitch in (17e-3, 40e-3))
    told, felt = np.isfinite(some.error), np.isfinite(none.force)
    assert 0.0 < told.mean() < 1.0 and some.error[told].max() < 0.05 and "not at all in" in some.sentence()
    assert 0.0 < felt.mean() < 1.0 and none.force[felt].max() < 1e3 and none.sentence().startswith("located nowhere; forces from 0.")
    assert "none in" in none.sentence() and "e+" not in some.sentence() + none.sentence()


def test_the_picture_is_written_and_the_numbers_are_said(tmp_path, capsys):
    assert main([str(tmp_path / "a.png"), "--pitch-mm", "8", "--columns", "3", "--rows", "2"]) == 0
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG") and [p.name for p in tmp_path.iterdir()] == ["a.png"]
    assert "mm at the worst" in capsys.readouterr().out


def test_a_layout_file_is_taken(tmp_path, capsys):
    (tmp_path / "t.csv").write_text("x_mm,y_mm\n0,0\n8,0\n0,8\n8,8\n")
    assert main([str(tmp_path / "a.png"), "--layout", str(tmp_path / "t.csv"), "--thickness-mm", "5", "--estimate-spread"]) == 0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--thickness-mm", "6"], "--estimate-spread"),
        (["--thickness-mm", "40", "--estimate-spread"], "too far"),
        (["--thickness-mm", "nan", "--estimate-spread"], "too far"),
        (["--pitch-mm", "0"], "--pitch-mm must lie"),
        (["--columns", "0"], "at least one taxel"),
        (["--columns", "-1", "--rows", "-1"], "at least one taxel"),
        (["--columns", "100000", "--rows", "100000"], "more than the 2500"),
        (["--noise-n", "0"], "--noise-n must lie"),
        (["--noise-n", "nan"], "--noise-n must lie"),
        (["--force-n", "-1"], "--force-n must lie"),
        (["--force-n", "1e300"], "--force-n must lie"),
        (["--pitch-mm", "1e300"], "--pitch-mm must lie"),
        (["--layout", "missing.csv"], "cannot read"),
    ],
)
def test_what_makes_no_sense_is_refused_in_a_sentence(tmp_path, capsys, arguments, says):
    assert main([str(tmp_path / "a.png"), *arguments]) == 2
    error = capsys.readouterr().err
    assert says in error and error.count("\n") == 1 and not list(tmp_path.iterdir())


def test_a_place_that_cannot_be_written_is_named(tmp_path, capsys):
    assert main([str(tmp_path / "no" / "a.png")]) == 2 and "cannot be written" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["a.xyz", "a", "a.png.txt", "", "."])
def test_a_name_that_no_picture_has_is_refused(tmp_path, monkeypatch, capsys, name):
    monkeypatch.chdir(tmp_path)
    assert main([name]) == 2 and "ends in .png" in capsys.readouterr().err and not list(tmp_path.iterdir())


def test_areas_are_those_of_the_taxels():
    assert looked_at(patch(grid(3, 3, 20e-3, A201_AREA))).force.min() < looked_at(patch(grid(3, 3, 20e-3, A201_AREA / 4))).force.min()
