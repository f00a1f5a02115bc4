"""Force control over the same topics: every force sample brings a new motion from where the plunger will be in a moment.

That moment is the time that a message needs to the driver and a little more; it is the delay of the control loop. The control's own
time begins at contact, which is searched for first.
"""

from skin_motion_profiles.control import Controlled
from skin_motion_profiles.moves import hold
from skin_motion_profiles.plan import Motion
from skin_motion_profiles.ros.driver_link import DriverLink, Heard
from skin_motion_profiles.ros.streaming import HEAD_START, REACTION, Stream
from skin_motion_profiles.trajectory import Piece, Trajectory

_AT_REST = 1e-9  # m/s
_TAIL = 0.5  # s of rest after every motion, so that one that arrives late can still be taken over


class Steering:
    """One controlled motion under way. `stream` is what the driver was told last."""

    def __init__(self, link: DriverLink, controlled: Controlled, name: str) -> None:
        """Begin a moment from now, where the plunger stands; `name` is for the sentences of errors."""
        self.link, self.controlled, self.name = link, controlled, name
        self.begin = link.now() + int(HEAD_START * link.rate * 1e9)
        self.contact: int | None = None  # node time (ns) at which the control began
        self.lost = False  # no contact down to the greatest depth
        self.stream = self._told(self.begin, hold(link.standing, 0.1))
        self._answered = self.begin  # stamp (ns) of the last force that was answered

    @property
    def delay(self) -> float:
        """From a force to its answer, s of node time: the reaction, and a sample of the driver."""
        return REACTION * self.link.rate + 1.0 / max(self.link.state.sample_rate, 1.0)

    def time(self) -> float:
        """Seconds since contact, 0 before."""
        return 0.0 if self.contact is None else (self.link.now() - self.contact) * 1e-9

    def answer(self) -> None:
        """Answer the newest force, once."""
        force = self.link.force
        if force.stamp <= self._answered or self.time() >= self.controlled.duration:
            return
        self._answered = force.stamp
        if self.contact is None and force.value >= self.controlled.contact_n:
            self.contact = force.stamp
        when = self.stream.soon()
        if pieces := self._pieces(when, force):
            self.stream = self._told(when, pieces)

    def _pieces(self, when: int, force: Heard) -> tuple[Piece, ...]:
        state = self.stream.motion.trajectory.sample((when - self.stream.base) * 1e-9)
        if abs(state.v) < _AT_REST:
            state = state._replace(v=0.0)
        if self.contact is not None:
            return self.controlled.answer((when - self.contact) * 1e-9, state, force.value, (when - force.stamp) * 1e-9)
        pieces = self.controlled.search(state)
        self.lost = not pieces
        return pieces

    def over(self) -> bool:
        """Whether its time is over: what remains is the end of the last motion."""
        return self.time() >= self.controlled.duration

    def _told(self, base: int, pieces: tuple[Piece, ...]) -> Stream:
        moving = Trajectory(pieces)
        trajectory = Trajectory((*pieces, *hold(moving.end, _TAIL)))
        stream = Stream(self.link, Motion(trajectory, (self.name,), (0.0,)), base)
        stream.hand_over(everything=True)
        return stream
