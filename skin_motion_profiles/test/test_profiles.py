"""What holds for every profile, whatever its parameters."""

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings
from strategies import PARAMETERS, all_profile_kinds, profiles

from skin_motion_profiles.catalogue import entry_from_dict
from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.limits import Limits
from skin_motion_profiles.profiles.multisine import Multisine
from skin_motion_profiles.profiles.random_ramps import RandomRamps
from skin_motion_profiles.profiles.sine import Sine
from skin_motion_profiles.profiles.stair_step import StairStep
from skin_motion_profiles.profiles.straight_line import StraightLine

START = -0.0005  # m, where relative profiles begin


def fine(trajectory, n=4001):
    t = np.linspace(0.0, trajectory.duration, n)
    return t, trajectory.sample(t)


def test_every_kind_is_tried():
    assert set(PARAMETERS) == all_profile_kinds()


@settings(deadline=None, max_examples=60)
@given(profiles())
def test_speed_is_the_derivative_of_depth(profile):
    trajectory = profile.trajectory(START)
    t, s = fine(trajectory)
    reach, h = trajectory.reach(), t[1] - t[0]
    # The mean speed of an interval differs from the trapezoid of its ends by at most the acceleration times the interval.
    assert np.abs(np.diff(s.x) - 0.5 * h * (s.v[1:] + s.v[:-1])).max() <= 0.5 * reach.acceleration * h**2 + 1e-12
    assert np.abs(np.diff(s.v)).max() <= reach.acceleration * h * 1.001 + 1e-12


@settings(deadline=None, max_examples=40)
@given(profiles())
def test_acceleration_is_the_derivative_of_speed_inside_pieces(profile):
    for piece in profile.trajectory(START).pieces:
        t = np.linspace(0.0, piece.duration, 20001)
        s = piece.at(t)
        error = np.abs(np.gradient(s.v, t) - s.a)[1:-1].max()
        rounding = 1e-15 * piece.reach().speed / (t[1] - t[0])
        assert error <= 2e-3 * piece.reach().acceleration + rounding + 1e-9


@settings(deadline=None, max_examples=60)
@given(profiles())
def test_begins_and_ends_at_rest(profile):
    trajectory = profile.trajectory(START)
    s = trajectory.sample([-1.0, 0.0, trajectory.duration, trajectory.duration + 1.0])
    assert np.abs(s.v).max() < 1e-12
    assert s.x[0] == pytest.approx(trajectory.start, abs=1e-12) == s.x[1]
    assert s.x[3] == pytest.approx(trajectory.end, abs=1e-12) == s.x[2]


@settings(deadline=None, max_examples=60)
@given(profiles())
def test_never_goes_beyond_what_its_reach_says(profile):
    trajectory = profile.trajectory(START)
    _, s = fine(trajectory)
    reach = trajectory.reach()
    hair = 1e-3 * (reach.high - reach.low) + 1e-9
    assert reach.low - hair <= s.x.min() and s.x.max() <= reach.high + hair
    assert np.abs(s.v).max() <= reach.speed * 1.001 + 1e-12 and np.abs(s.a).max() <= reach.acceleration * 1.001 + 1e-12


@settings(deadline=None, max_examples=40)
@given(profiles())
def test_limits_admit_what_fits_and_name_what_does_not(profile):
    trajectory = profile.trajectory(START)
    r = trajectory.reach()
    Limits(r.low, r.high, r.speed, r.acceleration).check(trajectory, "it")
    with pytest.raises(ProfileError, match="limit of depth"):
        Limits(-1.0, r.high - 1e-6, 1.0, 1e3).check(trajectory, "it")
    with pytest.raises(ProfileError, match="limit in the air"):
        Limits(r.low + 1e-6, 1.0, 1.0, 1e3).check(trajectory, "it")
    if r.speed > 0.0:
        with pytest.raises(ProfileError, match="limit of speed"):
            Limits(-1.0, 1.0, 0.99 * r.speed, 1e3).check(trajectory, "it")
        with pytest.raises(ProfileError, match="accelerates"):
            Limits(-1.0, 1.0, 1.0, 0.99 * r.acceleration).check(trajectory, "it")


@settings(deadline=None, max_examples=60)
@given(profiles())
def test_cubics_through_its_knots_are_the_motion(profile):
    """What a driver makes of the knots, interpolating cubic Hermite: less than a tenth of the encoder's micrometre off."""
    trajectory = profile.trajectory(START)
    knots = trajectory.knots(0.02)
    k = trajectory.sample(knots)
    t = np.linspace(0.0, trajectory.duration, 3001)
    i = np.clip(np.searchsorted(knots, t, side="right") - 1, 0, knots.size - 2)
    h, u = np.diff(knots)[i], (t - knots[i]) / np.diff(knots)[i]
    cubic = (
        (2 * u**3 - 3 * u**2 + 1) * k.x[i] + (u**3 - 2 * u**2 + u) * h * k.v[i]
        + (3 * u**2 - 2 * u**3) * k.x[i + 1] + (u**3 - u**2) * h * k.v[i + 1]
    )  # fmt: skip
    assert np.abs(cubic - trajectory.sample(t).x).max() < 1e-7


