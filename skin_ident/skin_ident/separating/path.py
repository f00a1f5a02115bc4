"""Turns a battery into the sampled motion that the profile server would make."""

import numpy as np

from skin_models.signals import Motion
from skin_motion_profiles.entry import Entry
from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.limits import Limits
from skin_motion_profiles.picture import motions_of
from skin_motion_profiles.plan import Travel, stages
from skin_motion_profiles.profile_file import entry_from_text

START = -1e-3  # m, above the surface
TRAVEL = Travel(speed=5e-3, acceleration=0.5)  # m/s, m/s^2 between profiles, where little is learnt; the profile server's default is slower


def within(deepest: float) -> Limits:
    """The limits of the thesis's rig (its section 3.1), with a largest depth of `deepest` (m)."""
    return Limits(min_depth=-5e-3, max_depth=deepest, max_speed=20e-3, max_acceleration=1.0)


def planned(entry: Entry, dt: float, limits: Limits | None = None) -> Motion:
    """The whole motion of a battery, sampled every `dt` s, from rest above the surface.

    Raises `ProfileError` where the battery is not a single uninterrupted motion, or leaves the limits.
    """
    rows = stages(entry)
    if len(rows) != 1 or not rows[0].is_motion:
        raise ProfileError(f"{entry.label} does not consist of motions alone")
    trajectory = rows[0].motion(START, TRAVEL).trajectory
    if limits is not None:
        limits.check(trajectory, entry.label)
    t = np.arange(int(trajectory.duration / dt) + 1) * dt
    return Motion(t, *trajectory.sample(t), dt)


def lasts(battery: str) -> float:
    """How long a battery (YAML text) takes from the surface, with the profile server's usual moves between profiles, s, as `plot` shows."""
    return sum(m.trajectory.duration for m in motions_of(entry_from_text(battery), 0.0))
