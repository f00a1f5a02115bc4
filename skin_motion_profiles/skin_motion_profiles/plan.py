"""From profiles to one motion: a smooth approach to where each profile begins, and the names of the stretches for the feedback."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from skin_motion_profiles.limits import Limits
from skin_motion_profiles.moves import brake, brake_end, line
from skin_motion_profiles.profile import Profile
from skin_motion_profiles.trajectory import State, Trajectory


@dataclass(frozen=True)
class Travel:
    """How to move where no profile says how: speed (m/s) and acceleration (m/s^2)."""

    speed: float
    acceleration: float

    def within(self, limits: Limits) -> "Travel":
        """The same, but never quicker than the rig allows."""
        return Travel(min(self.speed, limits.max_speed), min(self.acceleration, limits.max_acceleration))


@dataclass(frozen=True)
class Motion:
    """A trajectory whose stretches have names: the i-th begins at `begins[i]` s."""

    trajectory: Trajectory
    names: tuple[str, ...]
    begins: tuple[float, ...]

    def name_at(self, t: float) -> str:
        """Name of the stretch that runs at time `t`."""
        return self.names[max(int(np.searchsorted(self.begins, t, side="right")) - 1, 0)]


def motion(profiles: Iterable[Profile], start: float, travel: Travel) -> Motion:
    """The profiles one after the other from rest at depth `start` (m), each approached from where the last one ended.

    Raises `ProfileError` for a profile that neither moves nor lasts.
    """
    pieces, names, begins, here, now = [], [], [], start, 0.0
    for profile in profiles:
        own = profile.trajectory(here)
        approach = line(here, own.start, travel.speed, travel.acceleration)
        pieces += [*approach, *own.pieces]
        names.append(profile.kind)
        begins.append(now)
        now += own.duration + sum(p.duration for p in approach)
        here = own.end
    return Motion(Trajectory(tuple(pieces)), tuple(names), tuple(begins))


def stop(state: State, limits: Limits, retract_to: float | None, travel: Travel) -> Trajectory | None:
    """From the middle of a motion to rest, and then to the depth `retract_to` (m), or nowhere for None. None where already there."""
    pieces = brake(state, limits.max_acceleration)
    if retract_to is not None:
        pieces += line(brake_end(state, limits.max_acceleration), retract_to, travel.speed, travel.acceleration)
    return Trajectory(pieces) if pieces else None
