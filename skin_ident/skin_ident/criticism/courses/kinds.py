"""The kinds of course: carrier, shape in time, and the cause of the catalogue that each stands for."""

from collections.abc import Iterator
from dataclasses import dataclass

from skin_ident.criticism.courses.carriers import DELAY, DEPTH, DRIVE, DRIVEN, SLOPE, ZERO
from skin_ident.criticism.gates.gate import Gain
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.telemetry.symptom import sensor_of
from skin_ident.criticism.vocabulary import FORCE_OFFSET, GAIN_ERROR, POSITION_OFFSET, Key

CONSTANT, STEPS, BEND, WAVE = "constant", "steps", "bend", "wave"
CAUSE_OF = {
    (ZERO, CONSTANT): FORCE_OFFSET,
    (ZERO, STEPS): FORCE_OFFSET,
    (ZERO, BEND): "drift",
    (SLOPE, CONSTANT): GAIN_ERROR,
    (SLOPE, STEPS): GAIN_ERROR,
    (DELAY, STEPS): "time_shift",
    (DELAY, BEND): "time_shift",
    (DEPTH, STEPS): POSITION_OFFSET,
    (DRIVE, CONSTANT): FORCE_OFFSET,
    (DRIVEN, CONSTANT): GAIN_ERROR,
}


@dataclass(frozen=True)
class Course:
    """One kind of course: its `carrier`, the channels `rows` it acts on, its `shape` in time, and its place `where`."""

    carrier: str
    shape: str
    rows: tuple[int, ...]
    where: str

    @property
    def cause(self) -> str:
        """The cause that it stands for."""
        return "drift" if self.shape == WAVE else CAUSE_OF[self.carrier, self.shape]

    @property
    def key(self) -> Key:
        """Cause and place."""
        return self.cause, self.where

    @property
    def keys(self) -> tuple[Key, ...]:
        """Its own cause and place, and other names of the same signal: a driving force read too small equals all taxels reading too
        much."""
        return (self.key, (self.cause, "taxel")) if self.carrier == DRIVEN else (self.key,)

    @property
    def tares(self) -> bool:
        """Whether it is a constant zero, such as a tare leaves."""
        return self.carrier in (ZERO, DRIVE) and self.shape == CONSTANT

    @property
    def slopes(self) -> bool:
        """Whether it is a slope that is constant over the session."""
        return (self.carrier, self.shape) == (SLOPE, CONSTANT)

    @property
    def jumps(self) -> bool:
        """Whether it is a zero that jumps."""
        return (self.carrier, self.shape) == (ZERO, STEPS)

    @property
    def wanders(self) -> bool:
        """Whether it is a delay that bends, i.e. varies piecewise linearly."""
        return (self.carrier, self.shape) == (DELAY, BEND)

    def shows(self, gain: Gain) -> bool:
        """Whether the gain is in the channels of the course; a fault of the force that drives a test shows in the taxels."""
        return self.carrier in (DRIVE, DRIVEN) or gain.shows_at(self.where)


def common_slope(session: Session) -> Course:
    """A slope that is common to all channels: no fault of a sensor, but skin that is stiffer or thinner in one session than in another."""
    return Course(SLOPE, CONSTANT, tuple(range(len(session.channels))), "skin")


def courses(session: Session) -> Iterator[Course]:
    """Every course that sessions of this kind could have. A stuck channel has none. Where sessions press at several places, constant slopes
    are left out: they belong to the place."""
    every = tuple(range(len(session.channels)))
    for c, channel in enumerate(session.channels):
        if channel in session.stuck:
            continue
        where = sensor_of(channel, session.n_taxels)
        kinds = [kind for kind in CAUSE_OF if kind[0] in (ZERO, SLOPE) and not (kind == (SLOPE, CONSTANT) and session.spread is not None)]
        yield from (Course(*kind, (c,), where) for kind in kinds)
    taxels = every[session.taxel_rows]
    if session.drive is not None:
        yield from (Course(DELAY, shape, taxels, "clock_taxels") for shape in (STEPS, BEND))
        yield from (Course(*kind, every, "load_cell") for kind in CAUSE_OF if kind[0] in (DRIVE, DRIVEN))
        return
    yield Course(DEPTH, STEPS, every, "rig")
    clocks = [(every, "clock_depth")]
    if taxels and len(taxels) < len(every):
        clocks += [(every[:1], "clock"), (taxels, "clock_taxels")]
    yield from (Course(DELAY, shape, rows, where) for rows, where in clocks for shape in (STEPS, BEND))
