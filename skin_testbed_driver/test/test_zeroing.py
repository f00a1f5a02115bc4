import numpy as np
import pytest

from skin_testbed_driver.zeroing import onset


def test_a_line_that_begins_at_the_surface_is_found_in_noise():
    rng = np.random.default_rng(3)
    x = np.linspace(-1e-4, 6e-5, 700)
    u = 0.3 + 800.0 * np.maximum(x - 2e-6, 0.0) + rng.normal(0.0, 2e-3, x.size)
    assert onset([*zip(x, u, strict=True)]) == pytest.approx(2e-6, abs=1.5e-6)
