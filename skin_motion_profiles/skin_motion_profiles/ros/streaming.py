"""Handing a motion to the driver in pieces: so much ahead that a pause of this process does no harm, so little that its death does none.

Times below are real time. Where the node's clock runs faster than that (a simulated rig with `time_scale`), they grow with it.
"""

import numpy as np

from skin_motion_profiles.plan import Motion
from skin_motion_profiles.ros.driver_link import DriverLink

HEAD_START = 0.2  # s from a decision to the first moment of motion
REACTION = 0.02  # s from a reason to stop to the moment from which the motion is replaced
_LOOKAHEAD = 0.5  # s of motion that the driver has in hand
_RENEWAL = 0.1  # s between two pieces
_APART = 5e-4  # s between the points of two motions
_KNOT_PERIOD = 0.02  # s between two points of a piece


class Stream:
    """One motion on its way to the driver; it begins at node time `base` (ns)."""

    def __init__(self, link: DriverLink, motion: Motion, base: int) -> None:
        """Nothing is sent before `hand_over`."""
        self.link, self.motion, self.base = link, motion, base
        self.off_since: int | None = None  # stamp (ns) of the first sample of the present stretch that is not where it should be
        self._knots, self._sent = motion.trajectory.knots(_KNOT_PERIOD), 0

    def time(self) -> float:
        """Seconds since the motion began."""
        return (self.link.now() - self.base) * 1e-9

    def planned(self, stamp: int) -> float:
        """Where the plunger should be at node time `stamp` (ns), m."""
        return float(self.motion.trajectory.sample((stamp - self.base) * 1e-9).x)

    def soon(self) -> int:
        """The node time (ns) from which another motion may replace this one: as soon as a message can be there.

        A little later where a point of this motion is near: between two points a microsecond apart a nanosecond's rounding is a jerk.
        """
        t = max(self.time() + REACTION * self.link.rate, 0.0)
        for knot in self._knots[(self._knots > t - _APART) & (self._knots < t + 20 * _APART)]:
            if abs(knot - t) < _APART:
                t = knot + _APART
        return self.base + int(t * 1e9)

    def hand_over(self, everything: bool = False) -> None:
        """Send what the driver needs next, or all that is left. Each piece begins with the last point of the one before."""
        last, until = self._knots.size - 1, self._knots.size - 1
        if not everything:
            until = min(int(np.searchsorted(self._knots, max(self.time(), 0.0) + _LOOKAHEAD * self.link.rate)), last)
        if self._sent == last or (until < last and self._knots[until] - self._knots[self._sent] < _RENEWAL * self.link.rate):
            return
        self.link.send(self.base, self.motion.trajectory, self._knots[self._sent : until + 1])
        self._sent = until
