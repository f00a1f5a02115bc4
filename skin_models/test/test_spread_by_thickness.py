import numpy as np
import pytest

from skin_models.errors import ModelError
from skin_models.materials import material, silicone
from skin_models.spread.finite import Finite
from skin_models.spread.kernels import Gaussian
from skin_models.spread.noted import kernel_of
from skin_models.spread_by_thickness import DISTANCES, silicone_spread, with_spread


def test_where_it_was_measured_it_is_the_measured_one():
    width = silicone_spread(4e-3)
    assert width.value == material("silicone_4mm").spread_width == 5.25e-3 and width.std == pytest.approx(0.045e-3, abs=2e-6)


def test_it_is_not_extrapolated_unless_asked():
    for thickness in (2e-3, 3.9e-3, 6e-3):
        with pytest.raises(ModelError, match=r"measured at 4 mm, not at .* extrapolate=True"):
            silicone_spread(thickness)
    with pytest.raises(ModelError, match="too far"):
        silicone_spread(20e-3, extrapolate=True)


def test_the_discs_of_plunger_and_taxel_alone_are_almost_as_wide_as_the_scan():
    """Two even discs overlapping, by counting points: the least width that any skin can show, and most of the 5.25 mm."""
    rng = np.random.default_rng(0)
    points = rng.uniform(-4.95e-3, 4.95e-3, (200_000, 2))
    points = points[np.hypot(*points.T) < 4.95e-3]
    overlap = np.array([np.mean(np.hypot(points[:, 0] - r, points[:, 1]) < 9.53e-3 / 2) for r in DISTANCES])
    kernel = Finite(Gaussian(width=0.25e-3), 9.53e-3 / 2, 4.95e-3)
    assert kernel.shape(DISTANCES) == pytest.approx(overlap / overlap[0], abs=0.01)
    assert silicone_spread(2e-3, extrapolate=True).value == pytest.approx(5.19e-3, abs=0.01e-3)


def test_thicker_skin_spreads_more_and_is_less_certain():
    widths = [silicone_spread(h, extrapolate=True) for h in np.linspace(2e-3, 6e-3, 9)]
    assert np.all(np.diff([w.value for w in widths]) >= 0.0) and np.all(np.diff([w.std for w in widths[4:]]) > 0.0)
    thick = widths[-1]
    assert thick.by_layer < thick.value < thick.by_share and thick.by_share - thick.by_layer < 2.0 * thick.std
    assert (thick.value, thick.std) == pytest.approx((5.6e-3, 1.0e-3), abs=0.1e-3)


def test_an_estimated_spread_goes_with_the_model():
    skin = with_spread(silicone(6e-3))
    assert np.isnan(silicone(6e-3).spread_width)
    assert kernel_of(skin.model.notes) == Gaussian(width=skin.spread_width)
    assert skin.spread_width == silicone_spread(6e-3, extrapolate=True).value
