"""Which courses sessions can have: what each multiplies, its shape in time, and the cause that it stands for."""

from collections.abc import Iterator
from dataclasses import dataclass

from skin_ident.criticism.courses.carriers import DELAY, DEPTH, DRIVE, DRIVEN, SLOPE, ZERO
from skin_ident.criticism.gates.gate import Gain
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.telemetry.symptom import place_of

CONSTANT, STEPS, BEND = "constant", "steps", "bend"
CAUSES = {
    (ZERO, CONSTANT): "force_offset",
    (ZERO, BEND): "drift",
    (SLOPE, STEPS): "gain_error",
    (DELAY, STEPS): "time_shift",
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
        return CAUSES[self.carrier, self.shape]

    @property
    def key(self) -> tuple[str, str]:
        return self.cause, self.where

    @property
    def keys(self) -> tuple[tuple[str, str], ...]:
        """Its own, and those under which the same signal goes: a force read too small is all taxels reading too much."""
        return (self.key, (self.cause, "taxel")) if self.carrier == DRIVEN else (self.key,)

    def shows(self, gain: Gain) -> bool:
        """Whether a gain is where the course is; what is wrong with the force that drives a test shows in the taxels."""
        return self.carrier in (DRIVE, DRIVEN) or gain.shows_at(self.where)


def courses(session: Session) -> Iterator[Course]:
    """Every course that sessions of this kind could have. A channel that answers nothing has none of its own."""
    every = tuple(range(len(session.channels)))
    for c, channel in enumerate(session.channels):
        if channel in session.stuck:
            continue
        where = place_of(channel, session.n_taxels)
        yield from (Course(carrier, shape, (c,), where) for carrier, shape in CAUSES if carrier in (ZERO, SLOPE))
    taxels = every[-session.n_taxels :] if session.n_taxels else ()
    if session.drive is not None:
        yield Course(DELAY, STEPS, taxels, "clock_taxels")
        yield from (Course(carrier, CONSTANT, every, "load_cell") for carrier in (DRIVE, DRIVEN))
        return
    yield Course(DEPTH, STEPS, every, "rig")
    yield Course(DELAY, STEPS, every, "clock_depth")
    if taxels and len(taxels) < len(every):
        yield from (Course(DELAY, STEPS, rows, where) for rows, where in ((every[:1], "clock"), (taxels, "clock_taxels")))
