import math

import numpy as np
import pytest

from skin_testbed_driver.motion import Activity, Motion
from skin_testbed_driver.safety import CommandError, Limits, Stop
from skin_testbed_driver.trajectory import Trajectory

LIMITS = Limits()
OMEGA = 2.0 * math.pi * 0.5


def sine(begin: float, end: float, start: float = 0.0) -> Trajectory:
    """A piece of x = 0.5 mm (1 - cos) that began at `start`."""
    t = np.arange(begin, end + 1e-9, 0.02)
    x, v = 5e-4 * (1.0 - np.cos(OMEGA * (t - start))), 5e-4 * OMEGA * np.sin(OMEGA * (t - start))
    return Trajectory(tuple(t.tolist()), tuple(x.tolist()), tuple(v.tolist()))


def at_zero() -> Motion:
    return Motion(LIMITS, 0.0)


def test_streamed_pieces_are_one_path():
    motion = at_zero()
    motion.follow(sine(0.0, 0.5), 0.0)
    for i in range(1, 20):
        motion.follow(sine(0.1 * i, 0.1 * i + 0.5), 0.1 * i)
    for t in np.arange(1.9, 2.2, 0.001):
        assert motion.advance(t)[0] == pytest.approx(5e-4 * (1.0 - math.cos(OMEGA * t)), abs=1e-9)
    assert motion.stopped is None


def test_silence_brakes_within_the_limits_and_says_so():
    motion = at_zero()
    motion.follow(sine(0.0, 0.5), 0.0)
    t = np.arange(0.0, 1.0, 0.001)
    v = np.array([motion.advance(s)[1] for s in t])
    assert motion.activity(1.0) is Activity.STOPPED
    assert "ran out" in motion.stopped.reason
    assert v[-1] == 0.0
    assert np.abs(np.diff(v) / 0.001).max() <= LIMITS.max_acceleration * 1.001


def test_a_path_that_ends_at_rest_ends_ready():
    motion = at_zero()
    motion.follow(Trajectory((1.0,), (1e-3,), (0.0,)), 0.0)
    assert motion.activity(0.5) is Activity.MOVING
    assert motion.advance(2.0) == (1e-3, 0.0)
    assert motion.activity(2.0) is Activity.READY


def test_a_command_replaces_what_lies_after_its_first_point():
    motion = at_zero()
    motion.follow(Trajectory((1.0, 2.0), (5e-4, 1e-3), (0.0, 0.0)), 0.0)
    motion.follow(Trajectory((1.0, 2.0), (5e-4, 0.0), (0.0, 0.0)), 0.5)
    assert motion.at(2.0)[0] == 0.0


def test_a_late_command_counts_from_now_on():
    motion = at_zero()
    motion.follow(sine(0.0, 0.5), 0.0)
    motion.follow(sine(0.2, 0.9), 0.35)
    assert motion.at(0.7)[0] == pytest.approx(5e-4 * (1.0 - math.cos(OMEGA * 0.7)), abs=1e-9)


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (Trajectory((0.1,), (3e-3,), (0.0,)), "faster"),
        (Trajectory((0.012,), (1e-4,), (0.0,)), "m/s\\^2"),
        (Trajectory((0.0, 0.2), (1e-3, 1e-3), (0.0, 0.0)), "jumps"),
        (Trajectory((10.0,), (1.0,), (0.0,)), "deeper"),
        (Trajectory((10.0,), (-1.0,), (0.0,)), "in the air"),
        (Trajectory((1.0, 1.0), (0.0, 0.0), (0.0, 0.0)), "order"),
        (Trajectory((1.0,), (math.nan,), (0.0,)), "finite"),
        (Trajectory((1.0, 2.0), (1e300, -1e300), (0.0, 0.0)), "point 1e\\+300 m from the surface, and no stage"),
        (Trajectory((1.0, 2.0), (0.0, 1e-3), (-1e308, 0.0)), "point passed at 1e\\+308 m/s"),
        (Trajectory((1.0, 2.0, 3.0), (1e308, 0.0, -1e308), ()), "no stage"),
        (Trajectory((), (), ()), "one position"),
        (Trajectory((-2.0, -1.0), (0.0, 0.0), (0.0, 0.0)), "clock"),
        (Trajectory((0.5,), (3.99e-3,), (0.019,)), "deeper"),  # there is no room left to brake
    ],
)
def test_what_cannot_be_followed_is_refused_in_a_sentence_and_changes_nothing(command, words):
    motion = at_zero()
    with pytest.raises(CommandError, match=words) as refused, np.errstate(over="raise", invalid="raise"):
        motion.follow(command, 0.0)
    assert len(str(refused.value)) < 120
    assert motion.at(5.0) == (0.0, 0.0)


