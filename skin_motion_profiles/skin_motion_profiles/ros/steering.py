"""Force control over the same topics: every force sample brings a new motion from where the plunger will be in a moment.

That moment is the time that a message needs to the driver and a little more; it is the delay of the control loop.
"""

from skin_motion_profiles.control import Controlled
from skin_motion_profiles.plan import Motion
from skin_motion_profiles.ros.driver_link import DriverLink
from skin_motion_profiles.ros.streaming import HEAD_START, REACTION, Stream
from skin_motion_profiles.trajectory import Arc, Trajectory

_AT_REST = 1e-9  # m/s


class Steering:
    """One controlled motion under way. `stream` is what the driver was told last."""

    def __init__(self, link: DriverLink, controlled: Controlled, name: str) -> None:
        self.link, self.controlled, self.name = link, controlled, name
        self.base = link.now() + int(HEAD_START * link.rate * 1e9)
        self.stream = self._told(self.base, (Arc(0.1, link.depth.value),))
        self._answered = self.base  # stamp (ns) of the last force that was answered

    @property
    def delay(self) -> float:
        """From a force to its answer, s of node time: the reaction, and a sample of the driver."""
        return REACTION * self.link.rate + 1.0 / max(self.link.state.sample_rate, 1.0)

    def time(self) -> float:
        """Seconds since the control began."""
        return (self.link.now() - self.base) * 1e-9

    def answer(self) -> None:
        """Answer the newest force, once."""
        force = self.link.force
        if force.stamp <= self._answered:
            return
        self._answered = force.stamp
        when = self.link.now() + int(REACTION * self.link.rate * 1e9)
        state = self.stream.motion.trajectory.sample((when - self.stream.base) * 1e-9)
        if abs(state.v) < _AT_REST:
            state = state._replace(v=0.0)
        if pieces := self.controlled.answer((when - self.base) * 1e-9, state, force.value):
            self.stream = self._told(when, pieces)

    def ended(self) -> bool:
        """Whether its time is over and the plunger at rest."""
        return self.time() >= self.controlled.duration and self.stream.time() >= self.stream.motion.trajectory.duration

    def _told(self, base: int, pieces: tuple) -> Stream:
        stream = Stream(self.link, Motion(Trajectory(tuple(pieces)), (self.name,), (0.0,)), base)
        stream.hand_over(everything=True)
        return stream
