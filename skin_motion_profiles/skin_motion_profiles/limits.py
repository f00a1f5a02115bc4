"""What the rig allows, and the refusal of motions that ask for more."""

from dataclasses import dataclass

from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.trajectory import Trajectory

_ROUNDING = 1.0 + 1e-6
_HAIR = 1e-9  # m


@dataclass(frozen=True)
class Limits:
    """Travel (m; the least depth lies in the air and is negative), speed (m/s) and acceleration (m/s^2)."""

    min_depth: float
    max_depth: float
    max_speed: float
    max_acceleration: float

    def check(self, trajectory: Trajectory, name: str) -> None:
        """Raise `ProfileError`, a sentence naming the limit and both numbers, if the motion leaves any of them."""
        r = trajectory.reach()
        if r.high > self.max_depth + _HAIR:
            raise ProfileError(f"{name} goes down to {r.high * 1e3:.3f} mm, but the limit of depth is {self.max_depth * 1e3:.3f} mm")
        if r.low < self.min_depth - _HAIR:
            raise ProfileError(f"{name} goes up to {r.low * 1e3:.3f} mm, but the limit in the air is {self.min_depth * 1e3:.3f} mm")
        if r.speed > self.max_speed * _ROUNDING:
            raise ProfileError(f"{name} moves at {r.speed * 1e3:.3f} mm/s, but the limit of speed is {self.max_speed * 1e3:.3f} mm/s")
        if r.acceleration > self.max_acceleration * _ROUNDING:
            raise ProfileError(
                f"{name} accelerates by {r.acceleration * 1e3:.1f} mm/s^2, but the limit is {self.max_acceleration * 1e3:.1f} mm/s^2"
            )
