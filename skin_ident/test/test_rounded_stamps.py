"""Stamps that are written with few decimals are as even as what they were rounded from."""

import numpy as np
import pytest

from skin_ident.recordings.load import load


@pytest.mark.parametrize("rate", [60.0, 120.0, 150.0, 256.0, 300.0])
@pytest.mark.parametrize("digits", [3, 4, 6])
def test_stamps_that_are_rounded_are_even(tmp_path, rate, digits):
    """The median step is then off by more than a sample in a long record, which must not be interpolated for it."""
    t = np.arange(20_000) / rate
    y = np.random.default_rng(1).standard_normal(t.size)
    rows = "".join(f"{a:.{digits}f},{b:.9g},{b:.9g}\n" for a, b in zip(t, y, strict=True))
    (tmp_path / "a.csv").write_text(f"t_s,x_mm,force_n\n{rows}")
    (found,) = load(tmp_path / "a.csv")
    assert found.dt == pytest.approx(1.0 / rate, rel=1e-5) and not any("resampled" in w for w in found.warnings)
    assert np.array_equal(found.force, np.array([float(f"{b:.9g}") for b in y]))
