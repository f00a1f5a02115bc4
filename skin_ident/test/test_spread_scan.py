import numpy as np
import pytest

from skin_ident.spread_scan import SpreadScan, SpreadScanError

DEPTH, DISTANCE = [1e-4, 2e-4], [0.0, 1e-3, 3e-3]


def test_holds_arrays():
    scan = SpreadScan(DEPTH, DISTANCE, np.ones((2, 3)))
    assert scan.force.shape == (2, 3) and scan.depth[1] == 2e-4


@pytest.mark.parametrize(
    ("depth", "distance", "force", "says"),
    [
        (DEPTH, DISTANCE, np.ones((3, 2)), "shape"),
        ([0.0, 1e-4], DISTANCE, np.ones((2, 3)), "positive"),
        (DEPTH, [0.0, 0.0, 1e-3], np.ones((2, 3)), "increasing"),
        (DEPTH, [0.0, np.nan, 1e-3], np.ones((2, 3)), "increasing"),
        (DEPTH, DISTANCE, [[1, np.nan, 1], [1, 1, 1]], "finite"),
        (DEPTH, DISTANCE, [[1, np.inf, 1], [1, 1, 1]], "finite"),
    ],
)
def test_refuses_what_is_no_scan(depth, distance, force, says):
    with pytest.raises(SpreadScanError, match=says):
        SpreadScan(depth, distance, force)
