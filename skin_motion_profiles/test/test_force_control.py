"""Force control, closed over a simulated skin: 100 Hz, and an answer that takes 30 ms as it does over ROS."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skin_motion_profiles.catalogue import entry_from_dict
from skin_motion_profiles.control import change_speed
from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.limits import Limits
from skin_motion_profiles.plan import Travel, rehearse, stages
from skin_motion_profiles.trajectory import Arc, State, Trajectory

PERIOD, DELAY = 0.01, 0.03
SEARCH = 2.0  # s, enough to find the surface


def close_loop(controlled, stiffness, damping=0.0, start=-0.0002, offset=0.0):
    """Times from contact on, depths and forces of a run on a skin F = k (x - offset) + b v that does not pull."""
    base, motion, contact_time = 0.0, Trajectory((Arc(0.1, start),)), None
    t = np.arange(0.0, controlled.duration + SEARCH, PERIOD)
    depths, forces, pending = [], [], []
    for now in t:
        while pending and pending[0][0] <= now:
            base, motion = pending.pop(0)
        s = motion.sample(now - base)
        contact = s.x > offset
        forces.append(max(stiffness * (s.x - offset) + damping * s.v, 0.0) if contact else 0.0)
        depths.append(float(s.x))
        latest_base, latest = pending[-1] if pending else (base, motion)
        state = latest.sample(now + DELAY - latest_base)
        state = State(state.x, 0.0 if abs(state.v) < 1e-9 else state.v, state.a)
        if contact_time is None and forces[-1] >= controlled.contact_n:
            contact_time = now
        later = now + DELAY
        searching = contact_time is None
        if pieces := controlled.search(state) if searching else controlled.answer(later - contact_time, state, forces[-1], DELAY):
            pending.append((later, Trajectory(tuple(pieces))))
    return t - (contact_time or 0.0), np.array(depths), np.array(forces)


def explicit(**more):
    return entry_from_dict({"type": "explicit_force", "stiffness_n_mm": 12, "deepest_mm": 1.5, "forces_n": [5, 2, 8], **more})


def test_explicit_control_follows_its_profile():
    controlled = explicit()
    t, _, force = close_loop(controlled, 12000.0)
    wanted = np.array([controlled.target(now)[0] for now in t])
    for begin, end in ((3.3, 3.9), (6.9, 7.5), (11.1, 11.7)):  # the last part of every hold
        late = (t > begin) & (t < end)
        assert np.abs(force - wanted)[late].max() < 0.02 * wanted[late].max()
    assert force.max() < 8.0 * 1.02


@settings(deadline=None, max_examples=25)
@given(st.floats(0.5, 1.0), st.floats(0.5, 20.0))
def test_explicit_control_settles_without_overshoot_where_the_guess_is_no_lower_than_the_skin(softness, force):
    controlled = explicit(forces_n=[force], hold_s=15.0, deepest_mm=4.0)
    _, _, felt = close_loop(controlled, 12000.0 * softness)
    assert felt.max() < force * 1.05 + 0.05 and abs(felt[-1] - force) < 0.02 * force + 0.01


def test_incremental_control_comes_within_increments_and_chatters_there():
    controlled = entry_from_dict({"type": "incremental_force", "force_n": 5, "deepest_mm": 1.5, "duration_s": 15})
    t, _, force = close_loop(controlled, 12000.0)
    late = force[t > 8.0]
    # While an increment is on its way the next one has been decided already: three of 0.12 N are the most.
    assert np.abs(late - 5.0).max() < 3.0 * 0.01 * 12.0 + 1e-9 and np.ptp(late) > 0.0


def test_a_tolerance_ends_the_chatter():
    content = {"type": "incremental_force", "force_n": 5, "deepest_mm": 1.5, "duration_s": 15, "tolerance_n": 0.2}
    t, _, force = close_loop(entry_from_dict(content), 12000.0)
    assert np.ptp(force[t > 8.0]) == 0.0


@pytest.mark.parametrize("content", [
    {"type": "incremental_force", "force_n": 50, "deepest_mm": 0.4, "duration_s": 6},
    {"type": "explicit_force", "forces_n": 50, "stiffness_n_mm": 1, "deepest_mm": 0.4},
])  # fmt: skip
def test_never_goes_deeper_than_told(content):
    _, depth, _ = close_loop(entry_from_dict(content), 100.0)
    assert depth.max() == pytest.approx(0.0004, abs=2e-6) and depth.max() <= 0.0004 + 1e-12


def test_search_gives_up_at_the_greatest_depth():
    controlled = explicit(deepest_mm=0.1)
    assert controlled.search(State(0.00005, 0.0, 0.0)) and not controlled.search(State(0.0001, 0.0, 0.0))


@pytest.mark.parametrize("search, overshoot", [(0.1, 0.2), (1.0, 1.0)])
def test_what_a_search_overshoots_is_its_speed_times_the_delay(search, overshoot):
    _, _, force = close_loop(explicit(forces_n=[0.3], search_mm_s=search, speed_mm_s=5), 12000.0)
    assert force.max() < 0.3 + 12.0 * search * (DELAY + PERIOD + search / 100.0) + 0.02 * overshoot


@settings(deadline=None, max_examples=300)
@given(st.floats(-0.001, 0.001), st.floats(-0.002, 0.002), st.floats(-0.02, 0.02), st.floats(0.02, 1.0))
def test_a_change_of_speed_is_continuous_and_ends_at_rest_within_its_room(x, v, wanted, acceleration):
    brake = v * abs(v) / (2.0 * acceleration)
    room = (-0.0012 + min(brake, 0.0), 0.0012 + max(brake, 0.0))  # where it can still come to rest in time
    pieces = change_speed(State(x, v, 0.0), wanted, room, acceleration)
    trajectory = Trajectory(pieces)
    speeds = trajectory.sample([0.0, trajectory.duration]).v
    assert speeds == pytest.approx([v, 0.0], abs=1e-6 * acceleration)
    assert trajectory.reach().acceleration <= acceleration * (1.0 + 1e-12)
    assert room[0] - 1e-9 <= trajectory.reach().low and trajectory.reach().high <= room[1] + 1e-9


@pytest.mark.parametrize("content, sentence", [
    ({"type": "explicit_force", "forces_n": 5, "deepest_mm": 1}, "lacks stiffness_n_mm"),
    ({"type": "explicit_force", "forces_n": -5, "stiffness_n_mm": 1, "deepest_mm": 1}, "forces_n"),
    ({"type": "incremental_force", "force_n": 5, "deepest_mm": -2}, "must exceed highest_mm"),
])  # fmt: skip
def test_mistakes_are_one_sentence(content, sentence):
    with pytest.raises(ProfileError, match=sentence):
        entry_from_dict(content)


@pytest.mark.parametrize("more, sentence", [
    ({"deepest_mm": 5}, "deepest_mm = 5 is beyond the limit of the rig, 4"),
    ({"speed_mm_s": 30}, "speed_mm_s = 30 is beyond the limit of the rig, 20"),
    ({"highest_mm": -20}, "highest_mm = -20 is beyond the limit of the rig, 10"),
])  # fmt: skip
def test_what_the_limits_forbid_is_refused(more, sentence):
    with pytest.raises(ProfileError, match=sentence):
        rehearse(stages(explicit(**more)), -0.002, Travel(0.002, 0.05), Limits(-0.01, 0.004, 0.02, 1.0))
