import math

import numpy as np
import pytest

from skin_testbed_driver.calibration import CalibrationError, load_calibration, thesis_calibration

GOOD = """
taxels:
  taxel_0: {before: {date: 2026-03-01, slope_n_per_v: 9.4}, after: {date: 2026-03-02, slope_n_per_v: 9.6}}
  taxel_1: {before: {date: 2026-03-01, slope_n_per_v: 14.0}}
"""


def load(tmp_path, text, names=("taxel_0", "taxel_1", "taxel_2")):
    path = tmp_path / "calibration.yaml"
    path.write_text(text)
    return load_calibration(path, names)


def test_before_and_after_are_averaged_and_nobody_else_is_guessed(tmp_path):
    calibration = load(tmp_path, GOOD)
    np.testing.assert_allclose(calibration.taxels, [9.5, 14.0, math.nan])


def test_the_thesis_means():
    np.testing.assert_allclose(thesis_calibration(4).taxels, [9.408, 13.75, 10.34, 13.51], atol=0.006)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[1, 2", "cannot read"),
        ("taxel_0: 9.4", "'taxels'"),
        ("taxels: {taxel_9: {before: {date: 2026-03-01, slope_n_per_v: 9.4}}}", "taxel_9"),
        ("taxels: {taxel_0: {before: {slope_n_per_v: 9.4}}}", "date"),
        ("taxels: {taxel_0: {before: {date: yesterday, slope_n_per_v: 9.4}}}", "yesterday"),
        ("taxels: {taxel_0: {before: {date: 2026-03-01, slope_n_per_v: -1}}}", "positive"),
        ("taxels: {taxel_0: 9.4}", "before"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_in_a_sentence(tmp_path, text, words):
    with pytest.raises(CalibrationError, match=words):
        load(tmp_path, text)


def test_a_missing_file(tmp_path):
    with pytest.raises(CalibrationError, match="cannot read"):
        load_calibration(tmp_path / "none.yaml", ["taxel_0"])
