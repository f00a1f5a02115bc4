"""A delay between two samples."""

import numpy as np
import pytest

from skin_models.effects.time_shift import SkewedClock, TimeShift
from skin_models.signals import motion

DT, HERTZ = 0.01, 5.0
T = np.arange(200) * DT
STILL = motion(T, np.zeros(T.size))


def way(t: np.ndarray) -> np.ndarray:
    return np.sin(2.0 * np.pi * HERTZ * t)


@pytest.mark.parametrize("back", [-1.6, 0.3, 0.5, 1.5, 7.2])
def test_a_delay_between_two_samples_is_no_filter(back):
    late = TimeShift(where="clock", delay=back * DT).batch(way(T), STILL)
    at = T - back * DT
    within = (at > 4.0 * DT) & (at < T[-4])
    assert np.abs(late - way(at))[within].max() < 5e-4  # a straight line between samples takes up to 1.2 %


def test_nor_is_one_that_grows():
    late = SkewedClock(where="clock", delay=0.25 * DT, skew=8000.0).batch(way(T), STILL)
    at = T - 0.25 * DT - 8e-3 * T
    assert np.abs(late - way(at))[5:].max() < 5e-4