@settings(deadline=None, max_examples=60)
@given(profiles())
def test_is_a_pure_function_of_time(profile):
    trajectory, again = profile.trajectory(START), type(profile)(**vars_of(profile)).trajectory(START)
    t = np.linspace(-0.1, trajectory.duration + 0.1, 500)
    forwards, backwards = trajectory.sample(t), again.sample(t[::-1])
    assert np.array_equal(forwards.x, backwards.x[::-1]) and np.array_equal(forwards.v, backwards.v[::-1])
    assert np.allclose(forwards.x[::10], [trajectory.sample(one).x for one in t[::10]], rtol=0.0, atol=1e-15)


def vars_of(profile):
    return {name: getattr(profile, name) for name in (f.name for f in fields(profile))}


def test_sine_is_the_thesis_formula_between_its_leads():
    """Eq 29 with the phase counted from the trough."""
    profile = Sine(amplitude_mm=0.3, frequency_hz=0.5, offset_mm=0.5, periods=4)
    t = np.linspace(2.0, 10.0, 2001)
    expected = 0.5e-3 - 0.3e-3 * np.cos(2 * np.pi * 0.5 * (t - 2.0) + np.pi)
    assert np.allclose(profile.trajectory().sample(t).x, expected, atol=1e-15)
    assert profile.trajectory().duration == pytest.approx(12.0)


def test_sine_begins_without_a_jolt():
    s = Sine(amplitude_mm=0.3, frequency_hz=2.0).trajectory().sample(np.array([0.0, 1e-4]))
    assert s.x[0] == 0.0 and s.v[0] == 0.0 and abs(s.a[0]) < 1e-12 and abs(s.a[1]) < 1e-3


def test_stair_step_is_a_pyramid():
    profile = StairStep(depth_mm=1.0, steps=4, speed_mm_s=1.0, hold_s=1.0)
    _, s = fine(profile.trajectory(), 100001)
    stairs = np.round(s.x[np.abs(s.v) < 1e-9] * 1e3, 6)
    assert sorted(set(stairs)) == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert profile.trajectory().duration == pytest.approx(9 * 1.0 + 8 * (0.25 + 0.01))


def test_relative_and_absolute_lines():
    assert StraightLine(by_mm=0.4).trajectory(0.0003).end == pytest.approx(0.0007)
    assert StraightLine(to_mm=0.4).trajectory(0.0003).end == pytest.approx(0.0004)


def test_multisine_has_only_the_lines_it_says():
    profile = Multisine(seed=5, amplitude_mm=0.4, base_frequency_hz=0.2, highest_hz=5.0, periods=1)
    period = 1.0 / 0.2
    t = period + period * np.arange(4096) / 4096  # the one period at full size
    spectrum = np.abs(np.fft.rfft(profile.trajectory().sample(t).x)) / 4096
    loud = np.flatnonzero(spectrum[1:] > 1e-9) + 1
    assert loud.tolist() == profile.excited_lines.tolist()
    assert set(profile.odd_detection_lines) == set(range(1, 26, 2)) - set(loud) and profile.odd_detection_lines.size == 3
    assert all(line % 2 == 0 for line in profile.even_detection_lines)


def test_multisine_uses_the_whole_amplitude():
    reach = Multisine(seed=5, amplitude_mm=0.4, offset_mm=0.5).trajectory().reach()
    assert max(reach.high - 0.5e-3, 0.5e-3 - reach.low) == pytest.approx(0.4e-3, rel=2e-3)


@pytest.mark.parametrize("cls, more", [(RandomRamps, {"deepest_mm": 1.0}), (Multisine, {"amplitude_mm": 0.4})])
def test_seed_decides_and_only_the_seed(cls, more):
    one, same, other = (cls(seed=seed, **more).trajectory() for seed in (1, 1, 2))
    t = np.linspace(0.0, one.duration, 500)
    assert np.array_equal(one.sample(t).x, same.sample(t).x)
    assert not np.allclose(one.sample(t).x, other.sample(t).x)


def test_random_ramps_make_no_tiny_moves():
    turns = [p.x0 for p in RandomRamps(seed=1, deepest_mm=1.0, count=200, longest_hold_s=0.0).trajectory().pieces if p.v0 == 0.0]
    assert np.abs(np.diff(turns))[:-1].min() > 0.0999e-3


def test_a_profile_that_does_nothing_is_refused():
    with pytest.raises(ProfileError, match="does not move"):
        entry_from_dict({"type": "hold", "duration_s": 0}).trajectory()