def test_points_without_speeds_are_followed_smoothly():
    motion = at_zero()
    motion.follow(Trajectory((1.0, 2.0, 3.0), (1e-3, 2e-3, 2.5e-3), ()), 0.0)
    assert motion.at(2.0)[0] == 2e-3
    assert motion.at(3.0) == (2.5e-3, 0.0)


def test_over_force_turns_round_from_full_speed_without_exceeding_the_acceleration():
    motion = at_zero()
    motion.follow(Trajectory((0.1, 0.15), (1e-3, 2e-3), (0.02, 0.02)), 0.0)
    motion.stop(Stop("too much", retract=True), 0.12)
    t = np.arange(0.12, 1.0, 0.001)
    states = np.array([motion.advance(s) for s in t])
    assert states[-1].tolist() == pytest.approx([LIMITS.retracted_depth, 0.0])
    assert np.abs(np.diff(states[:, 1]) / 0.001).max() <= LIMITS.max_acceleration * 1.001


def test_a_stop_needs_a_reset_and_a_reset_needs_rest():
    motion = at_zero()
    motion.follow(sine(0.0, 0.5), 0.0)
    motion.stop(Stop("why not"), 0.3)
    with pytest.raises(CommandError, match="reset"):
        motion.follow(sine(0.3, 0.5), 0.3)
    with pytest.raises(CommandError, match="moves"):
        motion.reset(0.0, 0.3)
    motion.reset(motion.at(1.0)[0], 1.0)
    assert motion.activity(1.0) is Activity.READY


def test_only_an_over_force_overrides_an_earlier_stop():
    motion = at_zero()
    motion.stop(Stop("first"), 0.0)
    motion.stop(Stop("second"), 0.0)
    assert motion.stopped.reason == "first"
    motion.stop(Stop("third", retract=True), 0.0)
    assert motion.stopped.reason == "third"


@pytest.mark.parametrize("gap", [1e-9, 1e-6, 1e-4, 3e-3, 9e-3, 1.1e-2])
@pytest.mark.parametrize("lead", [1e-3, 0.05])
def test_a_splice_beside_a_set_point_is_no_jerk(gap, lead):
    """A new piece begins a moment after a set point of the old path, and is rounded to nanometres as messages are."""
    motion = at_zero()
    motion.follow(sine(0.0, 0.9), 0.0)
    begin = 0.4 + gap
    piece = sine(begin, begin + 0.5)
    piece = Trajectory(piece.t, tuple(round(x, 9) for x in piece.x), tuple(round(v, 9) for v in piece.v))
    motion.advance(begin - lead)
    motion.follow(piece, begin - lead)
    for t in np.arange(begin - lead, begin + 0.5, 0.001):
        assert motion.at(t)[0] == pytest.approx(5e-4 * (1.0 - math.cos(OMEGA * t)), abs=3e-8)


@pytest.mark.parametrize("lead", [0.0, 1e-6, 1e-3, 5e-3, 9e-3])
def test_a_command_may_begin_where_a_resting_stage_is_measured(lead):
    motion = at_zero()
    motion.follow(Trajectory((1.0,), (1e-3,), (0.0,)), 0.0)
    measured = 1e-3 - 5e-6  # a rest error
    motion.follow(Trajectory((2.0 + lead, 3.0), (measured, 0.0), (0.0, 0.0)), 2.0)
    assert motion.at(2.0 + lead)[0] == measured and motion.at(3.0)[0] == 0.0


def test_set_points_that_repeat_each_other_are_one():
    motion = at_zero()
    motion.follow(Trajectory((1.0, 1.000001, 2.0, 2.000001), (1e-4, 1.001e-4, 3e-4, 3.001e-4), (0.0,) * 4), 0.0)
    assert motion.at(1.000001)[0] == 1.001e-4 and motion.at(3.0)[0] == 3.001e-4


def test_set_points_that_are_near_in_time_and_apart_in_depth_stay_refused():
    with pytest.raises(CommandError, match="the limit of"):
        at_zero().follow(Trajectory((1.0, 1.0001), (1e-4, 2e-4), (0.0, 0.0)), 0.0)
