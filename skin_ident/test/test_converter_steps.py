"""Steps of a converter are those of before its readings were interpolated, whether stamps tremble or samples are lost."""

import numpy as np
import pytest

from skin_ident.recordings.load import load


@pytest.mark.parametrize("jittered", [False, True])
def test_steps_of_a_converter_are_known_though_stamps_are_uneven(tmp_path, jittered):
    """Interpolated readings lie between the levels; the load cell is calibrated from volts, the encoder reads micrometres."""
    rng, n = np.random.default_rng(1), 600
    t = 0.01 * np.arange(n) + jittered * rng.uniform(-2e-3, 2e-3, n)
    pressed = np.sin(2.0 * t) ** 2 + 0.01 * rng.standard_normal((3, n))
    x, volts, taxel = (np.round(row / step) * step for row, step in zip(pressed, (2e-2, 0.05, 0.04), strict=True))
    rows = zip(t, x, -volts, taxel, strict=True)
    (tmp_path / "rig.yaml").write_text("calibration:\n  ai0: {channel: force, slope_n_per_v: -4.0, zero_v: 0.0}\n")
    (tmp_path / "a.csv").write_text("t_s,x_mm,ai0_V,taxel_0_n\n" + "".join(f"{a:.6f},{b:.6f},{c:.6f},{d:.6f}\n" for a, b, c, d in rows))
    r = load(tmp_path)[0]
    assert ("resampled" in " ".join(r.warnings)) == jittered
    assert [r.step(c) for c in ("depth", "force", "taxel_0")] == pytest.approx([2e-5, 0.2, 0.04])


def test_steps_of_a_converter_are_known_where_samples_are_lost_from_stamps_of_this_century(tmp_path):
    """Interpolated by some millionth of a step, for such stamps are no finer, and by a third of one where two samples are lost."""
    rng, n = np.random.default_rng(2), 3000
    t, kept = 1_700_000_000.25 + np.arange(n) / 160.0, rng.random(n) > 0.004
    x, taxel = (np.round((np.sin(2.0 * t) ** 2 + 0.03 * rng.standard_normal(n)) / step) * step for step in (2e-2, 0.04))
    rows = "".join(f"{a:.6f},{b:.6f},{c:.6f}\n" for a, b, c in zip(t[kept], x[kept], taxel[kept], strict=True))
    (tmp_path / "a.csv").write_text("t_s,x_mm,taxel_0_n\n" + rows)
    r = load(tmp_path)[0]
    assert "lost" in " ".join(r.warnings)
    assert [r.step(c) for c in ("depth", "taxel_0")] == pytest.approx([2e-5, 0.04])
    assert r.scaled({"taxel_0": -2.0}).step("taxel_0") == pytest.approx(0.08)
    assert r.with_channels({"taxel_0": rng.standard_normal(len(r))}).step("taxel_0") is None
