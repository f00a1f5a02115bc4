"""Layouts from a table: what it may say, and that a slip in it is never read as a number."""

import pytest

from skin_models.layout import LayoutError
from skin_models.layout_file import load_layout


def test_a_layout_file_gives_positions_normals_and_areas(tmp_path):
    path = tmp_path / "taxels.csv"
    path.write_text(
        "# a finger tip\nname, x_mm, y_mm, z_mm, nx, ny, nz, area_mm2\nleft, -2, 0, 1, -1, 0, 1, 4\nright, 2, 0, 1, 1, 0, 1, 4\n"
    )
    layout = load_layout(path)
    assert layout.names == ("left", "right") and layout.positions[1] == pytest.approx([2e-3, 0, 1e-3])
    assert layout.normals[0] == pytest.approx([-(0.5**0.5), 0, 0.5**0.5]) and layout.area == pytest.approx([4e-6, 4e-6])
    path.write_text("x_m,y_m\n0,0\n0.004,0\n")
    assert load_layout(path).names == ("taxel_0", "taxel_1")
    path.write_text("\ufeffx_mm,y_mm\r\n0,0\r\n4,0\r\n", encoding="utf-8")  # as a spreadsheet writes it
    assert load_layout(path).positions[1] == pytest.approx([4e-3, 0.0, 0.0])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "header and one or more"),
        ("x_mm,y_mm\n", "header and one or more"),
        ("x,y\n1,2\n", "positions need a unit"),
        ("x_mm,y_mm\n1,two\n", "no number"),
        ("x_mm,y_mm\n1\n", "1 cells under a header of 2"),
        ("x_mm,y_mm\n1,5,2,5\n", "4 cells under a header of 2"),
        ("x_mm,y_mm,area_mm\n1,2,3\n", "column 'area_mm'"),
        ("x_mm,y_mm,x_m\n1,2,3\n", "x is given in two columns"),
        ("x_mm,y_mm,area_mm2\n1,2,0\n", "must be positive"),
        ("x_mm,y_mm\n1,nan\n", "not finite"),
        ("x_mm,y_mm\n1,2\n1,2\n", "same place"),
        ("x_mm,y_mm,nx\n1,2,0\n", "no column ny"),
    ],
)
def test_bad_layout_files_are_refused_with_the_file_named(tmp_path, text, says):
    path = tmp_path / "taxels.csv"
    path.write_text(text)
    with pytest.raises(LayoutError, match=says) as error:
        load_layout(path)
    assert "taxels.csv" in str(error.value)
    with pytest.raises(LayoutError, match="cannot read"):
        load_layout(tmp_path / "missing.csv")
