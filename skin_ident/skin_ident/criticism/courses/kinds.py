"""Which courses sessions can have: what each multiplies, its shape in time, and the cause that it stands for."""

from collections.abc import Iterator
from dataclasses import dataclass

from skin_ident.criticism.courses.carriers import DELAY, DEPTH, DRIVE, DRIVEN, SLOPE, ZERO
from skin_ident.criticism.gates.gate import Gain
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.telemetry.symptom import sensor_of
from skin_ident.criticism.vocabulary import Key

CONSTANT, STEPS, BEND, WAVE = "constant", "steps", "bend", "wave"
CAUSES = {
    (ZERO, CONSTANT): "force_offset",
    (ZERO, STEPS): "force_offset",
    (ZERO, BEND): "drift",
    (SLOPE, CONSTANT): "gain_error",
    (SLOPE, STEPS): "gain_error",
    (DELAY, STEPS): "time_shift",
    (DELAY, BEND): "time_shift",
    (DEPTH, STEPS): "position_offset",
    (DRIVE, CONSTANT): "force_offset",
    (DRIVEN, CONSTANT): "gain_error",
}


@dataclass(frozen=True)
class Course:
    """One kind of course: what it multiplies (`carrier`, in channels `rows`), and its shape in time."""

    carrier: str
    shape: str
    rows: tuple[int, ...]
    where: str

    @property
    def cause(self) -> str:
        """The cause that it stands for."""
        return "drift" if self.shape == WAVE else CAUSES[self.carrier, self.shape]

    @property
    def key(self) -> Key:
        """Cause and place."""
        return self.cause, self.where

    @property
    def keys(self) -> tuple[Key, ...]:
        """Its own, and those under which the same signal goes: a force read too small is all taxels reading too much."""
        return (self.key, (self.cause, "taxel")) if self.carrier == DRIVEN else (self.key,)

    @property
    def tares(self) -> bool:
        """Whether it is a zero that lasts as long as the session, as tares leave one."""
        return self.carrier in (ZERO, DRIVE) and self.shape == CONSTANT

    @property
    def slopes(self) -> bool:
        """Whether it is a slope that lasts as long as the session."""
        return (self.carrier, self.shape) == (SLOPE, CONSTANT)

    @property
    def jumps(self) -> bool:
        """Whether it is a zero that jumps."""
        return (self.carrier, self.shape) == (ZERO, STEPS)

    @property
    def wanders(self) -> bool:
        """Whether it is a delay that bends."""
        return (self.carrier, self.shape) == (DELAY, BEND)

    def shows(self, gain: Gain) -> bool:
        """Whether a gain is where the course is; what is wrong with the force that drives a test shows in the taxels."""
        return self.carrier in (DRIVE, DRIVEN) or gain.shows_at(self.where)


def common_slope(session: Session) -> Course:
    """All channels more or less alike: no sensor, but skin that is stiffer or thinner in one session than in the other."""
    return Course(SLOPE, CONSTANT, tuple(range(len(session.channels))), "skin")


def courses(session: Session) -> Iterator[Course]:
    """Every course that sessions of this kind could have. A channel that answers nothing has none of its own; where sessions press at
    several places, a slope is the place's."""
    every = tuple(range(len(session.channels)))
    for c, channel in enumerate(session.channels):
        if channel in session.stuck:
            continue
        where = sensor_of(channel, session.n_taxels)
        kinds = [kind for kind in CAUSES if kind[0] in (ZERO, SLOPE) and not (kind == (SLOPE, CONSTANT) and session.spread is not None)]
        if session.drive is not None:
            kinds.remove((ZERO, STEPS))  # nobody knows when it is in the air
        yield from (Course(*kind, (c,), where) for kind in kinds)
    taxels = every[session.taxel_rows]
    if session.drive is not None:
        yield from (Course(DELAY, shape, taxels, "clock_taxels") for shape in (STEPS, BEND))
        yield from (Course(carrier, CONSTANT, every, "load_cell") for carrier in (DRIVE, DRIVEN))
        return
    yield Course(DEPTH, STEPS, every, "rig")
    clocks = [(every, "clock_depth")]
    if taxels and len(taxels) < len(every):
        clocks += [(every[:1], "clock"), (taxels, "clock_taxels")]
    yield from (Course(DELAY, shape, rows, where) for rows, where in clocks for shape in (STEPS, BEND))
