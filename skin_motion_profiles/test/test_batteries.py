"""Batteries: time adds up, arguments reach every number, and all files can be run on the standard rig."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import profiles

from skin_motion_profiles.battery_file import battery_names
from skin_motion_profiles.catalogue import entry_from_dict
from skin_motion_profiles.entry import leaves
from skin_motion_profiles.limits import Limits
from skin_motion_profiles.plan import Stage, Travel, rehearse, stages, stop
from skin_motion_profiles.profile import Profile
from skin_motion_profiles.profiles.battery import Battery
from skin_motion_profiles.trajectory import State

TRAVEL = Travel(0.002, 0.05)
RIG = Limits(-0.01, 0.004, 0.02, 1.0)
START = -0.002


@settings(deadline=None, max_examples=60)
@given(st.lists(profiles(), min_size=1, max_size=4))
def test_time_adds_up(parts):
    motion = Stage(tuple(parts), tuple(p.kind for p in parts)).motion(START, TRAVEL)
    here, now = START, 0.0
    for part, begin in zip(parts, motion.begins, strict=True):
        own = part.trajectory(here)
        assert begin == pytest.approx(now)
        way = abs(own.start - here)
        approach = way / 0.002 + 0.002 / 0.05 if way >= 0.002**2 / 0.05 else 2.0 * np.sqrt(way / 0.05)
        approach = 0.0 if way < 1e-9 else approach  # less than any encoder sees
        t = np.linspace(0.0, own.duration, 200)
        assert np.allclose(motion.trajectory.sample(now + approach + t).x, own.sample(t).x, atol=1e-9)
        now += approach + own.duration
        here = own.end
    assert motion.trajectory.duration == pytest.approx(now)


@settings(deadline=None, max_examples=60)
@given(st.lists(profiles(), min_size=1, max_size=3))
def test_a_battery_lasts_as_long_as_its_rehearsal_says(parts):
    plan = stages(Battery(profiles=tuple(parts), rest_s=0.3))
    everything = Limits(-1.0, 1.0, 1.0, 1e6)
    assert len(plan) == 1
    assert rehearse(plan, START, TRAVEL, everything) == (plan[0].motion(START, TRAVEL).trajectory.duration,)


@pytest.mark.parametrize("name", sorted(battery_names()))
def test_every_battery_runs_on_the_standard_rig(name):
    rehearse(stages(entry_from_dict({"battery": name})), START, TRAVEL, RIG)


@pytest.mark.parametrize("name", sorted(set(battery_names()) - {"prepare"}))
def test_every_battery_begins_and_ends_in_free_air(name):
    kinds = [e.kind for e in leaves(entry_from_dict({"battery": name}))]
    assert kinds[0] == "free_air" == kinds[-1]


@pytest.mark.parametrize("depth", [0.3, 0.8, 1.5])
@pytest.mark.parametrize("name", ["full", "demo"])
def test_depth_is_an_argument(name, depth):
    motion = stages(entry_from_dict({"battery": name, "depth_mm": depth, "seed": 7}))[0].motion(START, TRAVEL)
    assert motion.trajectory.reach().high == pytest.approx(depth * 1e-3, rel=1e-6)


def test_full_battery_excites_what_the_criticism_needs():
    """Free air at both ends, speeds from 0.1 to 10 mm/s, holds of 3 s at several depths, about a minute."""
    parts = list(leaves(entry_from_dict({"battery": "full"})))
    loops = [p for p in parts if p.kind == "constant_rate_loops"]
    speeds = {speed for p in loops for speed in p.speeds_mm_s}
    assert min(speeds) <= 0.1 and max(speeds) >= 10.0 and len(speeds) >= 5
    assert len({depth for p in loops for depth in p.depths_mm}) >= 4
    assert [(len(p.depths_mm), p.hold_s) for p in parts if p.kind == "constant_strain_hold"] == [(3, 3.0)]
    assert {"minor_loops", "sine", "multisine", "random_ramps"} <= {p.kind for p in parts}
    assert 50.0 < stages(Battery(profiles=tuple(parts)))[0].motion(START, TRAVEL).trajectory.duration < 70.0


def test_sessions_differ_by_seed_alone():
    one, same, other = (stages(entry_from_dict({"battery": "full", "seed": s}))[0].motion(START, TRAVEL).trajectory for s in (1, 1, 2))
    t = np.linspace(0.0, one.duration, 3000)
    assert np.array_equal(one.sample(t).x, same.sample(t).x) and not np.allclose(one.sample(t).x, other.sample(t).x)


@pytest.mark.parametrize("thickness, depth", [(2, 0.3), (4, 1.0), (6, 1.5)])
def test_thesis_depths_by_thickness(thickness, depth):
    for name in ("sinusoidal_identification", "pseudo_random_validation"):
        parts = [p for p in leaves(entry_from_dict({"battery": f"{name}_{thickness}mm"})) if isinstance(p, Profile)]
        assert max(p.trajectory().reach().high for p in parts) == pytest.approx(depth * 1e-3, rel=0.1)


def test_actions_divide_a_battery_into_stages():
    content = {"type": "battery", "profiles": [
        {"type": "free_air"}, {"type": "tare"}, {"type": "zero"}, {"type": "step", "depth_mm": 1}, {"type": "hold", "duration_s": 1},
    ]}  # fmt: skip
    plan = stages(entry_from_dict(content))
    assert [s.names for s in plan] == [("1/5 free_air",), ("2/5 tare",), ("3/5 zero",), ("4/5 step", "5/5 hold")]
    assert [s.is_motion for s in plan] == [True, False, False, True]


def test_lateral_scan_moves_sideways_in_the_air_only():
    parts = list(leaves(entry_from_dict({"type": "lateral_scan", "offsets_mm": [0, 2], "angle_deg": 90, "x_mm": 1, "depth_mm": 0.5})))
    assert [p.kind for p in parts] == ["free_air", "place", "free_air", "step"] * 2 + ["free_air"]
    assert (parts[5].x_mm, parts[5].y_mm) == (pytest.approx(1.0), pytest.approx(2.0))


@settings(deadline=None)
@given(st.floats(-0.002, 0.003), st.floats(-0.02, 0.02), st.floats(0.05, 2.0), st.sampled_from([None, -0.002]))
def test_a_stop_brakes_within_the_limits_and_ends_where_it_should(x, v, acceleration, back):
    limits = Limits(-1.0, 1.0, 0.02, acceleration)
    trajectory = stop(State(x, v, 0.0), limits, back, Travel(0.01, acceleration))
    if trajectory is None:
        assert v == 0.0 and (back is None or x <= back + 1e-12)  # to rounding, as below
        return
    limits.check(trajectory, "stop")
    assert trajectory.start == pytest.approx(x, abs=1e-12)
    rest = x + v * abs(v) / (2 * acceleration)
    assert trajectory.end == pytest.approx(rest if back is None else min(back, rest), abs=1e-12)  # only backwards
    assert trajectory.sample(trajectory.duration).v == pytest.approx(0.0, abs=1e-12)


def test_who_hits_something_above_the_retracted_depth_leaves_it_backwards():
    limits, travel = Limits(-0.01, 0.004, 0.02, 1.0), Travel(0.01, 1.0)
    assert stop(State(-0.005, 0.0, 0.0), limits, -0.002, travel, clear=0.002).end == pytest.approx(-0.007)
    assert stop(State(-0.009, 0.0, 0.0), limits, -0.002, travel, clear=0.002).end == pytest.approx(-0.01)
    assert stop(State(0.001, 0.0, 0.0), limits, -0.002, travel, clear=0.002).end == pytest.approx(-0.002)
    assert stop(State(-0.005, 0.0, 0.0), limits, -0.002, travel) is None
