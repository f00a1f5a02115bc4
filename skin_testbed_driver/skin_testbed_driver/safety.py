"""What the driver never lets happen, whoever commands: the limits, and the sentences that say which one was met.

Paths are checked when they are commanded (`check_trajectory`), samples when they are read (`Guard`).
"""

import math
from dataclasses import dataclass

from skin_models.errors import SkinError
from skin_testbed_driver.calibration import LOAD_CELL_RANGE
from skin_testbed_driver.trajectory import Trajectory, extremes

# Cubics through samples of a path whose acceleration jumps overshoot it: a segment's mean is held to the limit, its peak to this multiple.
_PEAK_ACCELERATION = 2.0
_SLACK = 1e-6  # relative: rounding of a path planned exactly at a limit
_SLACK_DEPTH = 1e-9  # m


HOW_TO_RESET = "call the service reset (run skin_testbed_driver call reset)"  # with `ros2` or `./skin` before it


class CommandError(SkinError):
    """A command that the driver does not follow."""


@dataclass(frozen=True)
class Limits:
    """Depths and travel in m, speed in m/s, acceleration in m/s^2, force in N."""

    min_depth: float = -0.01
    max_depth: float = 0.004
    max_speed: float = 0.02  # the stage's own (thesis, section 3.1)
    max_acceleration: float = 1.0
    max_force: float = LOAD_CELL_RANGE
    max_following_error: float = 2e-4
    retracted_depth: float = -0.002

    def __post_init__(self) -> None:
        if not self.min_depth <= self.retracted_depth <= 0.0 < self.max_depth:
            raise SkinError(
                f"limits must be in the order min_depth ({self.min_depth}), retracted_depth ({self.retracted_depth}), 0, "
                f"max_depth ({self.max_depth})"
            )


@dataclass(frozen=True)
class Stop:
    """Why the driver stopped. `retract`: go to the retracted depth; `lost`: the depth is not known, so the axis brakes by itself."""

    reason: str
    retract: bool = False
    lost: bool = False


def check_trajectory(path: Trajectory, limits: Limits, start: float = 0.0) -> None:
    """Raise `CommandError`, a sentence with both numbers, if `path` leaves the limits anywhere between its set points too.

    A plunger that is beyond a limit of depth, at `start` (m), may go back from there, only no farther.
    """
    e = extremes(path)
    if e.deepest > max(limits.max_depth, start) + _SLACK_DEPTH:
        raise CommandError(f"the command goes to {_mm(e.deepest)}, deeper than the limit of {_mm(limits.max_depth)}")
    if e.lowest < min(limits.min_depth, start) - _SLACK_DEPTH:
        raise CommandError(f"the command goes to {_mm(e.lowest)}, beyond the limit of {_mm(limits.min_depth)} in the air")
    if e.speed > limits.max_speed * (1.0 + _SLACK) + 1e-6:
        raise CommandError(f"the command reaches {_mm(e.speed)}/s, faster than the limit of {_mm(limits.max_speed)}/s")
    most = limits.max_acceleration * (1.0 + _SLACK) + 1e-3
    if e.acceleration > most or e.peak_acceleration > _PEAK_ACCELERATION * most:
        worst = max(e.acceleration, e.peak_acceleration)
        raise CommandError(f"the command reaches {worst:.3g} m/s^2, more than the limit of {limits.max_acceleration:.3g} m/s^2")


@dataclass(frozen=True)
class Guard:
    """The checks of every sample. Each returns a `Stop` or None."""

    limits: Limits
    travel: tuple[float, float]  # m, of the stage

    def check(self, position: float, depth: float, target: float, force: float) -> Stop | None:
        """`position` of the stage, measured and wanted depth (m), force (N). What is NaN has failed."""
        return self._encoder(position, depth, target) or self._force(force)

    def _encoder(self, position: float, depth: float, target: float) -> Stop | None:
        if math.isnan(position):
            return Stop("the encoder gives no fresh reading", lost=True)
        if not self.travel[0] <= position <= self.travel[1]:
            return Stop(f"the stage is at {_mm(position)}, outside its travel of {_mm(self.travel[0])} to {_mm(self.travel[1])}")
        if abs(depth - target) > self.limits.max_following_error:
            return Stop(f"the stage does not follow: it is at {_mm(depth)} and should be at {_mm(target)}")
        return None

    def _force(self, force: float) -> Stop | None:
        if math.isnan(force):
            return Stop("the load cell gives no fresh reading")
        if math.isinf(force):
            return Stop("the load cell is at the end of its range: nobody knows how great the force is", retract=True)
        if abs(force) > self.limits.max_force:
            return Stop(f"the force is {_newtons(force)}, more than the limit of {_newtons(self.limits.max_force)}", retract=True)
        return None


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.3f} mm"


def _newtons(force: float) -> str:
    return f"{force:.1f} N" if abs(force) >= 1.0 else f"{force:.3g} N"
