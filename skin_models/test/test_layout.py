import numpy as np
import pytest

from skin_models.layout import A201_AREA, Layout, LayoutError, arbitrary, flat, grid, hexagonal, row

UP = [[0.0, 0.0, 1.0]]


def test_grid_is_centred_and_fills_the_plane():
    g = grid(4, 3, 5e-3)
    assert len(g) == 12 and g.pitch == pytest.approx(5e-3) and g.names[11] == "taxel_11"
    assert g.positions.mean(axis=0) == pytest.approx([0, 0, 0]) and g.area.sum() == pytest.approx(4 * 3 * 25e-6)
    assert g.positions[1] - g.positions[0] == pytest.approx([5e-3, 0, 0])


def test_hexagonal_taxels_have_six_neighbours():
    h = hexagonal(7, 7, 5e-3)
    inner = h.positions[24]
    assert np.sum(np.linalg.norm(h.positions - inner, axis=1) < 5.001e-3) == 7
    assert h.area[0] == pytest.approx(np.sqrt(3) / 2 * 25e-6)


def test_row_is_the_arrays_of_the_thesis():
    r = row(3, 14e-3)
    assert r.positions[:, 0] == pytest.approx([-14e-3, 0, 14e-3]) and r.area[0] == pytest.approx(71.33e-6, rel=1e-4)


def test_arbitrary_normals_become_unit_vectors():
    a = arbitrary([[0, 0, 0], [4e-3, 0, 0]], [[0, 0, 2], [1, 0, 1]])
    assert np.linalg.norm(a.normals, axis=1) == pytest.approx([1, 1]) and a.area[0] == pytest.approx(np.pi * 4e-6)
    assert arbitrary([[0, 0, 0]], UP).area[0] == A201_AREA


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: grid(0, 3, 5e-3), "at least one taxel"),
        (lambda: grid(2, 2, 0.0), "positive length"),
        (lambda: grid(2, 2, float("nan")), "positive length"),
        (lambda: grid(2, 2, 5e-3, area=-1.0), "area must be positive"),
        (lambda: Layout(np.empty((0, 3)), np.empty((0, 3)), np.empty(0)), "one or more"),
        (lambda: arbitrary([[0, 0, 0], [0, 0, 0]], UP * 2), "same place"),
        (lambda: arbitrary([[0, 0, 0], [np.nan, 0, 0]], UP * 2), "not finite"),
        (lambda: arbitrary([[0, 0, 0]], [[0, 0, 0]]), "direction"),
        (lambda: arbitrary([[0, 0]], [[0, 0]]), "T, 3"),
        (lambda: arbitrary([[0, 0, 0], [1, 0, 0]], UP * 2, names=("a", "a")), "all different"),
        (lambda: Layout([[0, 0, 0]], [[0, 0, 2.0]], [1e-6]), "length 1"),
        (lambda: Layout([["left", 0, 0]], UP, [1e-6]), "numbers"),
        (lambda: arbitrary([[0, 0, 0], [1, 0]], UP * 2), "numbers"),
        (lambda: flat([[0, 0, 0]]), "T, 2"),
        (lambda: grid(2.5, 3, 5e-3), "whole number"),
        (lambda: row(float("nan"), 5e-3), "whole number"),
    ],
)
def test_bad_layouts_are_refused_with_a_sentence(make, says):
    with pytest.raises(LayoutError, match=says):
        make()


def test_a_layout_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        grid(2, 2, 5e-3).positions[0] = 0.0
