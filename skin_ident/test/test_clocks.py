"""Whether the stamps of two topics come from one clock, told from when they were recorded."""

import numpy as np
import pytest

from skin_ident.recordings.bag import STEP, _moved

T = np.linspace(0.0, 60.0, 92)  # s, the instants at which clocks are compared


def stalled(begin: float, length: float) -> np.ndarray:
    """A recorder that is kept from one topic: its newest stamp falls behind, and all that waited comes at once."""
    return np.where((begin < T) & (begin + length > T), begin - T, 0.0)


@pytest.mark.parametrize("begin", [10.0, 22.0, 40.0])
def test_a_recorder_that_stalled_and_caught_up_has_good_stamps(begin):
    assert _moved(stalled(begin, 8.0) + 1e-3 * np.sin(T)) < STEP


@pytest.mark.parametrize(
    "apart", [np.where(T > 5.0, 0.4, 0.0), np.where(T > 52.0, 0.4, 0.0), 0.01 * T, np.where((T > 20.0) & (T < 45.0), 0.4, 0.0)]
)
def test_clocks_that_step_or_run_away_are_two(apart):
    assert _moved(apart) > STEP
