"""JointTrajectory messages as trajectories of the driver."""

from builtin_interfaces.msg import Duration, Time
from trajectory_msgs.msg import JointTrajectory

from skin_testbed_driver.ros import JOINT
from skin_testbed_driver.safety import CommandError
from skin_testbed_driver.trajectory import Trajectory

_SOON = 60.0  # s, by which the stamp of a command may lie ahead: one that is farther away is of another clock


def trajectory_of(message: JointTrajectory, epoch: int, now: float) -> Trajectory:
    """The set points of `message` in s after `epoch` (ns). A stamp of zero means `now`. Raises `CommandError`."""
    if list(message.joint_names) != [JOINT]:
        raise CommandError(f"the command is for the joints {list(message.joint_names)}, and not for ['{JOINT}']")
    stamp = _nanoseconds(message.header.stamp)
    start = now if stamp == 0 else (stamp - epoch) * 1e-9
    if start > now + _SOON:
        raise CommandError(f"the command begins {start - now:.0f} s from now: check the clock of whoever sends it")
    points = message.points
    if any(len(p.positions) != 1 or len(p.velocities) > 1 for p in points):
        raise CommandError("every point of the command needs one position and at most one velocity")
    times = tuple(start + 1e-9 * _nanoseconds(p.time_from_start) for p in points)
    speeds = tuple(p.velocities[0] for p in points if len(p.velocities) == 1)
    return Trajectory(times, tuple(p.positions[0] for p in points), speeds)


def _nanoseconds(time: Time | Duration) -> int:
    return time.sec * 10**9 + time.nanosec
