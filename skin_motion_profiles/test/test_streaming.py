"""How a motion is cut into pieces for the driver, with a link that only counts."""

import math
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("skin_testbed_msgs")

from skin_motion_profiles.plan import Motion
from skin_motion_profiles.profiles.random_ramps import RandomRamps
from skin_motion_profiles.ros.streaming import Stream


@dataclass
class Wire:
    """Keeps what is sent; its clock is set by hand."""

    rate: float = 1.0
    clock: int = 10**18
    sent: list = field(default_factory=list)

    def now(self):
        return self.clock

    def send(self, base, trajectory, times):
        self.sent.append(times)


@pytest.fixture
def stream():
    trajectory = RandomRamps(seed=1, deepest_mm=1.0, count=10).trajectory()
    return Stream(Wire(), Motion(trajectory, ("ramps",), (0.0,)), 10**18)


def run(stream, step):
    for i in range(int(stream.motion.trajectory.duration / step) + 2):
        stream.link.clock = stream.base + int(i * step * 1e9)
        stream.hand_over()


@pytest.mark.parametrize("step", [0.02, 0.1, 0.35])
def test_pieces_join_and_leave_nothing_out(stream, step):
    run(stream, step)
    sent = stream.link.sent
    assert all(a[-1] == b[0] for a, b in pairwise(sent))
    whole = np.concatenate([sent[0], *(times[1:] for times in sent[1:])])
    assert np.array_equal(whole, stream.motion.trajectory.knots(0.02))


def test_the_driver_always_has_some_motion_in_hand_and_never_much(stream):
    for i in range(200):
        now = 0.02 * i
        stream.link.clock = stream.base + int(now * 1e9)
        stream.hand_over()
        assert now + 0.35 < stream.link.sent[-1][-1] < now + 0.55


def test_more_of_it_where_the_clock_is_quicker():
    trajectory = RandomRamps(seed=1, deepest_mm=1.0, count=50).trajectory()
    stream = Stream(Wire(rate=10.0), Motion(trajectory, ("ramps",), (0.0,)), 10**18)
    stream.hand_over()
    assert stream.link.sent[-1][-1] == pytest.approx(5.0, abs=0.05)


def test_a_replacement_keeps_clear_of_the_points_that_it_follows(stream):
    knots = stream.motion.trajectory.knots(0.02)
    for t in np.random.default_rng(0).uniform(0.0, 3.0, 2000):
        stream.link.clock = stream.base + int(t * 1e9)
        begin = (stream.soon() - stream.base) * 1e-9
        assert t + 0.02 - 1e-6 <= begin < t + 0.035
        assert np.abs(knots - begin).min() > 4.9e-4 or math.isclose(begin, knots[-1])
